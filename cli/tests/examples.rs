//! The examples do what they say, in real time.
#![cfg(target_os = "linux")]

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use support::{Said, Scratch, faregate, root};

fn example(name: &str) -> PathBuf {
    root().join("examples/schedule").join(name)
}

/// Calls the program in an example's folder, where its scripts find it.
fn call_in(name: &str, words: &[&str]) -> Said {
    let program = Path::new(env!("CARGO_BIN_EXE_faregate")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    faregate().args(words).env("PATH", path).current_dir(example(name)).output().unwrap().into()
}

/// The words of the changes of a run, each with its task: `Started 31`.
fn changes(said: &Said) -> Vec<String> {
    let told = |change: Value| {
        let (what, of) = change["note"].as_object()?.iter().next()?;
        let task = [&of["task"], &of["occurrence"]["task"], &of["attempt"]["occurrence"]["task"]]
            .into_iter()
            .find_map(Value::as_u64)?;
        Some(format!("{what} {task}"))
    };
    said.json_lines().into_iter().filter_map(told).collect()
}

/// That these happen in this order.
fn assert_order(said: &Said, order: &[&str]) {
    let changes = changes(said);
    let mut rest = changes.iter();
    for expected in order {
        assert!(rest.any(|told| told == expected), "no {expected} in its turn: {changes:#?}");
    }
}

fn analysis(name: &str, file: &str) -> Value {
    let said = call_in(name, &["analyze", file, "--at", "0", "--format", "json"]);
    assert_eq!(said.code, 0, "{said:?}");
    said.json()
}

#[test]
fn a_downlink_of_20_minutes_pauses_the_routine_pictures_and_they_go_on() {
    let said = call_in(
        "stp_h6",
        &["run", "schedule.csv", "--virtual", "--for", "1600", "--format", "json"],
    );
    assert_eq!(said.code, 0, "{said:?}");
    assert_order(
        &said,
        &[
            "Started 71",
            "Paused 71",
            "Started 72",
            "Over 72",
            "Resumed 71",
            "Missed 71",
            "Started 71",
        ],
    );
}

#[test]
fn wishes_of_one_and_a_half_times_42_w_are_served_within_them() {
    let analysis = analysis("stp_h7", "schedule.toml");
    let margin =
        analysis["problems"].as_array().unwrap().iter().find(|one| one["kind"] == "margin");
    let message = margin.unwrap()["message"].as_str().unwrap();
    let wished: u64 = number_before(message.rsplit("up to").next().unwrap(), " W");
    assert!(2 * wished >= 3 * 42, "{message}");

    // Each task is mandatory, so the run fails if one does; and if the bus trips.
    let said = call_in("stp_h7", &["run", "schedule.toml"]);
    assert_eq!(said.code, 0, "{said:?}");
    let bus = said.out.lines().find(|line| line.starts_with("bus: ")).unwrap();
    let most = number_before(bus.trim_start_matches("bus: never more than "), " W of 42 W");
    assert!((22..=42).contains(&most), "{bus}");
    assert!(bus.contains("on average"), "{bus}");
    assert!(said.out.contains("paused      task 21"), "what processes gives way: {said:?}");
    assert!(said.out.contains("gimbal: 1 finished"), "{said:?}");
    assert!(said.out.contains("6 succeeded"), "{said:?}");
}

fn number_before(text: &str, end: &str) -> u64 {
    let number = text.trim().split(end).next().unwrap();
    number.parse().unwrap_or_else(|_| panic!("{number:?} in {text:?}"))
}

#[test]
fn for_a_manoeuvre_all_sensors_go_off_and_their_processes_stand_still() {
    let said = call_in("recovery", &["run", "schedule.toml", "--format", "json"]);
    assert_eq!(said.code, 0, "{said:?}");
    for sensor in ["81", "82"] {
        let order = [
            format!("Started {sensor}"),
            format!("Paused {sensor}"),
            "Started 91".to_owned(),
            "Over 91".to_owned(),
            format!("Resumed {sensor}"),
            format!("Over {sensor}"),
        ];
        assert_order(&said, &order.each_ref().map(String::as_str));
    }
}

#[test]
fn an_uploaded_csv_switches_a_camera_on() {
    let script = example("run.sh");
    let output = Command::new(&script)
        .arg("upload")
        .env("FAREGATE_BIN", env!("CARGO_BIN_EXE_faregate"))
        .output()
        .unwrap();
    let said = Said::from(output);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("upload.csv: added"), "{said:?}");
    assert!(said.out.contains("paused      task 61"), "the second is more important: {said:?}");
    assert!(said.out.contains("camera: 3 finished"), "two pictures and one: {said:?}");
}

