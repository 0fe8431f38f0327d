//! The executive of a host: processes, threads, tickets of a broker, in real
//! time.
//!
//! One thread decides and starts bodies. It sleeps until the next due instant,
//! or until a port has something to tell; it never looks at intervals.

use std::io;
use std::os::fd::{AsFd, BorrowedFd};

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;

use crate::executive::{
    Bodies, Driver, HostClock, JournalSink, LoadedFile, Outside, Ports, TicketPort, Timers, Waker,
};
use crate::manager::{Attempt, Event, Manager, Reply, Restored, Telecommand, TelecommandId};
use crate::mission::Mission;
use crate::time::{Due, Instant, Now};

/// A port that has file descriptors of its own to wait for. One that rings the
/// [`Waker`] instead has none.
pub trait Watched {
    /// Adds what becomes readable when the port has something to tell.
    fn fds<'a>(&'a self, fds: &mut Vec<BorrowedFd<'a>>) {
        let _ = fds;
    }
}

/// Everybody outside: who commands the manager, and who is told.
pub trait Correspondent: Outside + Watched {
    /// What was asked since: telecommands and readings. Questions about the
    /// schedule are answered at once.
    fn poll(&mut self, now: Now, manager: &Manager, events: &mut Vec<Event>);

    /// A schedule file that was to be read later, and has been since.
    fn loaded(&mut self) -> Option<(Attempt, LoadedFile)> {
        // For those who read files at once, or none.
        None
    }
}

/// Runs a schedule in real time.
///
/// Children die with the thread that forks them: keep the executive on one
/// thread, which lives as long as the program.
#[derive(Debug)]
pub struct HostExecutive<B, T, J, O> {
    driver: Driver,
    bodies: B,
    tickets: T,
    journal: J,
    outside: O,
    clock: HostClock,
    timers: Timers,
    waker: Waker,
}

