//! How a run ends, and goes on: interrupts, kills, journals; and that it sleeps
//! in between.
#![cfg(target_os = "linux")]

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::fs;
use std::io::Read as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use support::run::{MISSION, Run, wait_until};
use support::{Said, Scratch, faregate};

#[test]
fn an_interrupt_ends_the_tasks_in_order() {
    let scratch = Scratch::new();
    scratch.file(
        "careful.sh",
        "trap 'echo saved >saved; exit 0' TERM; echo >ready; while :; do sleep 0.1; done",
    );
    let task = "[[task]]\nid = 1\nrun = 'sh careful.sh'\npreempt = 'kill'\ngrace = 30\n";
    let mut run = Run::of(&scratch, task);
    run.until("started task 1");
    wait_until("the trap is set", || scratch.path("ready").exists());
    let pid = run.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let said = run.ended();
    assert_eq!(said.code, 0, "{said:?}");
    assert!(scratch.path("saved").exists(), "it had its grace: {said:?}");
}

/// Something is due all the time, and each start is a process.
#[test]
fn an_interrupt_ends_a_run_that_is_never_idle() {
    let scratch = Scratch::new();
    let mut run = Run::of(&scratch, "[[task]]\nid = 1\nrun = 'true'\ninterval = '1ms'\n");
    run.until("succeeded task 1");
    // Its operator is answered all the same.
    assert_eq!(run.state("1")["task"], 1);
    let pid = run.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let said = run.ended();
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("succeeded"), "{said:?}");
}

#[test]
fn two_runs_do_not_share_a_socket_or_a_journal() {
    let scratch = Scratch::new();
    let mission = scratch.file("mission.toml", MISSION);
    let journal = scratch.path("kept");
    let words = [mission.to_str().unwrap(), "--journal", journal.to_str().unwrap()];
    let run = Run::start(&scratch, &words);
    let second =
        |words: &[&str]| -> Said { faregate().arg("run").args(words).output().unwrap().into() };
    let socket = run.socket.to_str().unwrap();
    let said = second(&[mission.to_str().unwrap(), "--socket", socket, "--for", "1"]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains(socket), "{said:?}");
    let said = second(&words);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("kept"), "{said:?}");
    assert_eq!(run.end().code, 0);
}

#[test]
fn a_run_that_was_killed_goes_on_from_its_journal() {
    let scratch = Scratch::new();
    scratch.file("once.sh", "sleep 600 & echo run >>ran; wait");
    let tasks = "
        [[task]]
        id = 1
        pri = 9
        con = 1
        run = 'sh once.sh'
        [[task]]
        id = 2
        pri = 1
        con = 1
        run = 'sh -c \"echo second >>ran\"'
    ";
    let mission = scratch.file("mission.toml", format!("{MISSION}{tasks}"));
    let journal = scratch.path("kept");
    let words = [mission.to_str().unwrap(), "--journal", journal.to_str().unwrap()];
    let mut run = Run::start(&scratch, &words);
    run.until("started task 1");
    wait_until("the task has begun", || scratch.path("ran").exists());
    run.child.kill().unwrap();
    run.child.wait().unwrap();
    let mut run = Run::start(&scratch, &words);
    run.until("succeeded task 2");
    let said = run.end();
    assert!(said.out.contains("where the journal ends"), "{said:?}");
    let left = |line: &&str| line.starts_with("Ended process ") && line.ends_with("sleep 600");
    let left: Vec<_> = said.out.lines().filter(left).collect();
    assert_eq!(left.len(), 1, "what was left is ended, and told: {said:?}");
    assert!(left[0].contains("of task 1, which an earlier run had left"), "{left:?}");
    let ran = fs::read_to_string(scratch.path("ran")).unwrap();
    assert_eq!(ran, "run\nsecond\n", "the first one is not run twice, the second is not lost");
}

