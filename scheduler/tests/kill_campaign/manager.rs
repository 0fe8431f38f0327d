//! The manager that is killed: journal, processes, tickets of a broker, command
//! ports, in real time.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use faregate_scheduler::bodies::{Moment, Probe, RealBodies, Settings, Surroundings, sweep};
use faregate_scheduler::executive::{HostClock, HostExecutive, JournalSink, Waker};
use faregate_scheduler::journal::points::{self, Point, census};
use faregate_scheduler::journal::{Compaction, Damage, Journal, Options};
use faregate_scheduler::manager::{Attempt, Manager, Record, State};
use faregate_scheduler::port::CommandServer;
use faregate_scheduler::tickets::Installation;

use crate::crew::{Operator, Sensed};
use crate::truth::{Chronicle, Fact, read};
use crate::{Break, Failure};
use crate::{device, schedule};

/// How long a task's process may take to begin before it is killed unseen.
const PATIENCE: Duration = Duration::from_secs(20);

/// The journal of this place. It is compacted often, so that it is killed
/// while it is.
pub(crate) fn journal(place: &Path) -> PathBuf {
    place.join("journal")
}

pub(crate) const OPTIONS: Options =
    Options { compact_above: 1_000, compaction: Compaction::Background, damage: Damage::Refuse };

/// Lives until all is done. Prints how often it came to each point.
pub(crate) fn live(place: &Path, broken: Option<Break>) -> Result<ExitCode, Failure> {
    // What a dead manager's tasks had started goes before anything is started. A
    // child that was frozen as it was born may have the journal's lock.
    let state = place.join("bodies");
    sweep(&state)?;
    let (journal, restored, _) = Journal::open(&journal(place), OPTIONS)?;
    Chronicle::open(place)?.note(&Fact::Life)?;
    let there: Vec<_> = restored.tasks.iter().map(|task| task.task.id).collect();
    let waker = Waker::new()?;
    let mission = schedule::mission();
    let mut installation = Installation::new(&mission, &waker)?;
    installation.device(&schedule::camera(), Box::new(device::driver(place, broken)?))?;
    let tickets = installation.start()?;
    let commander = Arc::new(tickets.commander());
    let ports = CommandServer::start(commander.clone(), waker.clone())?;
    let around =
        Surroundings { ports: Box::new(ports), commands: commander, ..Surroundings::default() };
    let settings =
        Settings { state: Some(state), probe: probe(place.to_owned()), ..Settings::default() };
    let bodies = RealBodies::new(settings, waker.clone(), around)?;
    let operator = Operator::new(place, schedule::tasks(place)?, &there)?;
    let journal = Sink { journal, commits: broken != Some(Break::Uncommitted) };
    let ports = (bodies, Sensed::new(tickets, place, broken)?, journal, operator);
    let clock = HostClock::start();
    let mut executive = HostExecutive::new(mission, restored, waker, clock, ports)?;
    loop {
        while executive.turn()? {}
        if executive.outside().is_content() && only_the_routine_is_left(executive.manager()) {
            break;
        }
        executive.wait()?;
    }
    let (_, _, sink, _) = executive.into_ports();
    sink.journal.close()?;
    census().for_each(|(point, visits)| println!("{point} {visits}"));
    Ok(ExitCode::SUCCESS)
}

/// The journal, or one that forgets to commit.
#[derive(Debug)]
struct Sink {
    journal: Journal,
    commits: bool,
}

impl JournalSink for Sink {
    fn append(&mut self, record: &Record) -> io::Result<()> {
        JournalSink::append(&mut self.journal, record)
    }

    fn commit(&mut self) -> io::Result<()> {
        if self.commits { JournalSink::commit(&mut self.journal) } else { Ok(()) }
    }

    fn sync(&mut self) -> io::Result<()> {
        JournalSink::sync(&mut self.journal)
    }
}

fn only_the_routine_is_left(manager: &Manager) -> bool {
    manager.status().all(|task| match task.state {
        State::Ended(_) => true,
        State::Pending(_) => task.occurrence.task.get() == schedule::ROUTINE,
        _ => false,
    })
}

/// Moments in the lives of processes are places to die at.
fn probe(place: PathBuf) -> Probe {
    Probe::new(move |moment, attempt| match moment {
        Moment::Fork => points::hit(Point::BeforeExec),
        Moment::Forked => {
            points::hit(Point::InsideExec);
            points::torn(Point::AfterExec, || wait_until_it_began(&place, attempt));
        }
        Moment::Reap => points::hit(Point::BeforeReap),
        Moment::Reaped => points::hit(Point::InsideReap),
        Moment::Enter => {}
    })
}

/// Until the process has written down that it began.
fn wait_until_it_began(place: &Path, attempt: Attempt) {
    let began = |fact: &Fact| {
        matches!(fact, Fact::Began(one)
            if one.task == attempt.occurrence.task.get()
                && one.occurrence == attempt.occurrence.number
                && one.attempt == attempt.number)
    };
    let since = Instant::now();
    while since.elapsed() < PATIENCE {
        if read(place).is_ok_and(|facts| facts.iter().any(began)) {
            return;
        }
        std::thread::yield_now();
    }
}
