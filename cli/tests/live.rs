//! A run in real time with its operator: real processes, the control socket,
//! commands from inside tasks.
#![cfg(target_os = "linux")]

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::fs;
use std::io::{BufReader, Read};
use std::process::{ChildStdout, Stdio};

use serde_json::Value;
use support::run::Run;
use support::{Scratch, case_file, faregate};

#[test]
fn an_operator_adds_holds_changes_and_removes_tasks_of_a_running_schedule() {
    let scratch = Scratch::new();
    let mut run = Run::of(&scratch, "");
    assert!(run.must(&["status"]).out.contains("empty"));

    run.must(&["add", "--line", "7 +3600 0 5 1 10 0 0 sleep 5"]);
    assert_eq!(run.state("7")["state"], "pending");
    run.must(&["set", "7", "--priority", "99"]);
    assert_eq!(run.state("7")["priority"], 99);

    run.must(&["hold", "7"]);
    run.must(&["set", "7", "--window", "0.."]);
    assert_eq!(run.state("7")["state"], "waiting", "it is held");
    assert!(run.state("7")["waits_for"].as_str().unwrap().contains("held"));
    run.must(&["resume", "7"]);
    run.until("started task 7");
    assert_eq!(run.state("7")["state"], "running");
    run.must(&["remove", "7"]);
    run.until("aborted task 7");

    let unknown = run.operate(&["hold", "8"]);
    assert!(matches!(unknown.code, 1 | 5), "{unknown:?}");
    assert!(unknown.err.contains('8'), "{unknown:?}");
    let said = run.end();
    assert_eq!(said.code, 0, "{said:?}");
}

#[test]
fn a_schedule_with_mistakes_is_not_added_and_each_mistake_is_told() {
    let scratch = Scratch::new();
    let run = Run::of(&scratch, "");
    let bad = case_file("bad_schedule.csv");
    let said = run.operate(&["add", bad.to_str().unwrap()]);
    assert_eq!(said.code, 5, "{said:?}");
    assert_eq!(said.err.matches("line ").count(), 7, "{said:?}");
    assert!(run.must(&["status"]).out.contains("empty"), "nothing of it was added");
    assert_eq!(run.end().code, 0);
}

#[test]
fn a_process_commands_the_devices_of_its_task_and_no_others() {
    let scratch = Scratch::new();
    let script = "#!/bin/sh
        faregate command camera on && echo camera: $? >>said
        faregate command camera fold; echo unknown: $? >>said
        faregate command heater on; echo undeclared: $? >>said
        faregate command toaster on; echo nothing: $? >>said
        faregate heartbeat; echo heartbeat: $? >>said
    ";
    scratch.file("script.sh", script);
    let task = "[[task]]\nid = 1\ndur = 60\nrun = 'sh script.sh'\ngates = ['camera']\n";
    let mut run = Run::of(&scratch, task);
    run.until("succeeded task 1");
    let said = fs::read_to_string(scratch.path("said")).unwrap();
    assert_eq!(said, "camera: 0\nunknown: 5\nundeclared: 5\nnothing: 5\nheartbeat: 0\n");
    let said = run.end();
    assert!(said.out.contains("bus: never more than 9 W of 20 W"), "the camera was on: {said:?}");
}

#[test]
fn what_a_failing_task_printed_is_shown() {
    let scratch = Scratch::new();
    scratch.file("script.sh", "echo no film >&2; exit 3");
    let task = "[[task]]\nid = 1\nrun = 'sh script.sh'\n";
    let mut run = Run::of(&scratch, task);
    run.until("failed task 1");
    run.until("| no film");
    assert_eq!(run.end().code, 0);
}

