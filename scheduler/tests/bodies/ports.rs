//! When a process gets its command port, when it is told something, and when
//! the port is closed.

use std::io::Write;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, Mutex};

use faregate_scheduler::bodies::{Settings, Surroundings};
use faregate_scheduler::executive::{PortFactory, PortNotice};
use faregate_scheduler::manager::{Attempt, Exit, Stop};
use faregate_scheduler::task::{Body, CheckpointSignal};
use faregate_scheduler::time::Duration;

use super::bench::{Bench, shell};

#[derive(Clone, Debug, PartialEq, Eq)]
enum Done {
    Opened,
    Told(PortNotice),
    Closed,
}

/// Ports that write one line, and keep count.
#[derive(Default)]
struct Ports {
    done: Arc<Mutex<Vec<Done>>>,
    ends: Vec<(Attempt, UnixStream)>,
    /// Whether a command is in progress.
    busy: Arc<AtomicBool>,
}

impl PortFactory for Ports {
    fn open(&mut self, attempt: Attempt) -> std::io::Result<Option<OwnedFd>> {
        let (mut ours, theirs) = UnixStream::pair()?;
        ours.write_all(b"hello\n")?;
        self.ends.push((attempt, ours));
        self.done.lock().unwrap().push(Done::Opened);
        Ok(Some(theirs.into()))
    }

    fn tell(&mut self, _: Attempt, notice: PortNotice) {
        self.done.lock().unwrap().push(Done::Told(notice));
    }

    fn close(&mut self, attempt: Attempt) {
        self.ends.retain(|(of, _)| *of != attempt);
        self.done.lock().unwrap().push(Done::Closed);
    }

    fn is_quiet(&self, _: Attempt) -> bool {
        !self.busy.load(SeqCst)
    }
}

fn bench() -> (Bench, Arc<Mutex<Vec<Done>>>) {
    let ports = Ports::default();
    let done = Arc::clone(&ports.done);
    let around = Surroundings { ports: Box::new(ports), ..Surroundings::default() };
    (Bench::around(Settings::default(), around), done)
}

#[test]
fn a_process_reads_from_its_port_and_nobody_else_has_it() {
    let (mut bench, done) = bench();
    let attempt =
        bench.start(shell("read -r line <&$FAREGATE_PORT; echo $FAREGATE_PORT $line; cat <&3"));
    // The second read ends when the manager's end is closed: by the kill.
    assert_eq!(bench.line(attempt), "3 hello\n");
    assert_eq!(*done.lock().unwrap(), [Done::Opened]);
    assert_eq!(bench.kill(attempt, Duration::ZERO), Exit::Signal(9));
    assert_eq!(*done.lock().unwrap(), [Done::Opened, Done::Closed]);
}

#[test]
fn a_process_is_told_through_its_port_that_it_is_stopped_and_goes_on() {
    let (mut bench, done) = bench();
    let attempt =
        bench.start(shell("trap 'exit 0' USR1; echo ready; while :; do sleep 0.01; done"));
    bench.line(attempt);
    bench.pause(attempt);
    bench.resume(attempt);
    let grace = Duration::from_secs(50);
    bench.stop(attempt, Stop::Checkpoint { grace, signal: CheckpointSignal::User1 });
    assert_eq!(bench.exit(attempt), Exit::Code(0));
    let told = [PortNotice::Resumed, PortNotice::Checkpoint { grace }].map(Done::Told);
    let [resumed, checkpoint] = told;
    assert_eq!(*done.lock().unwrap(), [Done::Opened, resumed, checkpoint, Done::Closed]);
}

#[test]
fn the_port_of_what_could_not_be_started_is_closed() {
    let (mut bench, done) = bench();
    let attempt = bench.start(Body::Process { program: "/no/such".into(), arguments: vec![] });
    assert!(matches!(bench.exit(attempt), Exit::NotStarted(_)));
    assert_eq!(*done.lock().unwrap(), [Done::Opened, Done::Closed]);
}

#[test]
fn an_attempt_is_over_when_no_command_of_it_is_in_progress() {
    let ports = Ports::default();
    let (done, busy) = (Arc::clone(&ports.done), Arc::clone(&ports.busy));
    busy.store(true, SeqCst);
    let around = Surroundings { ports: Box::new(ports), ..Surroundings::default() };
    let mut bench = Bench::around(Settings::default(), around);
    let attempt = bench.start(shell("exit 0"));
    while !done.lock().unwrap().contains(&Done::Closed) {
        bench.turn();
    }
    bench.ring();
    bench.turn();
    assert!(!bench.has_told(attempt), "its process is gone, and its command is not");
    busy.store(false, SeqCst);
    bench.ring();
    assert_eq!(bench.exit(attempt), Exit::Code(0));
}
