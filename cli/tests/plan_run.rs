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

#[test]
fn everything_that_the_ground_wants_is_left_in_a_directory_and_can_be_read_again() {
    let scratch = Scratch::new();
    let left = scratch.path("left/sol-1");
    let said = winter(&["--products", text(&left), "--format", "json"]);
    assert_eq!(said.code, 0, "{said:?}");
    let json = |name: &str| -> serde_json::Value {
        let content = fs::read(left.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        serde_json::from_slice(&content).expect("a document")
    };
    assert_eq!(json("happened.json"), said.json()["trace"]);
    let program = json("versions.json")["program"].clone();
    assert_eq!(program, format!("faregate {}", env!("CARGO_PKG_VERSION")));
    let rounds = json("rounds.json").as_array().map_or(0, Vec::len);
    assert_eq!(said.json()["summary"]["replans"], rounds - 1, "{rounds}");
    let [plan, parameters, state] =
        ["plan.xml", "parameters.xml", "0001/state.xml"].map(|name| left.join(name));
    let said = call(&["plan", "check", text(&plan), text(&parameters), text(&state)]);
    assert_eq!((said.code, &said.err[..]), (0, ""), "{said:?}");
    // The first timed plan is what anybody makes of these files.
    let again = scratch.path("again.json");
    let words = ["plan", "make", text(&plan), "-p", text(&parameters), "-s", text(&state)];
    let made = call(&[&words[..], &["--out", text(&again)]].concat());
    assert_eq!(made.code, 0, "{made:?}");
    let again: serde_json::Value =
        serde_json::from_slice(&fs::read(&again).expect("a timed plan")).expect("a document");
    assert_eq!(again, json("0001/schedule.json"));
}

#[test]
fn products_are_left_where_nothing_is() {
    let scratch = Scratch::new();
    let file = scratch.file("file", "");
    let refused = |path: &Path, why: &str| {
        let said = winter(&["--products", text(path)]);
        assert_eq!((said.code, &said.out[..]), (1, ""), "{said:?}");
        assert!(said.err.contains(why), "{said:?}");
    };
    refused(&scratch.path(""), "it is not empty");
    refused(&file, "it is no directory");
}

#[test]
fn the_templates_can_be_executed() {
    let scratch = Scratch::new();
    let [plan, parameters, state] = ["plan", "parameters", "state"].map(|one| {
        let path = scratch.path(&format!("{one}.xml"));
        let said = call(&["plan", "new", "--template", one, "--out", text(&path)]);
        assert_eq!(said.code, 0, "{said:?}");
        path
    });
    let words = ["plan", "run", text(&plan), "-p", text(&parameters), "-s", text(&state)];
    let said = call(&[&words[..], &["--format", "json"]].concat());
    assert_eq!((said.code, &said.err[..]), (0, ""), "{said:?}");
    let summary = &said.json()["summary"];
    assert!(summary["succeeded"].as_u64() >= Some(2), "{summary}");
}

#[test]
fn on_a_bad_day_the_drive_is_cleaned_up_the_hard_limit_aborts_and_the_picture_shows_it() {
    let scratch = Scratch::new();
    let svg = scratch.path("bad.svg");
    let sols = root().join("examples/sols");
    let [plan, parameters, state, faults] =
        ["busy/plan.xml", "parameters.xml", "busy/state.xml", "busy/bad-day.json"]
            .map(|name| sols.join(name));
    let words = ["plan", "run", text(&plan), "-p", text(&parameters), "-s", text(&state)];
    let more = ["--faults", text(&faults), "--svg", text(&svg)];
    let said = call(&[&words[..], &more].concat());
    assert_eq!(said.code, 0, "{said:?}");
    let place = |words: &str| said.out.find(words).unwrap_or_else(|| panic!("{words}: {said:?}"));
    let drive = place("drive is aborted: it was ordered to stop");
    assert!(drive < place("after a failed drive starts"));
    assert!(drive < place("laser spectra, near is aborted: the charge is at the hard limit"));
    place("against the plan as it stood: ");
    let picture = fs::read_to_string(&svg).expect("a picture");
    for words in [
        "aborted: ordered",
        "aborted: hard limit of charge",
        "5  after a failed drive: 11:40",
        "mandatory and not done: drive, ",
    ] {
        assert!(picture.contains(words), "{words}");
    }
}