#[test]
fn a_task_that_is_pre_empted_is_refused_by_name_and_goes_on() {
    let scratch = Scratch::new();
    // Its group is stopped while task 2 has the camera, so it asks when it
    // goes on: the camera is off then, and its ticket is valid again.
    scratch.file(
        "long.sh",
        "for i in 1 2 3 4 5 6 7 8; do faregate command camera on; sleep 0.5; done",
    );
    let tasks = "
        [[task]]
        id = 1
        pri = 10
        run = 'sh long.sh'
        gates = ['camera']
        [[task]]
        id = 2
        pri = 50
        st = '+1'
        run = 'sleep 1'
        gates = ['camera']
    ";
    let mut run = Run::of(&scratch, tasks);
    run.until("paused task 1");
    run.until("started task 2");
    run.until("resumed task 1");
    run.until("succeeded task 1");
    let said = run.end();
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("2 succeeded"), "{said:?}");
}

#[test]
fn a_script_learns_who_took_its_tickets_from_a_field() {
    let scratch = Scratch::new();
    let script = "
        trap 'faregate command --format json camera off >said; exit' USR1
        faregate command --format json camera on >done
        while :; do sleep 0.1; done
    ";
    scratch.file("short.sh", script);
    let tasks = "
        [[task]]
        id = 1
        run = 'sh short.sh'
        gates = ['camera']
        preempt = 'checkpoint'
        grace = 60
        [[task]]
        id = 2
        pri = 50
        st = '+1'
        run = 'sleep 1'
        gates = ['camera']
    ";
    let mut run = Run::of(&scratch, tasks);
    run.until("succeeded task 2");
    let said = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&fs::read(scratch.path(name)).unwrap()).unwrap()
    };
    assert_eq!(said("done"), serde_json::json!({"done": {"reply": ""}}));
    let refused = &said("said")["refused"];
    assert_eq!(refused["kind"], "preempted", "{refused}");
    assert_eq!(refused["taker"], "task 2", "{refused}");
    run.end();
}

#[test]
fn a_mode_takes_its_gates_and_gives_them_back() {
    let scratch = Scratch::new();
    let task = "[[task]]\nid = 1\nrun = 'sleep 600'\ngates = ['heater']\npri = 10\n";
    let mut run = Run::of(&scratch, task);
    run.until("started task 1");
    run.must(&["mode", "enter", "eclipse"]);
    run.until("paused task 1");
    assert!(run.state("1")["waits_for"].as_str().unwrap().contains("eclipse"));
    run.must(&["mode", "leave", "eclipse"]);
    run.until("resumed task 1");
    let unknown = run.operate(&["mode", "enter", "picnic"]);
    assert_ne!(unknown.code, 0, "{unknown:?}");
    assert!(unknown.err.contains("picnic"), "{unknown:?}");
    assert_eq!(run.end().code, 0);
}

#[test]
fn who_watches_is_told_each_change_until_the_end() {
    let scratch = Scratch::new();
    let run = Run::of(&scratch, "");
    let watch = faregate()
        .args(["watch", "--format", "json", "--socket"])
        .arg(&run.socket)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut watch = watch;
    let mut told = BufReader::new(watch.stdout.take().unwrap());
    let mut added = 0;
    // It is not known when it has begun to watch: something happens until then.
    let first = loop {
        added += 1;
        run.must(&["add", "--line", &format!("{added} 0 0 0 0 1 0 0 true")]);
        if watch_has(&mut told) {
            break added;
        }
    };
    assert!(first < 100);
    assert_eq!(run.end().code, 0);
    let mut rest = String::new();
    told.read_to_string(&mut rest).unwrap();
    assert_eq!(watch.wait().unwrap().code(), Some(0), "the manager's end is the last change");
    for line in rest.lines().filter(|line| line.starts_with('{')) {
        let change: Value = serde_json::from_str(line).unwrap();
        assert!(change["note"].is_object() && change["at_us"].is_u64(), "{change}");
    }
}

/// Whether something can be read within a moment.
fn watch_has(told: &mut BufReader<ChildStdout>) -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let moment = Timespec { tv_sec: 0, tv_nsec: 200_000_000 };
    let fd = told.get_ref();
    poll(&mut [PollFd::new(fd, PollFlags::IN)], Some(&moment)).unwrap() > 0
}
