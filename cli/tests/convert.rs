//! `convert`: the same schedule in another format, or what is lost.

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::fs;
use std::path::Path;

use support::{Said, Scratch, call, case_file};

fn convert(from: &Path, to: &Path, more: &[&str]) -> Said {
    let words = ["convert", from.to_str().unwrap(), to.to_str().unwrap()];
    call(&[&words[..], more].concat())
}

fn analysed(path: &Path) -> serde_json::Value {
    call(&["analyze", path.to_str().unwrap(), "--at", "0", "--format", "json"]).json()
}

#[test]
fn a_schedule_behaves_the_same_through_all_three_formats_and_back() {
    let scratch = Scratch::new();
    for case in ["smaarte_fig4.csv", "smaarte_nine_tasks.csv", "smaarte_preempt.csv"] {
        let mut from = case_file(case);
        let expected = analysed(&from);
        for name in ["a.toml", "b.txt", "c.csv", "d.toml"] {
            let to = scratch.path(name);
            let said = convert(&from, &to, &[]);
            assert_eq!(said.code, 0, "{case} as {name}: {said:?}");
            assert_eq!(analysed(&to), expected, "{case} as {name}");
            from = to;
        }
    }
}

#[test]
fn no_file_is_written_over_itself() {
    let scratch = Scratch::new();
    let text = "# what nobody should lose\n[[task]]\nid = 1\nrun = 'true'\n";
    let path = scratch.file("a.toml", text);
    let other = scratch.path("b.toml");
    std::os::unix::fs::symlink(&path, &other).unwrap();
    for to in [&path, &other] {
        let said = convert(&path, to, &["--lossy"]);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(said.err.contains("over itself"), "{said:?}");
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
    }
}

const RICH: &str = "
[[task]]
id = 3
dur = 5
run = 'sleep 5'
restart = 'on_failure'
restart_limit = 2
interval = 60
mandatory = true
";

#[test]
fn what_the_target_cannot_hold_is_listed_and_nothing_is_written_unless_that_is_meant() {
    let scratch = Scratch::new();
    let rich = scratch.file("rich.toml", RICH);
    let poor = scratch.path("poor.csv");
    let said = convert(&rich, &poor, &[]);
    assert_eq!(said.code, 1, "{said:?}");
    for field in ["restart", "mandatory"] {
        assert!(said.err.contains(field), "{field}: {said:?}");
    }
    assert!(said.err.contains("task 3") && said.out.contains("--lossy"), "{said:?}");
    assert!(!poor.exists(), "nothing is written");

    let said = convert(&rich, &poor, &["--lossy", "--format", "json"]);
    assert_eq!(said.code, 0, "{said:?}");
    let converted = said.json();
    assert_eq!((&converted["written"], &converted["tasks"]), (&true.into(), &1.into()));
    let lost: Vec<_> = converted["not_held"].as_array().unwrap().iter().collect();
    assert!(lost.iter().all(|one| one["task"] == 3 && one["why"].is_string()), "{converted}");
    assert!(fs::read_to_string(&poor).unwrap().contains("sleep 5"));
}

#[test]
fn a_schedule_with_mistakes_is_not_converted() {
    let scratch = Scratch::new();
    let to = scratch.path("bad.toml");
    let said = convert(&case_file("bad_schedule.csv"), &to, &[]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("bad_schedule.csv:9"), "{said:?}");
    assert!(!to.exists());
}

#[test]
fn a_target_that_names_no_format_is_wrong_usage() {
    let scratch = Scratch::new();
    let said = convert(&case_file("smaarte_fig4.csv"), &scratch.path("out.xls"), &[]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains(".toml"), "{said:?}");
}
