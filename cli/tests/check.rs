//! `check`: everything that is wrong, at once, with its place.

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use support::{Scratch, call, call_on};

#[test]
fn each_of_the_seven_mistakes_is_told_with_its_line_and_its_column() {
    let said = call_on("bad_schedule.csv", &["check", "{}"]);
    assert_eq!(said.code, 1);
    for line in 3..=9 {
        assert!(said.err.contains(&format!("bad_schedule.csv:{line}:")), "line {line}: {said:?}");
    }
    assert!(said.out.contains("7 errors"), "{said:?}");
}

#[test]
fn programs_are_told_the_same() {
    let said = call_on("bad_schedule.csv", &["check", "{}", "--format", "json"]);
    assert_eq!(said.code, 1);
    let found = said.json();
    assert_eq!(found["errors"], 7);
    assert!(found["tasks"].is_null(), "nothing is loaded");
    let places: Vec<_> = found["diagnostics"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| {
            assert!(one["message"].is_string() && one["column"].as_u64().unwrap() >= 1, "{one}");
            one["line"].as_u64().unwrap()
        })
        .collect();
    assert_eq!(places, [3, 4, 5, 6, 7, 8, 9]);
}

#[test]
fn a_good_file_is_good() {
    for case in ["smaarte_fig4.csv", "smaarte_fig4.txt", "smaarte_preempt.csv"] {
        let said = call_on(case, &["check", "{}", "--format", "json"]);
        assert_eq!(said.code, 0, "{said:?}");
        assert_eq!(said.json()["errors"], 0);
        assert!(said.json()["tasks"].as_u64().unwrap() > 0);
    }
}

const MISSION: &str = r#"
[mission]
[[mission.agent]]
name = "bus"
supply_w = 20
[[mission.device]]
name = "camera"
kind = "camera"
"#;

const SCHEDULE: &str = r#"
[[task]]
id = 1
run = "true"
gates = ["camera"]
"#;

#[test]
fn a_schedule_is_judged_against_the_mission_wherever_that_is() {
    let scratch = Scratch::new();
    let mission = scratch.file("mission.toml", MISSION);
    let schedule = scratch.file("schedule.toml", SCHEDULE);
    let both = scratch.file("both.toml", format!("{MISSION}{SCHEDULE}"));
    let (mission, schedule) = (mission.to_str().unwrap(), schedule.to_str().unwrap());
    let good = [
        &["check", both.to_str().unwrap()][..],
        &["check", schedule, "--mission", mission],
        &["check", mission, schedule],
        &["check", schedule, mission],
    ];
    for words in good {
        let said = call(words);
        assert_eq!(said.code, 0, "{words:?}: {said:?}");
        assert!(said.out.contains("1 task"), "{words:?}: {said:?}");
    }
    let alone = call(&["check", schedule]);
    assert_eq!(alone.code, 1, "nobody has a camera: {alone:?}");
    let twice = call(&["check", both.to_str().unwrap(), "--mission", mission]);
    assert_eq!(twice.code, 1, "two missions: {twice:?}");
    let no_mission = call(&["check", mission, "--mission", schedule]);
    assert_eq!(no_mission.code, 1, "{no_mission:?}");
}

#[test]
fn a_device_that_cannot_be_simulated_is_told_and_loaded_all_the_same() {
    let scratch = Scratch::new();
    let odd = MISSION.replace("kind = \"camera\"", "kind = \"toaster\"");
    let path = scratch.file("odd.toml", format!("{odd}{SCHEDULE}"));
    let said = call(&["check", path.to_str().unwrap()]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.err.contains("toaster") && said.err.contains("gimbal"), "{said:?}");
    assert!(said.out.contains("1 warning"), "{said:?}");

    let battery = "[[mission.device]]\nname = \"cells\"\nkind = \"battery\"\n";
    let battery = format!("{battery}parameters = {{ capacity = 10 }}\n");
    let path = scratch.file("battery.toml", format!("{MISSION}{battery}{SCHEDULE}"));
    let said = call(&["check", path.to_str().unwrap()]);
    assert_eq!(said.code, 0, "{said:?}");
    for part in ["the device `cells`", "no parameter `capacity`; it has capacity_wh"] {
        assert!(said.err.contains(part), "{part}: {said:?}");
    }
}

#[test]
fn nothing_is_coloured_where_no_terminal_is() {
    let said = call_on("bad_schedule.csv", &["check", "{}"]);
    assert!(!said.err.contains('\u{1b}') && !said.out.contains('\u{1b}'), "{said:?}");
}

#[test]
fn files_that_are_given_together_are_judged_together() {
    let scratch = Scratch::new();
    let header = "id,st,et,dur,con,pri,type,interval,args\n";
    let one = scratch.file("one.csv", format!("{header}1,0,0,3,1,1,0,0,sleep 3\n"));
    let same = scratch.file("same.csv", format!("{header}1,0,0,3,1,1,0,0,sleep 3\n"));
    let after = "[[task]]\nid = 2\nhold = true\nafter = [1]\n";
    let after = scratch.file("after.toml", after);
    let check = |files: [&std::path::PathBuf; 2]| {
        call(&["check".as_ref(), files[0].as_os_str(), files[1].as_os_str()])
    };
    let said = check([&one, &same]);
    assert_eq!(said.code, 1, "the manager would refuse them: {said:?}");
    assert!(said.err.contains("same.csv:2:1") && said.err.contains("one.csv"), "{said:?}");
    assert_eq!(check([&one, &after]).code, 0);
    let other = scratch.file("other.csv", format!("{header}7,0,0,3,1,1,0,0,sleep 3\n"));
    let said = check([&other, &after]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("there is no task 1"), "{said:?}");
}
