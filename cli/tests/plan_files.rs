//! `plan check`, `convert`, `diff` and `new`: files of the planner.

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::fs;
use std::path::{Path, PathBuf};

use support::{Said, Scratch, call};

/// The three templates, as files.
struct Three {
    scratch: Scratch,
    plan: PathBuf,
    parameters: PathBuf,
    state: PathBuf,
}

impl Three {
    fn new() -> Self {
        let scratch = Scratch::new();
        let new = |template: &str| {
            let path = scratch.path(&format!("{template}.xml"));
            let said = plan(&["new", "--template", template, "--out", text(&path)]);
            assert_eq!((said.code, said.err.as_str()), (0, ""), "{said:?}");
            path
        };
        let (plan, parameters, state) = (new("plan"), new("parameters"), new("state"));
        Self { scratch, plan, parameters, state }
    }

    /// The plan with a piece replaced.
    fn changed(&self, name: &str, from: &str, to: &str) -> PathBuf {
        let template = fs::read_to_string(&self.plan).unwrap();
        assert_eq!(template.matches(from).count(), 1, "{from}");
        self.scratch.file(name, template.replace(from, to))
    }

    fn diff(&self, before: &Path, after: &Path) -> Said {
        plan(&["diff", text(before), text(after), "-p", text(&self.parameters)])
    }

