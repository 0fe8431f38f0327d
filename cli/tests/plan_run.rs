//! `plan run`: what it prints, what it writes, how it ends.

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::fs;
use std::path::Path;

use support::{Said, Scratch, call, root};

fn text(path: &Path) -> &str {
    path.to_str().expect("a path of letters")
}

/// Executes the winter sol.
fn winter(more: &[&str]) -> Said {
    let sols = root().join("examples/sols");
    let [plan, parameters, state] =
        ["winter/plan.xml", "parameters.xml", "winter/state.xml"].map(|name| sols.join(name));
    let mut words = vec!["plan", "run", text(&plan), "-p", text(&parameters), "-s", text(&state)];
    words.extend(more);
    call(&words)
}

#[test]
fn the_help_says_what_can_go_wrong_and_how_it_ends() {
    let said = call(&["plan", "run", "--help"]);
    assert_eq!(said.code, 0, "{said:?}");
    for word in ["--random", "--campaign", "sensors_silent", "Exit codes"] {
        assert!(said.out.contains(word), "{word}: {}", said.out);
    }
}

#[test]
fn equal_seeds_give_equal_bytes_and_others_do_not() {
    let [a, b, c] = ["3", "3", "4"].map(|seed| winter(&["--seed", seed, "--format", "json"]));
    assert_eq!((a.code, &a.err[..]), (0, ""), "{a:?}");
    assert_eq!(a.out, b.out);
    assert_ne!(a.out, c.out);
    assert_eq!(a.json()["violations"].as_array().map(Vec::len), Some(0));
}

#[test]
fn what_happened_is_told_and_drawn() {
    let scratch = Scratch::new();
    let svg = scratch.path("happened.svg");
    let said = winter(&["--svg", text(&svg)]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("starts") && said.out.contains("no rule was broken"), "{}", said.out);
    assert!(fs::read_to_string(&svg).expect("a picture").starts_with("<svg"));
}

#[test]
fn the_plan_as_it_stands_is_not_compared_with_itself() {
    let of = |said: &Said| (said.json()["static"].is_null(), said.json()["won"].is_null());
    assert_eq!(of(&winter(&["--static", "--format", "json"])), (true, true));
    assert_eq!(of(&winter(&["--format", "json"])), (false, false));
}

#[test]
fn faults_that_make_no_sense_are_refused() {
    let scratch = Scratch::new();
    let refused = |faults: &str| {
        let path = scratch.file("faults.json", faults);
        let said = winter(&["--faults", text(&path)]);
        assert_eq!(said.code, 1, "{said:?}");
        assert_eq!(said.out, "");
        said.err
    };
    assert!(refused("[{").contains("no list of faults"));
    let nowhere = r#"[{"heater_dead": {"zone": "nowhere", "from": 0, "until": 1}}]"#;
    assert!(refused(nowhere).contains("there is no zone `nowhere`"));
    let said = winter(&["--faults", "/nonexistent.json"]);
    assert!(said.code == 1 && said.err.contains("cannot be read"), "{said:?}");
}

#[test]
fn what_is_neither_files_nor_random_is_wrong_usage() {
    for words in [
        &["plan", "run"][..],
        &["plan", "run", "--random", "plan.xml"],
        &["plan", "run", "--random", "--campaign", "0"],
    ] {
        let said = call(words);
        assert_eq!(said.code, 2, "{words:?}: {said:?}");
    }
}

#[test]
fn a_random_execution_is_seen_again_by_its_seed() {
    let [a, b] = [(); 2].map(|()| call(&["plan", "run", "--random", "--seed", "11"]));
    assert_eq!(a.code, 0, "{a:?}");
    assert_eq!(a.out, b.out);
}

#[test]
fn a_random_campaign_in_which_too_little_came_up_fails() {
    let said = call(&["plan", "run", "--random", "--campaign", "1", "--seed", "14"]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.out.contains("no abort at the hard limit from seed 14 to 14"), "{}", said.out);
    let said = winter(&["--campaign", "1", "--format", "json"]);
    assert_eq!(said.code, 0, "a given plan owes nothing: {said:?}");
    assert_eq!(said.json()["summary"]["executions"], 1);
}
