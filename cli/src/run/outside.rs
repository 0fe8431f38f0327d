//! Everybody outside of a real run: the operators' links, the display, signals,
//! and the time after which it ends.

use std::io::{self, Read};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use faregate_scheduler::Manager;
use faregate_scheduler::control::Links;
use faregate_scheduler::executive::{
    Correspondent, HostClock, LoadedFile, Outside, Timers, Watched,
};
use faregate_scheduler::manager::{
    Attempt, Event, Note, Reading, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::time::{Due, Duration, Instant, Now};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::low_level::pipe;

use super::teller::Teller;
use crate::simulation::Craft;

/// The telecommand of the program itself. Those of links count from 0.
const OWN: u64 = 1 << 62;

/// The exit code of a program that an interrupt ends.
const INTERRUPTED: i32 = 130;

/// Everybody outside.
pub(crate) struct Ground {
    pub(crate) links: Links,
    pub(crate) teller: Teller,
    pub(crate) craft: Craft,
    /// Changes that have not been looked at beyond being told.
    pub(crate) changes: Vec<(Now, Note)>,
    /// Whether the manager was told to stop.
    pub(crate) stopping: bool,
    clock: HostClock,
    ends: Option<Instant>,
    timers: Timers,
    signals: UnixStream,
    gauge: Option<u8>,
}

impl Ground {
    /// Everybody outside. The run ends after this time, or by a signal.
    pub(crate) fn new(
        (links, teller, craft): (Links, Teller, Craft),
        time: Option<Duration>,
    ) -> io::Result<Self> {
        let clock = HostClock::start();
        let ends = time.map(|time| clock.now().elapsed.after(time));
        let mut timers = Timers::new(clock)?;
        timers.arm(Due { elapsed: ends, wall: None })?;
        Ok(Self {
            links,
            teller,
            craft,
            changes: Vec::new(),
            stopping: false,
            clock,
            ends,
            timers,
            signals: signals()?,
            gauge: None,
        })
    }

    /// Tells the manager to stop, once.
    pub(crate) fn stop(&mut self, events: &mut Vec<Event>) {
        if !std::mem::replace(&mut self.stopping, true) {
            let id = TelecommandId(OWN);
            events.push(Event::Telecommand { id, telecommand: Telecommand::ShutDown });
        }
    }

    fn signalled(&mut self) -> bool {
        let mut bytes = [0; 16];
        matches!(self.signals.read(&mut bytes), Ok(1..))
    }
}

/// A stream that is readable after an interrupt. The second one ends the
/// program at once.
fn signals() -> io::Result<UnixStream> {
    let (read, write) = UnixStream::pair()?;
    read.set_nonblocking(true)?;
    let again = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first signal finds the flag down.
        signal_hook::flag::register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&again))?;
        signal_hook::flag::register(signal, Arc::clone(&again))?;
        pipe::register(signal, write.try_clone()?)?;
    }
    Ok(read)
}

impl Outside for Ground {
    fn note(&mut self, now: Now, note: &Note) {
        self.teller.tell(now, note);
        self.links.note(now, note);
        self.changes.push((now, note.clone()));
    }

    fn answer(&mut self, now: Now, id: TelecommandId, reply: Reply) {
        // That the manager was told to stop by this program needs no answer.
        if id.0 != OWN {
            self.links.answer(now, id, reply);
        }
    }

    fn load(&mut self, attempt: Attempt, path: &str) -> Option<LoadedFile> {
        self.links.load(attempt, path)
    }
}

impl Watched for Ground {
    fn fds<'a>(&'a self, fds: &mut Vec<BorrowedFd<'a>>) {
        fds.push(self.signals.as_fd());
        if !self.stopping {
            fds.extend(self.timers.fds());
        }
        self.links.fds(fds);
    }
}

impl Correspondent for Ground {
    fn loaded(&mut self) -> Option<(Attempt, LoadedFile)> {
        self.links.loaded()
    }

    fn poll(&mut self, now: Now, manager: &Manager, events: &mut Vec<Event>) {
        self.links.poll(now, manager, events);
        let told = |event: &Event| {
            matches!(event, Event::Telecommand { telecommand: Telecommand::ShutDown, .. })
        };
        self.stopping |= events.iter().any(told);
        let charge = self.craft.state_of_charge();
        if charge != self.gauge {
            self.gauge = charge;
            events.push(Event::Reading(Reading::Battery(charge)));
        }
        let over = self.ends.is_some_and(|ends| self.clock.now().elapsed >= ends);
        if self.signalled() || over || self.craft.lost().is_some() {
            self.stop(events);
        }
    }
}
