//! `analyze` and `run --virtual`: SMAARTE's cases, and the form of what programs
//! are told.

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::fs;

use serde_json::Value;
use support::{Scratch, call, call_on};

fn analysis(case: &str, options: &[&str]) -> Value {
    let said =
        call_on(case, &[&["analyze", "{}", "--format", "json", "--at", "0"], options].concat());
    assert_eq!(said.code, 0, "{said:?}");
    said.json()
}

/// Which tasks start when, in order.
fn starts(analysis: &Value) -> Vec<(f64, u64)> {
    let mut starts: Vec<(f64, u64)> = Vec::new();
    for task in analysis["tasks"].as_array().unwrap() {
        for run in task["runs"].as_array().unwrap() {
            starts.push((run["start_s"].as_f64().unwrap(), task["id"].as_u64().unwrap()));
        }
    }
    starts.sort_by(|a, b| a.partial_cmp(b).unwrap());
    starts
}

#[test]
fn figure_4_starts_in_pairs_and_takes_9_s_from_both_formats() {
    for case in ["smaarte_fig4.csv", "smaarte_fig4.txt"] {
        let analysis = analysis(case, &[]);
        let pairs = [(0.0, 13), (0.0, 16), (3.0, 12), (3.0, 15), (6.0, 11), (6.0, 14)];
        assert_eq!(starts(&analysis), pairs);
        assert_eq!(analysis["makespan_s"], 9.0);
    }
}

#[test]
fn nine_tasks_take_45_s_and_55_with_gaps_and_135_one_at_a_time() {
    assert_eq!(analysis("smaarte_nine_tasks.csv", &[])["makespan_s"], 45.0);
    assert_eq!(analysis("smaarte_nine_tasks_gap.csv", &[])["makespan_s"], 55.0);
    assert_eq!(analysis("smaarte_nine_tasks.csv", &["--serial"])["makespan_s"], 135.0);
}

#[test]
fn the_larger_priority_goes_first() {
    let starts = starts(&analysis("smaarte_2018_priority.txt", &["--conflict", "number"]));
    assert_eq!(starts, [(0.0, 23), (3.0, 22), (6.0, 21)]);
}

#[test]
fn a_task_that_was_paused_has_one_run_with_two_segments_and_its_next_is_in_phase() {
    let analysis = analysis("smaarte_preempt.csv", &["--horizon", "70"]);
    let task = &analysis["tasks"][0];
    assert_eq!(task["id"], 31);
    let expected = serde_json::json!({
        "start_s": 0.0, "end_s": 26.0, "outcome": "succeeded", "segments": [[0.0, 5.0], [11.0, 26.0]],
    });
    assert_eq!(task["runs"][0], expected);
    assert_eq!(task["runs"][1]["start_s"], 60.0);
    assert_eq!(task["runs"][1]["end_s"], Value::Null, "it runs on beyond the horizon");
    assert_eq!(task["waited_s"], 6.0);
    assert!(task["reason"].as_str().unwrap().contains("task 32"), "{task}");
}

#[test]
fn what_programs_are_told_has_the_documented_keys_and_no_others() {
    let analysis = analysis("smaarte_preempt.csv", &[]);
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(&analysis), ["makespan_s", "problems", "tasks"]);
    assert_eq!(keys(&analysis["tasks"][0]), ["id", "reason", "runs", "waited_s"]);
    let run = &analysis["tasks"][0]["runs"][0];
    assert_eq!(keys(run), ["end_s", "outcome", "segments", "start_s"]);
}

#[test]
fn two_routine_tasks_that_collide_are_found_with_their_interval() {
    let scratch = Scratch::new();
    let path = scratch.file(
        "collide.csv",
        "id,st,et,dur,con,pri,type,interval,args\n\
         1,0,0,2,1,9,0,20,true\n2,0,0,2,1,5,0,30,true\n",
    );
    let said = call(&["analyze", path.to_str().unwrap(), "--format", "json", "--horizon", "300"]);
    let analysis = said.json();
    let collisions: Vec<&Value> = analysis["problems"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|problem| problem["kind"] == "collision")
        .collect();
    assert_eq!(collisions.len(), 1, "{analysis}");
    assert_eq!(collisions[0]["every_s"], 60.0);
    assert_eq!(collisions[0]["at_s"], 0.0);
}

#[test]
fn people_are_told_the_same() {
    let said = call_on("smaarte_preempt.csv", &["analyze", "{}", "--horizon", "70"]);
    assert!(said.out.contains("0–5, 11–26 s"), "{said:?}");
    assert!(said.out.contains("over after 11 s"), "{said:?}");
}

