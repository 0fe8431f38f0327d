//! Everybody outside the manager: who loads the schedule and hears of it, and
//! the sensors.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};

use faregate_scheduler::Task;
use faregate_scheduler::executive::{Correspondent, LoadedFile, Outside, TicketPort, Watched};
use faregate_scheduler::journal::points::{self, Point};
use faregate_scheduler::manager::{
    Addition, Attempt, Event, Manager, Needs, Note, Occurrence, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::task::TaskId;
use faregate_scheduler::tickets::Tickets;
use faregate_scheduler::time::{Instant, Now};
use faregate_tickets::clock::Clock;
use faregate_tickets::device::Estimate;
use rustix::time::{Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, Timespec};

use crate::Break;
use crate::device::{CAMERA, measure};
use crate::schedule::ROUTINE;
use crate::truth::{Chronicle, Fact};

/// How often the sensor is read.
const PERIOD: Timespec = Timespec { tv_sec: 0, tv_nsec: 4_000_000 };
/// How many tasks are loaded at a time.
const LOAD: usize = 3;

/// The operator. Whoever was not answered asks again.
#[derive(Debug)]
pub(crate) struct Operator {
    chronicle: Chronicle,
    loads: Vec<Vec<Task>>,
    asked: usize,
    answered: usize,
    routine_runs: u32,
}

impl Operator {
    pub(crate) fn new(place: &Path, tasks: Vec<Task>, there: &[TaskId]) -> io::Result<Self> {
        let missing: Vec<_> = tasks.into_iter().filter(|task| !there.contains(&task.id)).collect();
        let loads = missing.chunks(LOAD).map(<[_]>::to_vec).collect();
        let chronicle = Chronicle::open(place)?;
        Ok(Self { chronicle, loads, asked: 0, answered: 0, routine_runs: 0 })
    }

    /// Everything was loaded, and the routine task has run since.
    pub(crate) fn is_content(&self) -> bool {
        self.answered == self.loads.len() && self.routine_runs > 0
    }
}

impl Outside for Operator {
    fn note(&mut self, _: Now, note: &Note) {
        match note {
            Note::Over { .. } => points::hit(Point::AfterReap),
            // One that was interrupted is over, too, and did not run in this life.
            Note::Started(attempt) if attempt.occurrence.task.get() == ROUTINE => {
                self.routine_runs += 1;
            }
            _ => {}
        }
    }

    fn answer(&mut self, _: Now, id: TelecommandId, reply: Reply) {
        let load = usize::try_from(id.0).ok().and_then(|index| self.loads.get(index));
        let Some(load) = load else { return };
        self.answered += 1;
        for task in load {
            let accepted = Fact::Accepted(task.id.get());
            if reply != Reply::Done || self.chronicle.note(&accepted).is_err() {
                eprintln!("{}: {reply:?}", task.id);
                std::process::exit(1);
            }
        }
    }

    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        Some(Err("there are no files".into()))
    }
}

impl Watched for Operator {}

impl Correspondent for Operator {
    fn poll(&mut self, _: Now, _: &Manager, events: &mut Vec<Event>) {
        while let Some(load) = self.loads.get(self.asked) {
            let id = TelecommandId(self.asked as u64);
            let additions = load.iter().cloned().map(|task| Addition { task }).collect();
            events.push(Event::Telecommand { id, telecommand: Telecommand::Add(additions) });
            self.asked += 1;
        }
    }
}

/// The tickets, and the camera's sensor.
#[derive(Debug)]
pub(crate) struct Sensed {
    pub(crate) tickets: Tickets,
    place: PathBuf,
    broken: Option<Break>,
    timer: OwnedFd,
}

impl Sensed {
    pub(crate) fn new(tickets: Tickets, place: &Path, broken: Option<Break>) -> io::Result<Self> {
        let flags = TimerfdFlags::CLOEXEC | TimerfdFlags::NONBLOCK;
        let timer = rustix::time::timerfd_create(TimerfdClockId::Monotonic, flags)?;
        let period = Itimerspec { it_interval: PERIOD, it_value: PERIOD };
        rustix::time::timerfd_settime(&timer, TimerfdTimerFlags::empty(), &period)?;
        Ok(Self { tickets, place: place.to_owned(), broken, timer })
    }

    fn measure(&self) {
        // How often it ran out is of no interest.
        let _ = rustix::io::read(&self.timer, &mut [0; 8]);
        let broker = self.tickets.broker();
        let measured_at = broker.clock().now();
        let state = measure(&self.place, self.broken);
        if let Some(gate) = self.tickets.commander().gates().id(CAMERA) {
            broker.observe(gate, Estimate { state, measured_at });
        }
    }
}

impl Watched for Sensed {
    fn fds<'a>(&'a self, fds: &mut Vec<BorrowedFd<'a>>) {
        fds.push(self.timer.as_fd());
        self.tickets.fds(fds);
    }
}

impl TicketPort for Sensed {
    fn request(&mut self, occurrence: Occurrence, needs: &Needs, victims: &[Occurrence], now: Now) {
        self.tickets.request(occurrence, needs, victims, now);
    }

    fn started(&mut self, attempt: Attempt, now: Now) {
        self.tickets.started(attempt, now);
    }

    fn stopped(&mut self, occurrence: Occurrence, now: Now) {
        self.tickets.stopped(occurrence, now);
    }

    fn relinquish(&mut self, occurrence: Occurrence, now: Now) {
        self.tickets.relinquish(occurrence, now);
    }

    fn reserve(&mut self, mode: &str, gates: &[String], now: Now) {
        self.tickets.reserve(mode, gates, now);
    }

    fn unreserve(&mut self, mode: &str, now: Now) {
        self.tickets.unreserve(mode, now);
    }

    fn poll(&mut self, now: Now, events: &mut Vec<Event>) {
        self.measure();
        self.tickets.poll(now, events);
    }

    fn next_due(&self) -> Option<Instant> {
        self.tickets.next_due()
    }
}
