//! A run measures what there is, and what its tasks use of it.
#![cfg(target_os = "linux")]

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use serde_json::Value;
use support::Scratch;
use support::run::{Run, wait_until};

#[test]
fn a_task_that_uses_more_than_twice_the_memory_it_asked_for_has_failed() {
    let scratch = Scratch::new();
    // A shell that keeps 30 MB in a variable, and one that does not.
    scratch.file("greedy.sh", "all=$(head -c 30000000 /dev/zero | tr '\\0' x); sleep 600");
    let tasks = "
        [[task]]
        id = 1
        run = 'sh greedy.sh'
        memory = '4MiB'
        [[task]]
        id = 2
        run = 'sleep 4'
        memory = '64MiB'
    ";
    let mission = scratch.file("mission.toml", tasks);
    let mut run = Run::start(&scratch, &[mission.to_str().unwrap()]);
    run.until("stopping task 1 attempt 1 it uses more than twice the memory");
    run.until("failed task 1");
    run.until("succeeded task 2");
    assert_eq!(run.end().code, 0);
}

#[test]
fn what_the_host_is_short_of_is_waited_for() {
    let scratch = Scratch::new();
    let mission = |what: &str| {
        let tasks = "
            [[task]]
            id = 1
            run = 'sleep 600'
            storage = '1PiB'
            [[task]]
            id = 2
            run = 'sleep 600'
        ";
        scratch.file("mission.toml", format!("[mission]\n{what}\n{tasks}"))
    };
    let waits_for = |run: &Run, task: &str, what: &str| {
        wait_until(&format!("task {task} waits for {what}"), || {
            // Who asks before it is loaded is told that there is no such task.
            let said = run.operate(&["status", task, "--format", "json"]);
            let row = if said.code == 0 { said.json()["tasks"][0].clone() } else { Value::Null };
            let waits_for = row["waits_for"].as_str().unwrap_or_default();
            row["state"] == "waiting" && waits_for.starts_with(what)
        });
    };
    // More than any host has, of what is taken for installed.
    let path = mission("storage = '2PiB'\nmemory_low = 1");
    let mut run = Run::start(&scratch, &[path.to_str().unwrap()]);
    run.until("started task 2");
    waits_for(&run, "1", "storage");
    assert_eq!(run.end().code, 0);

    let path = mission("memory_low = '1PiB'");
    let run = Run::start(&scratch, &[path.to_str().unwrap()]);
    waits_for(&run, "2", "memory");
    assert_eq!(run.end().code, 0);
}