#[test]
fn the_picture_is_drawn_where_it_was_asked_for() {
    let scratch = Scratch::new();
    let path = scratch.path("gantt.svg");
    let said =
        call_on("smaarte_preempt.csv", &["analyze", "{}", "--gantt", path.to_str().unwrap()]);
    assert_eq!(said.code, 0, "{said:?}");
    let picture = fs::read_to_string(&path).unwrap();
    assert!(picture.contains("<svg") && picture.contains("smaarte_preempt.csv"));
    let nowhere = scratch.path("no/such/place.svg");
    let said =
        call_on("smaarte_preempt.csv", &["analyze", "{}", "--gantt", nowhere.to_str().unwrap()]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("place.svg"), "{said:?}");
}

#[test]
fn the_draw_of_devices_is_known_by_their_kind() {
    let scratch = Scratch::new();
    let mission = "
        [[mission.agent]]
        name = 'bus'
        supply_w = 10
        [[mission.device]]
        name = 'a'
        kind = 'heater'
        [[mission.device]]
        name = 'b'
        kind = 'heater'
        [[task]]
        id = 1
        dur = 5
        run = 'true'
        gates = ['a']
        [[task]]
        id = 2
        dur = 5
        run = 'true'
        gates = ['b']
    ";
    let path = scratch.file("two_heaters.toml", mission);
    let said = call(&["analyze", path.to_str().unwrap(), "--format", "json"]);
    assert_eq!(starts(&said.json()), [(0.0, 1), (5.0, 2)], "12 W do not fit: {said:?}");
}

#[test]
fn the_same_seed_draws_the_same_and_without_a_spread_that_is_said() {
    let scratch = Scratch::new();
    let task = "[[task]]\nid = 1\ndur = 10\nrun = 'true'\n";
    let spread = scratch.file("spread.toml", format!("{task}dur_min = 5\ndur_max = 20\n"));
    let draw = |seed: &str| {
        let words = ["analyze", spread.to_str().unwrap(), "--samples", "50", "--seed", seed];
        call(&[&words[..], &["--format", "json"]].concat()).json()["samples"].clone()
    };
    assert!(draw("1").is_object());
    assert_eq!(draw("1"), draw("1"));
    assert_ne!(draw("1")["tasks"], draw("2")["tasks"]);
    let plain = scratch.file("plain.toml", task);
    let said = call(&["analyze", plain.to_str().unwrap(), "--samples", "50", "--format", "json"]);
    assert_eq!(said.json()["problems"][0]["kind"], "no_spread", "{said:?}");
}

#[test]
fn a_virtual_run_tells_each_change_on_a_line() {
    let said = call_on("smaarte_preempt.csv", &["run", "{}", "--virtual", "--for", "30"]);
    assert_eq!(said.code, 0, "{said:?}");
    let lines: Vec<String> = said
        .out
        .lines()
        .map(|line| line.split_whitespace().take(4).collect::<Vec<_>>().join(" "))
        .collect();
    for line in [
        "0.000 started task 31",
        "5.000 paused task 31",
        "5.000 started task 32",
        "11.000 resumed task 31",
        "26.000 succeeded task 31",
    ] {
        assert!(lines.iter().any(|told| told == line), "{line} in {said:?}");
    }
}

#[test]
fn a_virtual_run_tells_programs_documents_that_are_what_the_analysis_says() {
    let said = call_on("smaarte_fig4.csv", &["run", "{}", "--virtual", "--format", "json"]);
    let started: Vec<(f64, u64)> = said
        .json_lines()
        .iter()
        .filter_map(|change| {
            let task = change["note"]["Started"]["occurrence"]["task"].as_u64()?;
            Some((change["at_us"].as_f64().unwrap() / 1e6, task))
        })
        .collect();
    assert_eq!(started, starts(&analysis("smaarte_fig4.csv", &[])));
}

#[test]
fn a_run_fails_when_a_task_that_the_mission_needs_does() {
    let scratch = Scratch::new();
    let task = "[[task]]\nid = 1\ndur = 10\nrun = 'true'\npri = 9\ncon = 1\n\
                [[task]]\nid = 2\ndur = 1\nrun = 'true'\ncon = 1\net = '+5'\n";
    let optional = scratch.file("optional.toml", task);
    let said = call(&["run", optional.to_str().unwrap(), "--virtual"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("1 succeeded, 1 missed"), "{said:?}");
    let mandatory = scratch.file("mandatory.toml", format!("{task}mandatory = true\n"));
    let said = call(&["run", mandatory.to_str().unwrap(), "--virtual"]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("task 2 was missed"), "{said:?}");
}

#[test]
fn a_faster_run_takes_its_share_of_real_time() {
    let began = std::time::Instant::now();
    let said = call_on("smaarte_fig4.csv", &["run", "{}", "--speed", "30"]);
    assert_eq!(said.code, 0, "{said:?}");
    // 9 s, 30 times faster. It may take longer on a slow machine, never less.
    assert!(began.elapsed().as_millis() >= 300, "{:?}", began.elapsed());
}