impl<B, T, J, O> HostExecutive<B, T, J, O>
where
    B: Bodies + Watched,
    T: TicketPort + Watched,
    J: JournalSink,
    O: Correspondent,
{
    /// An executive that goes on where a journal ends; an empty
    /// [`Restored`] begins anew. All ports ring this bell.
    ///
    /// # Errors
    /// The journal's, and when the host has no file descriptor left.
    pub fn new(
        mission: Mission,
        restored: Restored,
        waker: Waker,
        clock: HostClock,
        ports: (B, T, J, O),
    ) -> io::Result<Self> {
        let (mut bodies, mut tickets, mut journal, mut outside) = ports;
        let timers = Timers::new(clock)?;
        let mut borrowed = Ports {
            bodies: &mut bodies,
            tickets: &mut tickets,
            journal: &mut journal,
            outside: &mut outside,
        };
        let driver = Driver::restore(mission, restored, clock.now(), &mut borrowed)?;
        Ok(Self { driver, bodies, tickets, journal, outside, clock, timers, waker })
    }

    /// Something happened that no port tells of.
    pub fn tell(&mut self, event: Event) {
        self.driver.tell(event);
    }

    /// The program itself asks something of the manager, and has its answer: at
    /// once, before anything else that happens.
    ///
    /// # Errors
    /// As [`HostExecutive::run`].
    pub fn command(&mut self, telecommand: Telecommand) -> io::Result<Reply> {
        let id = self.driver.ask(telecommand);
        self.answer(id)
    }

    /// The same for several at once, in their order: nothing is decided before
    /// the last of them was taken in, so what the first makes room for does not
    /// start before the second says that it is not to.
    ///
    /// # Errors
    /// As [`HostExecutive::run`].
    pub fn commands(&mut self, telecommands: Vec<Telecommand>) -> io::Result<Vec<Reply>> {
        let asked: Vec<_> = telecommands.into_iter().map(|one| self.driver.ask(one)).collect();
        asked.into_iter().map(|id| self.answer(id)).collect()
    }

    fn answer(&mut self, id: TelecommandId) -> io::Result<Reply> {
        loop {
            if let Some(reply) = self.driver.answered(id) {
                return Ok(reply);
            }
            self.turn()?;
        }
    }

    /// The manager, for questions.
    #[must_use]
    pub fn manager(&self) -> &Manager {
        self.driver.manager()
    }

    /// Everybody outside.
    pub fn outside(&mut self) -> &mut O {
        &mut self.outside
    }

    /// The bodies.
    pub fn bodies(&mut self) -> &mut B {
        &mut self.bodies
    }

    /// The tickets.
    pub fn tickets(&self) -> &T {
        &self.tickets
    }

    /// The ports, when all is over.
    #[must_use]
    pub fn into_ports(self) -> (B, T, J, O) {
        (self.bodies, self.tickets, self.journal, self.outside)
    }

    /// The executive's clock.
    #[must_use]
    pub fn now(&self) -> Now {
        self.clock.now()
    }

    /// Runs until `is_over` says so. It is asked after each decision, and
    /// whenever the thread was woken.
    ///
    /// # Errors
    /// The journal's: then nothing more is carried out, and the program must
    /// end.
    pub fn run(&mut self, is_over: impl FnMut(&Manager, Now) -> bool) -> io::Result<()> {
        self.run_until(Instant::FAR_FUTURE, is_over)
    }

    /// The same, and no longer than until `end`.
    ///
    /// # Errors
    /// As [`HostExecutive::run`].
    pub fn run_until(
        &mut self,
        end: Instant,
        mut is_over: impl FnMut(&Manager, Now) -> bool,
    ) -> io::Result<()> {
        loop {
            let went_on = self.turn()?;
            let now = self.clock.now();
            if now.elapsed >= end || is_over(self.driver.manager(), now) {
                return Ok(());
            }
            if !went_on {
                self.wait_until(end)?;
            }
        }
    }

    /// Takes what has happened by now to the manager, and carries out what it
    /// says. Answers whether there was anything.
    ///
    /// # Errors
    /// As [`HostExecutive::run`].
    pub fn turn(&mut self) -> io::Result<bool> {
        // Before the ports are asked: a ring that comes later ends the wait.
        let _ = self.waker.take();
        let now = self.clock.now();
        let mut events = Vec::new();
        self.outside.poll(now, self.driver.manager(), &mut events);
        for event in events {
            self.driver.tell(event);
        }
        while let Some((attempt, file)) = self.outside.loaded() {
            self.driver.loaded(attempt, file);
        }
        let mut ports = Ports {
            bodies: &mut self.bodies,
            tickets: &mut self.tickets,
            journal: &mut self.journal,
            outside: &mut self.outside,
        };
        self.driver.turn(now, &mut ports)
    }

    /// Sleeps until something is due, or a port has something to tell.
    ///
    /// # Errors
    /// The kernel's.
    pub fn wait(&mut self) -> io::Result<()> {
        self.wait_until(Instant::FAR_FUTURE)
    }

    fn wait_until(&mut self, end: Instant) -> io::Result<()> {
        let Due { elapsed, wall } = self.driver.next_due(&self.bodies, &self.tickets);
        let elapsed = elapsed.into_iter().chain([end]).min();
        self.timers.arm(Due { elapsed: elapsed.filter(|at| *at < Instant::FAR_FUTURE), wall })?;
        let mut fds = Vec::with_capacity(8);
        fds.extend(self.timers.fds());
        let timers = fds.len();
        fds.push(self.waker.as_fd());
        self.bodies.fds(&mut fds);
        self.tickets.fds(&mut fds);
        self.outside.fds(&mut fds);
        let mut waited: Vec<_> =
            fds.into_iter().map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::IN)).collect();
        match poll(&mut waited, None) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let ran_out = waited.iter().take(timers).any(|timer| !timer.revents().is_empty());
        drop(waited);
        if ran_out {
            self.timers.rearm();
        }
        Ok(())
    }
}