/// As a child does that was frozen as it was forked: here it takes the lock when
/// the manager has died.
#[test]
fn a_leftover_that_has_the_journals_lock_keeps_nobody_from_going_on() {
    let scratch = Scratch::new();
    let keeper = "exec 9<>kept/journal/lock; echo >waits; flock 9; echo >got; exec sleep 600";
    scratch.file("keeper.sh", keeper);
    scratch.file("once.sh", "setsid sh keeper.sh & echo >ran; wait");
    let task = "[[task]]\nid = 1\nrun = 'sh once.sh'\n";
    let mission = scratch.file("mission.toml", format!("{MISSION}{task}"));
    let journal = scratch.path("kept");
    let words = [mission.to_str().unwrap(), "--journal", journal.to_str().unwrap()];
    let mut run = Run::start(&scratch, &words);
    run.until("started task 1");
    wait_until("the leftover waits", || scratch.path("waits").exists());
    run.child.kill().unwrap();
    run.child.wait().unwrap();
    wait_until("the leftover has the lock", || scratch.path("got").exists());
    let mut run = Run::start(&scratch, &words);
    run.until("failed task 1");
    let said = run.end();
    assert!(said.out.contains("Ended process"), "{said:?}");
    assert!(said.out.contains("where the journal ends"), "{said:?}");
}

/// Each attempt takes several descriptors of the manager's, and a shell gives it
/// few to begin with.
#[test]
fn as_many_tasks_run_as_the_host_allows_and_they_have_what_they_were_given() {
    const TASKS: usize = 16;
    let scratch = Scratch::new();
    // None of them ends before all have begun.
    scratch.file(
        "all.sh",
        format!(
            "ulimit -Sn >$FAREGATE_TASK.limit
            until [ $(ls *.limit | wc -l) -ge {TASKS} ]; do sleep 0.1; done"
        ),
    );
    let task = |id| format!("[[task]]\nid = {id}\nrun = 'sh all.sh'\n");
    let tasks: String = (1..=TASKS).map(task).collect();
    let mission = scratch.file("mission.toml", format!("{MISSION}{tasks}"));
    let said: Said = Command::new("sh")
        .args(["-c", "ulimit -Sn 48; exec \"$0\" run \"$1\" --for 60"])
        .args([faregate().get_program(), mission.as_os_str()])
        .current_dir(scratch.path(""))
        .output()
        .unwrap()
        .into();
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains(&format!("{TASKS} succeeded")), "{said:?}");
    for task in 1..=TASKS {
        let limit = fs::read_to_string(scratch.path(&format!("{task}.limit"))).unwrap();
        assert_eq!(limit.trim(), "48", "task {task}");
    }
}

/// The thread that decides sleeps while nothing happens: it waits for no
/// interval, and nothing that it waits for stays ready.
#[test]
fn a_run_in_which_nothing_happens_uses_no_processor() {
    let scratch = Scratch::new();
    let task = "[[task]]\nid = 1\nrun = 'sleep 600'\n";
    let mut run = Run::of(&scratch, task);
    run.until("started task 1");
    let pid = run.child.id();
    let ticks = || {
        let stat = fs::read_to_string(format!("/proc/{pid}/task/{pid}/stat")).unwrap();
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
        // After the name: the state, and eleven more before its times.
        fields[11..=12].iter().map(|field| field.parse::<u64>().unwrap()).sum::<u64>()
    };
    let before = ticks();
    let began = Instant::now();
    wait_until("two seconds are over", || began.elapsed() > Duration::from_secs(2));
    let used = ticks() - before;
    assert!(used <= 5, "{used} hundredths of a second in two seconds");
    assert_eq!(run.end().code, 0);
}

#[test]
fn a_run_goes_on_when_its_display_has_gone() {
    let scratch = Scratch::new();
    let task = "[[task]]\nid = 1\nst = '+1'\nrun = 'touch ran'\n";
    let mission = scratch.file("mission.toml", format!("{MISSION}{task}"));
    let mut child = faregate()
        .arg("run")
        .arg(&mission)
        .current_dir(scratch.path(""))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(scratch.path("ran").exists());
}

