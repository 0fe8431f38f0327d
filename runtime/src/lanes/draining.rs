//! The thread that drains the recorder.

use std::io;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use faregate_tickets::clock::{Clock, Duration};

use super::Recorder;
use crate::clock::MonotonicClock;
use crate::wake::{Wakeup, Woken};

/// A thread that drains a recorder, until it is stopped or dropped.
#[derive(Debug)]
pub struct Draining {
    stop: Arc<Wakeup>,
    /// `None` once joined.
    thread: Option<JoinHandle<Recorder>>,
}

impl Recorder {
    /// Drains from a thread of its own, once per `period`.
    ///
    /// A period, because a lane cannot ring: a wake-up is a system call, and
    /// lanes are written inside critical sections.
    ///
    /// The thread inherits the CPUs of its starter: start it before the
    /// starter asks for a CPU of its own.
    ///
    /// # Errors
    /// When the host has no thread or no file descriptor left.
    pub fn start(self, period: Duration) -> io::Result<Draining> {
        let stop = Arc::new(Wakeup::new()?);
        let stopped = Arc::clone(&stop);
        let thread = thread::Builder::new()
            .name("faregate-recorder".into())
            .spawn(move || drain_until(&stopped, self, period))?;
        Ok(Draining { stop, thread: Some(thread) })
    }
}

impl Draining {
    /// Drains once more, ends the thread, and gives the recorder back.
    ///
    /// # Errors
    /// What the thread panicked with: a `tracing` subscriber's doing.
    pub fn stop(mut self) -> thread::Result<Recorder> {
        self.end().unwrap_or_else(|| Ok(Recorder::new()))
    }

    fn end(&mut self) -> Option<thread::Result<Recorder>> {
        self.stop.notify();
        self.thread.take().map(JoinHandle::join)
    }
}

impl Drop for Draining {
    /// Drains once more and ends the thread.
    fn drop(&mut self) {
        // A subscriber's panic has already been told by the panic hook.
        let _ = self.end();
    }
}

fn drain_until(stop: &Wakeup, mut recorder: Recorder, period: Duration) -> Recorder {
    let clock = MonotonicClock::new();
    loop {
        recorder.drain();
        match stop.wait_until(Some(clock.now().after(period))) {
            Ok(Woken::Deadline) => {}
            Ok(Woken::Notified) => break,
            Err(error) => {
                tracing::error!(target: "faregate", %error, "the flight recorder stops draining");
                break;
            }
        }
    }
    recorder.drain();
    recorder
}
