//! What a process starts belongs to it, however it goes about it.

use std::collections::BTreeSet;
use std::time;

use faregate_scheduler::bodies::Settings;
use faregate_scheduler::manager::Exit;
use faregate_scheduler::time::Duration;

use super::bench::{Bench, both_ways, shell};
use super::look::{lives, marked, real_time, seen, ticks, until};

/// A loop that uses processor time as long as it runs.
const BUSY: &str = "while :; do :; done";

/// Marks a script's processes, so that a test finds them whatever they do.
fn word(of: &str) -> String {
    static NEXT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
    let next = NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    format!("TEST_MARK={of}.{}.{next}", std::process::id())
}

fn everybody(word: &str, number: usize) -> BTreeSet<i32> {
    until("all processes are there", || {
        let found = marked(word);
        (found.len() >= number).then_some(found)
    })
}

/// Whether these use processor time: a control for the claim that they do not.
fn use_time(pids: &BTreeSet<i32>) {
    for pid in pids {
        let one = BTreeSet::from([*pid]);
        let before = ticks(&one);
        until("it runs", || (ticks(&one) > before).then_some(()));
    }
}

#[test]
fn a_paused_tree_uses_no_processor() {
    both_ways(|mut bench| {
        let word = word("tree");
        let script = format!(
            "export {word}; sh -c '{BUSY}' & (setsid sh -c '{BUSY}' &); exec sh -c '{BUSY}'"
        );
        let attempt = bench.start(shell(&script));
        let tree = everybody(&word, 3);
        use_time(&tree);
        bench.pause(attempt);
        let before = ticks(&tree);
        real_time(time::Duration::from_millis(200));
        assert_eq!(ticks(&tree), before);
        assert_eq!(marked(&word), tree);
        bench.resume(attempt);
        use_time(&tree);
        assert_eq!(bench.kill(attempt, Duration::ZERO), Exit::Signal(9));
        assert_eq!(marked(&word), BTreeSet::new());
    });
}

#[test]
fn a_daemon_of_a_task_is_paused_and_killed_with_it() {
    both_ways(|mut bench| {
        let word = word("daemon");
        // Twice forked, in a session of its own, its parents gone.
        let script = format!("export {word}; (setsid sh -c '({BUSY}) &' &); echo ready; sleep 60");
        let attempt = bench.start(shell(&script));
        bench.line(attempt);
        let me = i32::try_from(std::process::id()).unwrap();
        let main = bench.bodies.pid(attempt).unwrap();
        let daemon = until("the daemon is ours", || {
            let mut found = marked(&word).into_iter().filter_map(seen);
            found.find(|seen| seen.parent == me && ![main, seen.pid].contains(&seen.session))
        });
        let daemon = BTreeSet::from([daemon.pid]);
        use_time(&daemon);
        bench.pause(attempt);
        let before = ticks(&daemon);
        real_time(time::Duration::from_millis(100));
        assert_eq!(ticks(&daemon), before);
        bench.resume(attempt);
        use_time(&daemon);
        assert_eq!(bench.kill(attempt, Duration::from_secs(50)), Exit::Signal(15));
        assert_eq!(marked(&word), BTreeSet::new());
    });
}

#[test]
fn a_daemon_that_cleans_its_environment_is_killed_with_its_task() {
    both_ways(|mut bench| {
        // Its number is told before it is an orphan.
        let script = "sh -c 'setsid env -i sleep 60 & echo $!'; sleep 60";
        let attempt = bench.start(shell(script));
        let daemon: i32 = bench.line(attempt).trim().parse().unwrap();
        assert_eq!(bench.kill(attempt, Duration::from_secs(50)), Exit::Signal(15));
        assert!(!lives(daemon));
    });
}

#[test]
fn nothing_outlives_the_main_process() {
    both_ways(|mut bench| {
        let script = "trap '' TERM; sleep 60 & echo $!; (setsid sleep 60 & echo $!); exit 2";
        let attempt = bench.start(shell(script));
        assert_eq!(bench.exit(attempt), Exit::Code(2));
        let printed = String::from_utf8(bench.bodies.output(attempt).unwrap().stdout.tail).unwrap();
        let left: Vec<i32> = printed.lines().map(|pid| pid.parse().unwrap()).collect();
        assert_eq!(left.len(), 2);
        assert!(left.iter().all(|pid| !lives(*pid)), "{left:?}");
    });
}