#[test]
fn every_example_is_in_the_list_and_passes_the_check() {
    let list = fs::read_to_string(example("README.md")).unwrap();
    let script = fs::read_to_string(example("run.sh")).unwrap();
    let mut folders = 0;
    for folder in fs::read_dir(example("")).unwrap().map(Result::unwrap) {
        if !folder.file_type().unwrap().is_dir() {
            continue;
        }
        folders += 1;
        let name = folder.file_name().into_string().unwrap();
        assert!(
            list.contains(&format!("`{name}`")) && script.contains(&format!("{name}() {{")),
            "{name}"
        );
        let files = fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap().path());
        let schedules: Vec<_> = files
            .filter(|path| path.extension().is_some_and(|end| end == "toml" || end == "csv"))
            .map(|path| path.to_str().unwrap().to_owned())
            .collect();
        let words: Vec<&str> =
            ["check"].into_iter().chain(schedules.iter().map(String::as_str)).collect();
        assert_eq!(support::call(&words).code, 0, "{name}");
    }
    assert_eq!(folders, 4);
}

#[test]
fn the_picture_in_the_story_is_what_the_program_draws() {
    let scratch = Scratch::new();
    let path = scratch.path("picture.svg");
    let words = ["analyze", "schedule.toml", "--at", "0", "--gantt", path.to_str().unwrap()];
    assert_eq!(call_in("stp_h7", &words).code, 0);
    let drawn = fs::read_to_string(&path).unwrap();
    let kept = root().join("docs/schedule-manager.svg");
    if std::env::var_os("UPDATE_PICTURE").is_some() {
        fs::write(&kept, &drawn).unwrap();
    }
    let kept = fs::read_to_string(&kept).unwrap();
    assert!(drawn == kept, "docs/schedule-manager.svg is old: run this test with UPDATE_PICTURE=1");
}

#[test]
fn a_run_that_loses_its_spacecraft_fails() {
    let scratch = Scratch::new();
    let mission = "
        [[mission.agent]]
        name = 'bus'
        supply_w = 20
        [[mission.device]]
        name = 'cell'
        kind = 'battery'
        parameters = { capacity_wh = 0.001 }
        [[mission.device]]
        name = 'heater'
        kind = 'heater'
        [[task]]
        id = 1
        [[task.step]]
        at = 0
        gate = 'heater'
        command = 'on'
        [[task.step]]
        at = 60
        gate = 'heater'
        command = 'off'
    ";
    let path = scratch.file("mission.toml", mission);
    let said = support::call(&["run", path.to_str().unwrap()]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("the spacecraft is lost: the bus tripped"), "{said:?}");
}

#[test]
fn what_tasks_draw_themselves_is_on_the_bus() {
    let scratch = Scratch::new();
    let tasks = "
        [[mission.agent]]
        name = 'bus'
        supply_w = 20
        [[task]]
        id = 1
        run = 'sleep 0.5'
        draw_w = 8
        [[task]]
        id = 2
        run = 'sleep 0.5'
        draw_w = 9
        [[task]]
        id = 3
        run = 'sleep 0.5'
        draw_w = 7
    ";
    let path = scratch.file("mission.toml", tasks);
    let said = support::call(&["run", path.to_str().unwrap()]);
    assert_eq!(said.code, 0, "{said:?}");
    // Two of them at a time: all three would be 24 W.
    assert!(said.out.contains("bus: never more than 17 W of 20 W"), "{said:?}");
}
