//! A manager that is killed: what dies with it, and what the next one ends.

use std::collections::BTreeSet;
use std::env;
use std::io::{BufRead, BufReader, ErrorKind};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use faregate_scheduler::bodies::{RealBodies, Settings, Surroundings, Swept, sweep};
use faregate_scheduler::executive::Waker;

use super::bench::{Bench, shell};
use super::look::{command, lives, marked, until};

const STATE: &str = "TEST_STATE";
const GROUPS: &str = "TEST_CONTROL_GROUPS";

/// A task whose main process has a child, and a daemon that leaves its session.
const TASK: &str = "trap '' TERM HUP; (setsid sleep 600 &); sleep 600 & wait";

#[test]
#[ignore = "the manager that other tests start in a process of its own, and kill"]
fn manager() {
    let state = env::var_os(STATE).expect("to be started by another test");
    let control_groups = env::var_os(GROUPS).is_some();
    let settings = Settings { state: Some(state.into()), control_groups, ..Settings::default() };
    let mut bench = Bench::new(settings);
    let attempt = bench.start(shell(TASK));
    // The harness has begun this line.
    println!("\nmain {}", bench.bodies.pid(attempt).unwrap());
    bench.exit(attempt);
}

/// A manager in a process of its own, and the number of its task's process.
fn manager_with(state: &Path, control_groups: bool, mark: &str) -> (Child, i32) {
    let (name, value) = mark.split_once('=').unwrap();
    let mut program = Command::new(env::current_exe().unwrap());
    program.args(["bodies::leftovers::manager", "--exact", "--ignored", "--nocapture"]);
    program.env(STATE, state).env(name, value).stdout(Stdio::piped());
    if control_groups {
        program.env(GROUPS, "");
    }
    let mut manager = program.spawn().unwrap();
    let lines = BufReader::new(manager.stdout.take().unwrap()).lines();
    let mut mains = lines
        .map_while(Result::ok)
        .filter_map(|line| line.strip_prefix("main ").and_then(|pid| pid.parse().ok()));
    let main = mains.next().expect("a manager with a task");
    (manager, main)
}

#[test]
fn what_a_killed_manager_leaves_is_ended_by_the_next() {
    for control_groups in [true, false] {
        let state = tempfile::tempdir().unwrap();
        let mark = format!("TEST_MARK=left.{control_groups}.{}", std::process::id());
        let (mut manager, main) = manager_with(state.path(), control_groups, &mark);
        let own = i32::try_from(manager.id()).unwrap();
        let tree = until("the task's two sleepers are there", || {
            let found: BTreeSet<i32> =
                marked(&mark).into_iter().filter(|pid| *pid != own).collect();
            let sleepers = found.iter().filter(|pid| command(**pid) == "sleep 600").count();
            (sleepers == 2 && found.len() == 3).then_some(found)
        });
        let used = sweep(state.path()).unwrap_err();
        assert_eq!(used.kind(), ErrorKind::AddrInUse, "it swept a living manager's: {used}");
        assert!(tree.iter().all(|pid| lives(*pid)));

        manager.kill().unwrap();
        manager.wait().unwrap();
        until("the main process dies with its manager", || (!lives(main)).then_some(()));
        let left: BTreeSet<i32> = tree.iter().copied().filter(|pid| lives(*pid)).collect();
        assert_eq!(left.len(), 2, "the control is lost: nothing was left");

        let next = Settings { state: Some(state.path().into()), ..Settings::default() };
        let bodies = RealBodies::new(next, Waker::new().unwrap(), Surroundings::default()).unwrap();
        assert!(left.iter().all(|pid| !lives(*pid)));
        let swept: BTreeSet<_> = bodies.swept().iter().map(|swept| swept.pid).collect();
        assert_eq!(swept, left);
        let as_said = |s: &Swept| s.task == Some(1) && s.command == "sleep 600";
        assert!(bodies.swept().iter().all(as_said), "{:?}", bodies.swept());
        drop(bodies);
        assert_eq!(sweep(state.path()).unwrap(), []);
    }
}

#[test]
fn a_manager_that_ends_leaves_nothing_to_sweep() {
    let state = tempfile::tempdir().unwrap();
    let settings = Settings { state: Some(state.path().into()), ..Settings::default() };
    let mut bench = Bench::new(settings);
    bench.start(shell(TASK));
    assert!(state.path().join("bodies.json").exists());
    drop(bench);
    assert_eq!(std::fs::read_dir(state.path()).unwrap().count(), 0);
}

#[test]
fn a_file_that_a_loss_of_power_has_torn_keeps_nobody_from_starting() {
    let state = tempfile::tempdir().unwrap();
    let file = state.path().join("bodies.json");
    for torn in ["", "{\"run\":\"8319", "\0\0\0"] {
        std::fs::write(&file, torn).unwrap();
        assert_eq!(sweep(state.path()).unwrap(), []);
        assert!(!file.exists());
    }
}

#[test]
fn processes_of_an_earlier_boot_are_nobodys() {
    let state = tempfile::tempdir().unwrap();
    let settings = Settings { state: Some(state.path().into()), ..Settings::default() };
    let mut bench = Bench::new(settings);
    let attempt = bench.start(shell("sleep 60"));
    let file = state.path().join("bodies.json");
    let boot = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap();
    let written = std::fs::read_to_string(&file).unwrap();
    let earlier = written.replace(boot.trim(), "00000000-0000-0000-0000-000000000000");
    assert_ne!(earlier, written);
    std::fs::write(&file, earlier).unwrap();
    assert_eq!(sweep(state.path()).unwrap(), []);
    assert!(lives(bench.bodies.pid(attempt).unwrap()));
}