/// Each generation starts the next one and ends.
fn generations(bench: &mut Bench, generation: &str) {
    let word = word("generations");
    let script = format!("export {word}; python3 -c '{generation}'; echo begun; sleep 60");
    let attempt = bench.start(shell(&script));
    bench.line(attempt);
    // The sleep, and a generation.
    everybody(&word, 2);
    bench.pause(attempt);
    let still = marked(&word);
    assert!(still.len() >= 2, "the control is lost: nobody is there to go on");
    real_time(time::Duration::from_millis(50));
    assert_eq!(marked(&word), still, "it goes on from one to the next");
    bench.resume(attempt);
    until("it goes on", || (marked(&word) != still).then_some(()));
    assert_eq!(bench.kill(attempt, Duration::ZERO), Exit::Signal(9));
    assert_eq!(marked(&word), BTreeSet::new());
}

#[test]
fn generations_that_live_shortly_are_paused_and_killed() {
    both_ways(|mut bench| {
        generations(&mut bench, "import os\nwhile True:\n if os.fork(): os._exit(0)\n");
    });
}

#[test]
fn generations_that_each_leave_the_session_do_not_leave_their_control_group() {
    let generation = "import os\nwhile True:\n if os.fork(): os._exit(0)\n os.setsid()\n";
    both_ways(|mut bench| {
        // Without a group they are not caught for sure.
        if bench.bodies.control_group().is_ok() {
            generations(&mut bench, generation);
        }
    });
}

#[test]
fn orphans_that_end_are_reaped_while_their_task_runs() {
    both_ways(|mut bench| {
        let script = "for i in 1 2 3 4 5 6 7 8; do (sh -c : & echo $!); done; (sleep 0.2; echo all) & sleep 60";
        let attempt = bench.start(shell(script));
        let printed = bench.printed(attempt, |text| text.contains("all"));
        let orphans: Vec<i32> = printed.lines().filter_map(|line| line.parse().ok()).collect();
        assert_eq!(orphans.len(), 8);
        until("they are reaped", || {
            bench.bodies_poll();
            orphans.iter().all(|pid| seen(*pid).is_none()).then_some(())
        });
        assert_eq!(bench.kill(attempt, Duration::ZERO), Exit::Signal(9));
    });
}

#[test]
fn children_of_somebody_else_keep_their_exit_status() {
    both_ways(|mut bench| {
        let mut own = std::process::Command::new("/bin/sh").args(["-c", "exit 9"]).spawn().unwrap();
        let attempt = bench.start(shell("(sh -c : &); sleep 0.1"));
        assert_eq!(bench.exit(attempt), Exit::Code(0));
        assert_eq!(own.wait().unwrap().code(), Some(9));
    });
}

/// A program that embeds the schedule manager, and waits for any child.
#[test]
fn an_exit_status_that_somebody_else_has_taken_is_a_failure_and_not_for_ever() {
    both_ways(|mut bench| {
        let attempt = bench.start(shell("exit 0"));
        let pid = rustix::process::Pid::from_raw(bench.bodies.pid(attempt).unwrap());
        let taken = rustix::process::waitpid(pid, rustix::process::WaitOptions::empty());
        assert!(taken.unwrap().is_some(), "the control is lost: its status was not taken");
        let why = "somebody else has taken its exit status";
        assert_eq!(bench.exit(attempt), Exit::Failed(why.into()));
    });
}

/// The groups of attempts that the host shows below the manager's.
fn groups(bench: &Bench) -> Option<usize> {
    let path = bench.bodies.control_group().ok()?;
    let entries = std::fs::read_dir(path).unwrap().flatten();
    Some(entries.filter(|entry| entry.file_type().unwrap().is_dir()).count())
}

#[test]
fn a_control_group_that_was_killed_is_replaced_before_the_next_start() {
    let mut bench = Bench::new(Settings::default());
    let Some(before) = groups(&bench) else { return println!("skipped: no control groups") };
    for _ in 0..2 * before {
        let attempt = bench.start(shell("sleep 60"));
        assert_eq!(bench.kill(attempt, Duration::ZERO), Exit::Signal(9));
    }
    assert_eq!(groups(&bench), Some(before));
}

/// As a task does that runs containers.
#[test]
fn a_task_that_makes_control_groups_of_its_own_is_paused_and_leaves_none() {
    let mut bench = Bench::new(Settings::default());
    let Some(before) = groups(&bench) else { return println!("skipped: no control groups") };
    let path = bench.bodies.control_group().unwrap().display().to_string();
    let script = format!(
        "own={path}/$(sed -n 's,^0::.*/,,p' /proc/self/cgroup)
        mkdir $own/below && echo 0 >$own/below/cgroup.procs && echo ready
        i=0; while :; do i=$((i+1)); done"
    );
    let attempt = bench.start(shell(&script));
    assert_eq!(bench.line(attempt), "ready\n");
    bench.pause(attempt);
    bench.resume(attempt);
    assert_eq!(bench.kill(attempt, Duration::ZERO), Exit::Signal(9));
    assert_eq!(groups(&bench), Some(before));
}