    fn convert(&self, from: &Path, to: &str) -> PathBuf {
        let to = self.scratch.path(to);
        let said = plan(&["convert", text(from), text(&to), "-p", text(&self.parameters)]);
        assert_eq!((said.code, said.err.as_str()), (0, ""), "{said:?}");
        to
    }
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn plan(words: &[&str]) -> Said {
    call(&[&["plan"], words].concat())
}

#[test]
fn templates_are_good_together_and_nothing_is_overwritten() {
    let three = Three::new();
    let files = [&three.plan, &three.parameters, &three.state].map(|path| text(path));
    let said = plan(&[&["check"], &files[..]].concat());
    assert_eq!((said.code, said.err.as_str()), (0, ""), "{said:?}");
    assert!(said.out.contains("good: a plan of 7 activities, parameters, a state"), "{said:?}");
    // In any order: the parameters are found.
    let said = plan(&["check", files[2], files[0], files[1], "--format", "json"]);
    assert_eq!(said.code, 0, "{said:?}");
    let found = said.json();
    assert_eq!((&found["errors"], &found["warnings"]), (&0.into(), &0.into()));
    assert_eq!(found["files"][1]["activities"], 7);
    assert_eq!(found["files"][2]["is"], "parameters");
    let said = plan(&["new", "--template", "state", "--out", files[0]]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("is there already"), "{said:?}");
    assert!(fs::read_to_string(files[0]).unwrap().contains("<plan "));
    let printed = plan(&["new", "--template", "state"]).out;
    assert_eq!(printed, fs::read_to_string(files[2]).unwrap());
}

#[test]
fn everything_that_is_wrong_is_told_at_once_with_its_line() {
    let three = Three::new();
    let bad = three.changed("bad.xml", "id=\"6\" name", "id=\"5\" nam");
    let said = plan(&["check", text(&bad), text(&three.parameters)]);
    assert_eq!(said.code, 1);
    let line = fs::read_to_string(&bad).unwrap();
    let line = line.lines().position(|line| line.contains("nam=")).unwrap() + 1;
    for part in [&format!("bad.xml:{line}:17"), &format!("bad.xml:{line}:20"), "did you mean name?"]
    {
        assert!(said.err.contains(part), "{part}: {said:?}");
    }
    assert!(said.out.contains("2 errors"), "{said:?}");
    let said = plan(&["check", text(&bad), text(&three.parameters), "--format", "json"]);
    assert_eq!(said.code, 1);
    let found = said.json();
    let rules: Vec<_> = (found["diagnostics"].as_array().unwrap().iter())
        .map(|one| (one["rule"].as_str().unwrap(), one["line"].as_u64().unwrap()))
        .collect();
    let line = u64::try_from(line).unwrap();
    assert_eq!(rules, [("duplicate", line), ("unknown", line)]);
    assert!(found["files"][0]["is"].is_null(), "nothing is loaded");
}

#[test]
fn a_state_that_contradicts_the_plan_is_told() {
    let three = Three::new();
    let late =
        three.changed("late.xml", "from=\"19:00\" to=\"19:00\"", "from=\"08:05\" to=\"08:05\"");
    let said = plan(&["check", text(&late), text(&three.parameters), text(&three.state)]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("state.xml:") && said.err.contains("needs the computer"), "{said:?}");
    let said = plan(&["check", text(&late), text(&three.parameters)]);
    assert_eq!(said.code, 0, "by itself it is good: {said:?}");
}

#[test]
fn each_file_is_the_same_in_both_forms_and_a_damaged_one_is_refused() {
    let three = Three::new();
    for path in [&three.plan, &three.parameters, &three.state] {
        let compact = three.convert(path, "a.bin");
        let again = three.convert(&compact, "again.xml");
        let said = three.diff(path, &again);
        assert_eq!((said.code, said.out.as_str(), said.err.as_str()), (0, "", ""));
        assert_eq!(three.diff(&again, &compact).code, 0);
        let mut bytes = fs::read(&compact).unwrap();
        assert!(bytes.len() * 2 < fs::read(&again).unwrap().len(), "it is compact");
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        let damaged = three.scratch.file("damaged.bin", bytes);
        let said = plan(&["check", text(&damaged)]);
        assert_eq!(said.code, 1);
        assert!(said.err.contains("[damaged]"), "{said:?}");
    }
    let said = plan(&["convert", text(&three.plan), "out.txt"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.err.contains("neither in .xml nor in .bin"), "{said:?}");
}

#[test]
fn no_file_is_written_over_itself() {
    let three = Three::new();
    let before = fs::read(&three.plan).unwrap();
    let words = ["convert", text(&three.plan), text(&three.plan), "-p", text(&three.parameters)];
    let said = plan(&words);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.err.contains("over itself"), "{said:?}");
    assert_eq!(fs::read(&three.plan).unwrap(), before, "its comments are still there");
}

#[test]
fn without_parameters_what_is_written_means_the_same_to_everybody() {
    let three = Three::new();
    let compact = three.convert(&three.plan, "a.bin");
    let bare = three.scratch.path("bare.xml");
    assert_eq!(plan(&["convert", text(&compact), text(&bare)]).code, 0);
    let written = fs::read_to_string(&bare).unwrap();
    assert!(written.contains("handover=\"112175.244\"") && written.contains("<uses bit=\"2\"/>"));
    // With parameters of another day, too.
    let day = fs::read_to_string(&three.parameters).unwrap();
    let day =
        day.replace("length=\"88775.244\" midnight=\"0\"", "length=\"90000\" midnight=\"10\"");
    let day = three.scratch.file("day.xml", day);
    let said = plan(&["diff", text(&compact), text(&bare), "-p", text(&day)]);
    assert_eq!((said.code, said.out.as_str()), (0, ""), "{said:?}");
}

#[test]
fn a_difference_is_told_field_by_field_and_ends_with_one() {
    let three = Three::new();
    let after = three.changed("b.xml", "to=\"16:00\"", "to=\"16:30\"");
    let said = three.diff(&three.plan, &after);
    assert_eq!((said.code, said.out.as_str()), (1, "~ activity 4, start #1: to: 16:00 -> 16:30\n"));
    let after = three.changed("b.xml", " pausable=\"true\"", "");
    let said = three.diff(&three.plan, &after);
    assert_eq!((said.code, said.out.as_str()), (1, "~ activity 1: pausable: true -> nothing\n"));
    let after = three.changed("b.xml", "<uses zone=\"wheels\"/>", "");
    assert_eq!(three.diff(&three.plan, &after).out, "- activity 2, uses wheels: zone=\"wheels\"\n");
    assert_eq!(three.diff(&after, &three.plan).out, "+ activity 2, uses wheels: zone=\"wheels\"\n");
    // The order decides among equals.
    let listen = "<activity id=\"6\" name=\"listen\" type=\"stay_awake\" priority=\"220\" duration=\"20 min\">\n    \
                  <start from=\"17:00\" to=\"17:00\" cutoff=\"17:20\"/>\n  </activity>";
    let text = fs::read_to_string(three.changed("b.xml", listen, "")).unwrap();
    let first = "<activity id=\"1\"";
    let after = three.scratch.file("b.xml", text.replace(first, &format!("{listen}{first}")));
    assert_eq!(
        three.diff(&three.plan, &after).out,
        "~ activity 6: stands elsewhere among its like\n"
    );
    let said = plan(&[
        "diff",
        self::text(&three.plan),
        self::text(&three.plan),
        "-p",
        self::text(&three.parameters),
        "--format",
        "json",
    ]);
    assert_eq!((said.code, &said.json()["same"]), (0, &true.into()));
}

#[test]
fn what_cannot_be_compared_ends_with_five() {
    let three = Three::new();
    let said = three.diff(&three.plan, &three.state);
    assert_eq!(said.code, 5);
    assert!(said.err.contains("is a plan, and") && said.err.contains("is a state"), "{said:?}");
    let bad = three.changed("b.xml", "to=\"16:00\"", "to=\"soon\"");
    assert_eq!(three.diff(&three.plan, &bad).code, 5);
}

#[test]
fn each_sub_command_has_an_example_that_names_it() {
    for word in ["check", "convert", "diff", "new"] {
        let said = plan(&[word, "--help"]);
        assert_eq!(said.code, 0);
        assert!(
            said.out.contains("Example") && said.out.contains(&format!("faregate plan {word}"))
        );
    }
}

#[test]
fn parameters_are_compared_with_the_mission_that_plans_are_executed_on() {
    let sols = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/sols");
    let (parameters, rover) = (sols.join("parameters.xml"), sols.join("rover.toml"));
    let said = plan(&["check", text(&parameters), "--mission", text(&rover)]);
    assert_eq!((said.code, said.err.as_str()), (0, ""), "{said:?}");
    let less = fs::read_to_string(&rover).unwrap().replace("supply_w = 480", "supply_w = 479");
    let scratch = Scratch::new();
    let less = scratch.file("less.toml", less.replace("\"engine 3\" = 102\n", ""));
    let said = plan(&["check", text(&parameters), "--mission", text(&less)]);
    assert_eq!(said.code, 1);
    for part in ["a peak of 480 W", "has 479 W", "no category `engine 3`", "less.toml:6"] {
        assert!(said.err.contains(part), "{part}: {said:?}");
    }
    assert!(said.out.contains("2 errors"), "{said:?}");
    let said = plan(&["check", text(&sols.join("busy/state.xml")), "--mission", text(&rover)]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("name their file, too"), "{said:?}");
}

#[test]
fn a_plan_is_compared_with_what_its_sequences_command() {
    let sols = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/sols");
    let (parameters, rover) = (sols.join("parameters.xml"), sols.join("rover.toml"));
    let on = |rover: &Path, sol: &Path| {
        plan(&["check", text(sol), text(&parameters), "--mission", text(rover)])
    };
    let check = |sol: &Path| on(&rover, sol);
    for sol in ["busy", "winter", "conjunction", "too-much"] {
        let said = check(&sols.join(sol).join("plan.xml"));
        assert_eq!((said.code, said.err.as_str()), (0, ""), "{sol}: {said:?}");
    }
    let scratch = Scratch::new();
    let other = fs::read_to_string(&rover).unwrap().replace("\"health\"", "\"wealth\"");
    let said = on(&scratch.file("other.toml", other), &sols.join("conjunction/plan.xml"));
    assert_eq!(said.code, 1);
    assert!(said.err.contains("no sequence `health` is known"), "{said:?}");
    // The evening's weather at noon, by the same instrument.
    let busy = fs::read_to_string(sols.join("busy/plan.xml")).unwrap();
    let evening = "<start from=\"19:00\" to=\"20:00\" cutoff=\"20:15\"/>";
    assert_eq!(busy.matches(evening).count(), 1);
    let noon = busy.replace(evening, "<start from=\"12:00\" to=\"13:00\" cutoff=\"13:15\"/>");
    let said = check(&scratch.file("noon.xml", noon));
    assert_eq!(said.code, 1);
    for part in ["`18 weather, noon` and `19 weather, evening`", "`weather_station`", "no resource"]
    {
        assert!(said.err.contains(part), "{part}: {said:?}");
    }
}

#[test]
fn what_may_be_meant_otherwise_is_warned_of_and_what_cannot_be_counted_is_no_number() {
    let sols = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/sols");
    let winter = fs::read_to_string(sols.join("winter/plan.xml")).unwrap();
    let is = "duration=\"5 min\" marginal=\"5 W\" peak=\"10 W\"";
    assert_eq!(winter.matches(is).count(), 1);
    let scratch = Scratch::new();
    let check = |becomes: &str| {
        let file = scratch.file("plan.xml", winter.replace(is, becomes));
        plan(&["check", text(&file), text(&sols.join("parameters.xml"))])
    };
    let said = check("duration=\"300\" marginal=\"15 W\" peak=\"10 W\"");
    assert!(said.code == 0 && said.out.contains("2 warnings"), "{said:?}");
    for part in ["300 without a unit is read as seconds", "its peak is below its average power"] {
        assert!(said.err.contains(part), "{part}: {said:?}");
    }
    let said = check("duration=\"300 s\" marginal=\"10 W\" peak=\"10 W\"");
    assert_eq!((said.code, &said.err[..]), (0, ""), "{said:?}");
    let huge = "duration=\"90000000 h\" marginal=\"90000000 kW\" peak=\"10 W\" energy=\"1 J\"";
    let said = check(huge);
    assert!(said.code == 1 && said.err.contains("that can be multiplied"), "{said:?}");
    assert!(!said.err.contains("18446744073709"), "{said:?}");
}