/// A terminal in which somebody has stopped the output; here a pipe that nobody
/// reads. The first task says more than a pipe holds.
#[test]
fn a_run_goes_on_when_its_display_stands_still() {
    let scratch = Scratch::new();
    let tasks: String = (1..=8)
        .map(|id| format!("[[task]]\nid = {id}\nrun = 'sh loud.sh'\nmandatory = false\n"))
        .collect();
    scratch.file(
        "loud.sh",
        "yes 0123456789012345678901234567890123456789 | head -c 65536 >&2; exit 1",
    );
    let last = "
        [[task]]
        id = 9
        run = 'touch ran'
        after = [{ task = 1, status = 'failed' }, { task = 2, status = 'failed' },
                 { task = 3, status = 'failed' }, { task = 4, status = 'failed' },
                 { task = 5, status = 'failed' }, { task = 6, status = 'failed' },
                 { task = 7, status = 'failed' }, { task = 8, status = 'failed' }]
    ";
    let mission = scratch.file("mission.toml", format!("{MISSION}{tasks}{last}"));
    let mut child = faregate()
        .arg("run")
        .arg(&mission)
        .current_dir(scratch.path(""))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    wait_until("the last task has run", || scratch.path("ran").exists());
    let mut out = String::new();
    child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(out.len() > 1 << 17, "the control is lost: a pipe holds it all");
    let last = "bus: nothing was drawn of 20 W\n1 succeeded, 8 failed\n";
    assert!(out.ends_with(last), "what is said last is lost: {}", &out[out.len() - 200..]);
    assert!(out.contains(" changes were not told") || out.matches("0123456789\n").count() > 10_000);
}

#[test]
fn a_mandatory_task_that_came_later_makes_the_run_fail_too() {
    let scratch = Scratch::new();
    let mission = scratch.file("mission.toml", MISSION);
    let journal = scratch.path("kept");
    let words = [mission.to_str().unwrap(), "--journal", journal.to_str().unwrap()];
    let upload = |id, run: &str| {
        let task = format!("[[task]]\nid = {id}\nrun = '{run}'\nmandatory = true\n");
        scratch.file("upload.toml", task).display().to_string()
    };
    let mut run = Run::start(&scratch, &words);
    run.must(&["add", &upload(1, "true")]);
    run.until("succeeded task 1");
    run.must(&["add", &upload(2, "sleep 600")]);
    run.until("started task 2");
    run.child.kill().unwrap();
    run.child.wait().unwrap();
    // It was accepted by the run before, and ends in this one.
    let mut run = Run::start(&scratch, &words);
    run.until("failed task 2");
    let said = run.end();
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("the mission needs it, but task 2 failed"), "{said:?}");

    let mut run = Run::start(&scratch, &words);
    run.must(&["add", &upload(3, "false")]);
    run.until("failed task 3");
    let said = run.end();
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("but task 3 failed"), "{said:?}");
}

#[test]
fn what_is_not_there_ends_with_the_code_of_what_is_refused_for_good() {
    let scratch = Scratch::new();
    let mission = scratch.file("mission.toml", MISSION);
    let run = Run::start(&scratch, &[mission.to_str().unwrap()]);
    for words in [
        &["remove", "99"][..],
        &["set", "99", "--priority", "3"],
        &["set", "99", "--window", "+1..+2"],
        &["hold", "99"],
        &["resume", "99"],
        &["status", "99"],
        &["mode", "enter", "spring"],
        &["mode", "leave", "spring"],
    ] {
        let said = run.operate(words);
        assert_eq!(said.code, 5, "{words:?}: {said:?}");
        assert!(said.err.contains("99") || said.err.contains("spring"), "{said:?}");
    }
    assert_eq!(run.end().code, 0);
}
