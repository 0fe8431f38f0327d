//! A run in real time with its operator: real processes, the control socket,
//! commands from inside tasks.
#![cfg(target_os = "linux")]

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use support::{Said, Scratch, case_file, faregate};

/// How long anything may take that must come: a slow machine takes its time.
const PATIENCE: Duration = Duration::from_secs(60);

/// A run with a control socket.
struct Run {
    child: Child,
    lines: BufReader<ChildStdout>,
    seen: Vec<String>,
    socket: PathBuf,
}

impl Run {
    fn start(scratch: &Scratch, words: &[&str]) -> Self {
        let socket = scratch.path("faregate.sock");
        let program = Path::new(env!("CARGO_BIN_EXE_faregate")).parent().unwrap();
        // Scripts inside tasks call the program by its name.
        let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
        let mut child = faregate()
            .arg("run")
            .args(words)
            .arg("--socket")
            .arg(&socket)
            .env("PATH", path)
            .current_dir(scratch.path(""))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap());
        let mut run = Self { child, lines, seen: Vec::new(), socket };
        wait_until("the socket is there", || {
            let over = run.child.try_wait().unwrap();
            assert!(over.is_none(), "{:?}", run.ended());
            run.socket.exists()
        });
        run
    }

    /// Calls the program as an operator does.
    fn operate(&self, words: &[&str]) -> Said {
        let output = faregate().args(words).arg("--socket").arg(&self.socket).output().unwrap();
        output.into()
    }

    fn must(&self, words: &[&str]) -> Said {
        let said = self.operate(words);
        assert_eq!(said.code, 0, "{words:?}: {said:?}");
        said
    }

    /// The state of a task, as an operator is told.
    fn state(&self, task: &str) -> Value {
        let said = self.must(&["status", task, "--format", "json"]);
        said.json()["tasks"][0].clone()
    }

    /// Reads lines until one tells this.
    fn until(&mut self, words: &str) -> &str {
        loop {
            let mut line = String::new();
            assert!(self.lines.read_line(&mut line).unwrap() > 0, "no {words} in {:#?}", self.seen);
            let told = line.split_whitespace().collect::<Vec<_>>().join(" ");
            self.seen.push(told);
            let last = self.seen.last().unwrap();
            if last.contains(words) {
                return self.seen.last().unwrap();
            }
        }
    }

    /// Ends it in order.
    fn end(mut self) -> Said {
        self.must(&["shutdown"]);
        self.ended()
    }

    /// What it said, when it has ended by itself.
    fn ended(&mut self) -> Said {
        let mut out = self.seen.join("\n");
        self.lines.read_to_string(&mut out).unwrap();
        let mut err = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        let code = self.child.wait().unwrap().code().expect("it dies of no signal");
        Said { code, out, err }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        // Only where a test has failed: it has ended else.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[expect(clippy::disallowed_methods, reason = "processes of the host take real time")]
fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < PATIENCE, "never: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

const MISSION: &str = "
[mission]
name = 'test'
[mission.categories]
camera = 0
[[mission.agent]]
name = 'bus'
supply_w = 20
[[mission.device]]
name = 'camera'
kind = 'camera'
[[mission.device]]
name = 'heater'
kind = 'heater'
[[mission.mode]]
name = 'eclipse'
reserves = ['heater']
floor = 100
";

#[test]
fn an_operator_adds_holds_changes_and_removes_tasks_of_a_running_schedule() {
    let scratch = Scratch::new();
    let mission = scratch.file("mission.toml", MISSION);
    let mut run = Run::start(&scratch, &[mission.to_str().unwrap()]);
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
    let mission = scratch.file("mission.toml", MISSION);
    let run = Run::start(&scratch, &[mission.to_str().unwrap()]);
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
    let mission = scratch.file("mission.toml", format!("{MISSION}{task}"));
    let mut run = Run::start(&scratch, &[mission.to_str().unwrap()]);
    run.until("succeeded task 1");
    let said = fs::read_to_string(scratch.path("said")).unwrap();
    assert_eq!(said, "camera: 0\nunknown: 5\nundeclared: 5\nnothing: 5\nheartbeat: 0\n");
    let said = run.end();
    assert!(said.out.contains("bus: never more than 9 W of 20 W"), "the camera was on: {said:?}");
}

#[test]
fn what_a_failing_task_printed_is_shown_and_a_terminal_obeys_nothing_of_it() {
    let scratch = Scratch::new();
    scratch.file("script.sh", "printf 'no\\033[2J film\\n' >&2; exit 3");
    let task = "[[task]]\nid = 1\nrun = 'sh script.sh'\n";
    let mission = scratch.file("mission.toml", format!("{MISSION}{task}"));
    let mut run = Run::start(&scratch, &[mission.to_str().unwrap()]);
    run.until("failed task 1");
    let shown = run.until("film").to_owned();
    assert!(!shown.contains('\u{1b}'), "{shown:?}");
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
    let mission = scratch.file("mission.toml", format!("{MISSION}{tasks}"));
    let mut run = Run::start(&scratch, &[mission.to_str().unwrap()]);
    run.until("paused task 1");
    run.until("started task 2");
    run.until("resumed task 1");
    run.until("succeeded task 1");
    let said = run.end();
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("2 succeeded"), "{said:?}");
}

#[test]
fn a_mode_takes_its_gates_and_gives_them_back() {
    let scratch = Scratch::new();
    let task = "[[task]]\nid = 1\nrun = 'sleep 600'\ngates = ['heater']\npri = 10\n";
    let mission = scratch.file("mission.toml", format!("{MISSION}{task}"));
    let mut run = Run::start(&scratch, &[mission.to_str().unwrap()]);
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
    let mission = scratch.file("mission.toml", MISSION);
    let run = Run::start(&scratch, &[mission.to_str().unwrap()]);
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

#[test]
fn an_interrupt_ends_the_tasks_in_order() {
    let scratch = Scratch::new();
    scratch
        .file("careful.sh", "trap 'echo saved >saved; exit 0' TERM; while :; do sleep 0.1; done");
    let task = "[[task]]\nid = 1\nrun = 'sh careful.sh'\npreempt = 'kill'\ngrace = 30\n";
    let mission = scratch.file("mission.toml", format!("{MISSION}{task}"));
    let mut run = Run::start(&scratch, &[mission.to_str().unwrap()]);
    run.until("started task 1");
    // The trap is set a moment after the start.
    wait_until("the script runs", || {
        let pid = format!("/proc/{}/task/{0}/children", run.child.id());
        fs::read_to_string(pid).is_ok_and(|children| !children.trim().is_empty())
    });
    let pid = run.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let said = run.ended();
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("task 1"), "{said:?}");
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
    scratch.file("once.sh", "echo run >>ran; sleep 600");
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
    let ran = fs::read_to_string(scratch.path("ran")).unwrap();
    assert_eq!(ran, "run\nsecond\n", "the first one is not run twice, the second is not lost");
}
