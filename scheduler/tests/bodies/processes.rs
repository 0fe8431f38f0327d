//! One process: how it is started, how it ends, what it is told.

use faregate_scheduler::bodies::Settings;
use faregate_scheduler::manager::{Event, Exit, Stop};
use faregate_scheduler::task::{Body, CheckpointSignal};
use faregate_scheduler::time::Duration;

use super::bench::{Bench, both_ways, shell};
use super::look::{self, lives};

fn program(program: &str, arguments: &[&str]) -> Body {
    let arguments = arguments.iter().map(ToString::to_string).collect();
    Body::Process { program: program.into(), arguments }
}

fn not_started(bench: &mut Bench, body: Body) -> String {
    let attempt = bench.start(body);
    match bench.exit(attempt) {
        Exit::NotStarted(why) => why,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_process_ends_with_its_exit_code_or_its_signal() {
    both_ways(|mut bench| {
        for (script, exit) in [
            ("exit 0", Exit::Code(0)),
            ("exit 7", Exit::Code(7)),
            ("exit 127", Exit::Code(127)),
            ("kill -SEGV $$", Exit::Signal(11)),
            ("kill -KILL $$", Exit::Signal(9)),
        ] {
            let attempt = bench.start(shell(script));
            assert_eq!(bench.exit(attempt), exit, "{script}");
        }
        assert_eq!(bench.told(), []);
    });
}

#[test]
fn what_cannot_be_executed_says_why_and_what_to_do() {
    let mut bench = Bench::new(Settings::default());
    let why = not_started(&mut bench, program("no-such-program-here", &[]));
    assert!(why.contains("\"no-such-program-here\" in PATH ("), "{why}");
    let why = not_started(&mut bench, program("/no/such", &[]));
    assert!(why.contains("/no/such: No such file") && !why.contains("seen from"), "{why}");
    let why = not_started(&mut bench, program("./no-such", &[]));
    let here = std::env::current_dir().unwrap();
    assert!(why.ends_with(&format!("; seen from {}", here.display())), "{why}");
    let why = not_started(&mut bench, program("/tmp", &[]));
    assert!(why.contains("not a file"), "{why}");
    let why = not_started(&mut bench, program("/etc/passwd", &[]));
    assert!(why.contains("chmod +x"), "{why}");
    let why = not_started(&mut bench, program("sh", &["a\0b"]));
    assert!(why.contains("zero byte"), "{why}");
}

#[test]
fn a_failed_exec_is_not_an_exit_code() {
    use std::os::unix::fs::PermissionsExt;
    let mut bench = Bench::new(Settings::default());
    let directory = tempfile::tempdir().unwrap();
    let mut script = |name: &str, text: &str| {
        let path = directory.path().join(name);
        std::fs::write(&path, text).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        not_started(&mut bench, program(path.to_str().unwrap(), &[]))
    };
    let why = script("headless", "echo hello\n");
    assert!(why.contains("begins with #!"), "{why}");
    let why = script("lost", "#!/no/such/interpreter\n");
    assert!(why.contains("interpreter or loader"), "{why}");
}

#[test]
fn a_name_without_a_slash_is_looked_up_in_path() {
    let mut bench = Bench::new(Settings::default());
    let attempt = bench.start(program("true", &[]));
    assert_eq!(bench.exit(attempt), Exit::Code(0));
}

#[test]
fn a_process_knows_who_it_is_and_has_nothing_of_the_managers() {
    // A descriptor that no exec closes by itself.
    let open = rustix::io::dup(std::io::stdin()).unwrap();
    assert!(!rustix::io::fcntl_getfd(&open).unwrap().contains(rustix::io::FdFlags::CLOEXEC));
    both_ways(|mut bench| {
        let attempt = bench.start(shell(
            "echo $FAREGATE_TASK $FAREGATE_OCCURRENCE $FAREGATE_ATTEMPT ${FAREGATE_PORT-none}
             for fd in /proc/$$/fd/*; do [ -e $fd ] && echo -n \"${fd##*/} \"; done; readlink /proc/$$/fd/0
             grep -E '^Sig(Blk|Ign)' /proc/self/status | tr -d '\\n\\t'; echo; echo $$ $(ps -o sid= $$)",
        ));
        assert_eq!(bench.exit(attempt), Exit::Code(0));
        let printed = String::from_utf8(bench.bodies.output(attempt).unwrap().stdout.tail).unwrap();
        let lines: Vec<_> = printed.lines().collect();
        let task = attempt.occurrence.task.get();
        assert_eq!(lines[0], format!("{task} 3 2 none"));
        assert_eq!(lines[1], "0 1 2 /dev/null");
        let zeros = "0000000000000000";
        assert_eq!(lines[2], format!("SigBlk:{zeros}SigIgn:{zeros}"));
        let (pid, session) = lines[3].split_once(' ').unwrap();
        assert_eq!(pid, session, "it has no session of its own");
    });
}

#[test]
fn the_end_of_what_it_prints_is_kept() {
    let settings = Settings { output_kept: 6, ..Settings::default() };
    let mut bench = Bench::new(settings);
    let attempt = bench.start(shell("seq 1 100000; echo oops >&2"));
    assert_eq!(bench.exit(attempt), Exit::Code(0));
    let output = bench.bodies.output(attempt).unwrap();
    assert_eq!(output.stdout.tail, b"00000\n");
    let all: u64 = (1..=100_000_u32).map(|n| u64::try_from(n.to_string().len()).unwrap() + 1).sum();
    assert_eq!(output.stdout.dropped, all - 6);
    assert_eq!((&*output.stderr.tail, output.stderr.dropped), (&b"oops\n"[..], 0));
}

#[test]
fn what_does_not_heed_the_term_is_killed_after_the_grace() {
    both_ways(|mut bench| {
        let deaf = bench.start(shell("trap '' TERM; echo ready; while :; do sleep 1; done"));
        bench.line(deaf);
        assert_eq!(bench.kill(deaf, Duration::from_millis(50)), Exit::Signal(9));
        let polite =
            bench.start(shell("trap 'exit 5' TERM; echo ready; while :; do sleep 0.01; done"));
        bench.line(polite);
        assert_eq!(bench.kill(polite, Duration::from_secs(50)), Exit::Code(5));
    });
}

#[test]
fn a_checkpoint_tells_the_main_process_and_waits_for_its_end() {
    both_ways(|mut bench| {
        let script = "trap 'echo saved; exit 3' HUP; echo ready; while :; do sleep 0.01; done";
        let attempt = bench.start(shell(script));
        bench.line(attempt);
        let how =
            Stop::Checkpoint { grace: Duration::from_secs(50), signal: CheckpointSignal::HangUp };
        bench.stop(attempt, how);
        assert_eq!(bench.exit(attempt), Exit::Code(3));
        assert_eq!(bench.bodies.output(attempt).unwrap().stdout.tail, b"ready\nsaved\n");
    });
}

#[test]
fn a_paused_process_is_told_that_it_goes_on_and_is_the_same_one() {
    both_ways(|mut bench| {
        let script = "trap 'echo on; exit 4' CONT; echo ready; while :; do sleep 0.01; done";
        let attempt = bench.start(shell(script));
        bench.line(attempt);
        let pid = bench.bodies.pid(attempt);
        bench.pause(attempt);
        assert_eq!(bench.bodies.pid(attempt), pid);
        bench.resume(attempt);
        assert_eq!(bench.exit(attempt), Exit::Code(4));
    });
}

#[test]
fn a_paused_process_can_be_killed_and_gets_its_grace() {
    both_ways(|mut bench| {
        let script = "trap 'exit 6' TERM; echo ready; while :; do sleep 0.01; done";
        let attempt = bench.start(shell(script));
        bench.line(attempt);
        bench.pause(attempt);
        assert_eq!(bench.kill(attempt, Duration::from_secs(50)), Exit::Code(6));
    });
}

#[test]
fn a_paused_process_that_somebody_kills_is_over() {
    both_ways(|mut bench| {
        let attempt = bench.start(shell("echo ready; while :; do sleep 1; done"));
        bench.line(attempt);
        bench.pause(attempt);
        let pid = rustix::process::Pid::from_raw(bench.bodies.pid(attempt).unwrap()).unwrap();
        rustix::process::kill_process(pid, rustix::process::Signal::KILL).unwrap();
        assert_eq!(bench.exit(attempt), Exit::Signal(9));
    });
}

#[test]
fn memory_is_that_of_the_whole_tree() {
    both_ways(|mut bench| {
        let one = bench.start(shell("echo ready; sleep 60"));
        bench.line(one);
        let two =
            bench.start(shell("sleep 60 & (setsid sh -c 'sleep 60; :' &) ; echo ready; wait"));
        bench.line(two);
        let measure = |attempt| bench.bodies.memory(attempt).unwrap();
        look::until("the larger tree uses more", || {
            (measure(one) > 0 && measure(two) > measure(one)).then_some(())
        });
    });
}

#[test]
fn bodies_that_are_dropped_leave_nothing_behind() {
    both_ways(|mut bench| {
        let attempt = bench.start(shell("trap '' TERM HUP; (setsid sleep 60 & echo $!); sleep 60"));
        let grandchild: i32 = bench.line(attempt).trim().parse().unwrap();
        let main = bench.bodies.pid(attempt).unwrap();
        let group = bench.bodies.control_group().ok().map(std::path::Path::to_owned);
        assert!(lives(main) && lives(grandchild));
        drop(bench);
        assert!(!lives(main) && !lives(grandchild));
        assert!(group.is_none_or(|group| !group.exists()), "its control group is left");
    });
}

#[test]
fn nothing_is_told_of_a_stop_that_nobody_waits_for() {
    both_ways(|mut bench| {
        let attempt = bench.start(shell("echo ready; exec sleep 60"));
        bench.line(attempt);
        bench.stop(attempt, Stop::Pause);
        bench.resume(attempt);
        assert_eq!(bench.kill(attempt, Duration::ZERO), Exit::Signal(9));
        assert!(!bench.told().contains(&Event::Stopped { attempt }));
    });
}

#[test]
fn a_process_that_runs_wakes_nobody() {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    both_ways(|mut bench| {
        let attempt = bench.start(shell("echo ready; exec sleep 60"));
        bench.line(attempt);
        let moment = Timespec { tv_sec: 0, tv_nsec: 20_000_000 };
        // Other tests' children ring the bell as well, but not all the time.
        let quiet = (0..1000).any(|_| {
            bench.bodies_poll();
            poll(&mut [PollFd::new(&bench.bodies, PollFlags::IN)], Some(&moment)) == Ok(0)
        });
        assert!(quiet, "the manager's thread never sleeps");
    });
}

#[test]
fn a_process_that_waits_in_the_kernel_for_a_stopped_child_stands_still() {
    both_ways(|mut bench| {
        let directory = tempfile::tempdir().unwrap();
        let fifo = directory.path().join("fifo");
        let fifo = fifo.to_str().unwrap();
        // The child opens a pipe that nobody writes to before its program is
        // executed, and the parent waits for that, past all signals.
        let script = format!(
            "import os; os.mkfifo({fifo:?}); print(1, flush=True); \
             os.posix_spawn('/bin/true', ['true'], {{}}, \
             file_actions=[(os.POSIX_SPAWN_OPEN, 0, {fifo:?}, os.O_RDONLY, 0)])"
        );
        let attempt = bench.start(program("python3", &["-c", &script]));
        bench.line(attempt);
        let pid = bench.bodies.pid(attempt).unwrap();
        let waits = || look::seen(pid).is_some_and(|seen| seen.state == 'D');
        look::until("it waits in the kernel", || waits().then_some(()));
        bench.pause(attempt);
        assert!(waits());
        bench.resume(attempt);
        drop(std::fs::OpenOptions::new().write(true).open(fifo).unwrap());
        assert_eq!(bench.exit(attempt), Exit::Code(0));
    });
}
