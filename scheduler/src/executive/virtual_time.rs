//! The virtual executive: the clock jumps to what is due next.

use core::fmt;
use std::io;

use crate::executive::{Driver, JournalSink, Outside, Ports, VirtualBodies, VirtualTickets};
use crate::manager::{Event, Manager, Record};
use crate::mission::Mission;
use crate::time::{Due, Instant, Now, UnixTime};

/// A journal that is not kept: what runs on a virtual clock need not be resumed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwritten;

impl JournalSink for Unwritten {
    fn append(&mut self, _: &Record) -> io::Result<()> {
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Decisions of one instant after which it is given up: each of them led to
/// another one, and time does not go on. Far more than tasks that take no time
/// can cause one after the other.
const DECISIONS_AT_AN_INSTANT: u32 = 1_000_000;

/// Time does not go on.
#[derive(Debug)]
pub enum Stuck {
    /// Every decision of this instant leads to another one.
    Endless(Instant),
    /// The journal could not be written.
    Journal(io::Error),
}

impl fmt::Display for Stuck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Endless(at) => write!(
                f,
                "at {at} every decision leads to another one: tasks that take no time and start \
                 each other without end?"
            ),
            Self::Journal(error) => write!(f, "the journal cannot be written: {error}"),
        }
    }
}

impl core::error::Error for Stuck {}

/// Runs a schedule on a clock of its own, in as little real time as it takes to
/// decide.
///
/// The clock starts at 0 when the executive is made. The time of day goes along
/// with it and never jumps.
#[derive(Debug)]
pub struct VirtualExecutive<O, J = Unwritten> {
    driver: Driver,
    bodies: VirtualBodies,
    tickets: VirtualTickets,
    journal: J,
    outside: O,
    began: UnixTime,
    elapsed: Instant,
}

impl<O: Outside> VirtualExecutive<O> {
    /// An executive without tasks, at this time of day.
    #[must_use]
    pub fn new(mission: Mission, at: UnixTime, bodies: VirtualBodies, outside: O) -> Self {
        Self::with_journal(mission, at, bodies, outside, Unwritten)
    }
}

impl<O: Outside, J: JournalSink> VirtualExecutive<O, J> {
    /// The same with a journal.
    #[must_use]
    pub fn with_journal(
        mission: Mission,
        at: UnixTime,
        bodies: VirtualBodies,
        outside: O,
        journal: J,
    ) -> Self {
        Self {
            driver: Driver::new(mission),
            bodies,
            tickets: VirtualTickets::default(),
            journal,
            outside,
            began: at,
            elapsed: Instant::START,
        }
    }

    /// The present.
    #[must_use]
    pub fn now(&self) -> Now {
        Now { elapsed: self.elapsed, wall: self.began.after(self.elapsed.since(Instant::START)) }
    }

    /// The manager, for questions.
    #[must_use]
    pub fn manager(&self) -> &Manager {
        self.driver.manager()
    }

    /// Whoever is told.
    pub fn outside(&mut self) -> &mut O {
        &mut self.outside
    }

    /// Whoever is told, when all is over.
    #[must_use]
    pub fn into_outside(self) -> O {
        self.outside
    }

    /// Something happens at the present instant. [`Self::advance_to`] lets the
    /// manager decide, even with the present instant as its argument.
    pub fn tell(&mut self, event: Event) {
        self.driver.tell(event);
    }

    /// When something happens next, if ever. Never before the present.
    #[must_use]
    pub fn next_due(&self) -> Option<Instant> {
        let Due { elapsed, wall } = self.driver.next_due(&self.bodies, &self.tickets);
        let by_wall = wall.map(|at| Instant::START.after(at.since(self.began)));
        elapsed.into_iter().chain(by_wall).min().map(|due| due.max(self.elapsed))
    }

    /// Lets everything happen that is due until then, and then it is that late.
    ///
    /// # Errors
    /// When time does not go on.
    pub fn advance_to(&mut self, instant: Instant) -> Result<(), Stuck> {
        self.settle()?;
        while let Some(due) = self.next_due().filter(|due| *due <= instant) {
            self.elapsed = due;
            self.settle()?;
        }
        self.elapsed = self.elapsed.max(instant);
        Ok(())
    }

    /// Takes decisions until this instant has no more to say.
    fn settle(&mut self) -> Result<(), Stuck> {
        let now = self.now();
        for _ in 0..DECISIONS_AT_AN_INSTANT {
            let mut ports = Ports {
                bodies: &mut self.bodies,
                tickets: &mut self.tickets,
                journal: &mut self.journal,
                outside: &mut self.outside,
            };
            if !self.driver.turn(now, &mut ports).map_err(Stuck::Journal)? {
                return Ok(());
            }
        }
        Err(Stuck::Endless(now.elapsed))
    }
}
