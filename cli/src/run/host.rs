//! A run in real time: processes, tickets of a broker, simulated devices.

use std::fs;
use std::io;
use std::sync::Arc;

use faregate_client::Refused;
use faregate_scheduler::bodies::{Settings, Swept};
use faregate_scheduler::control::Links;
use faregate_scheduler::executive::Waker;
use faregate_scheduler::manager::Note;
use faregate_scheduler::onboard::{self, Kept, NotOnboard, Onboard};
use faregate_scheduler::task::{Outcome, Task};
use faregate_scheduler::tickets::Tickets;
use faregate_tickets::amount::Milliwatts;

use super::descriptors;
use super::outside::Ground;
use super::teller::{Teller, harmless};
use crate::args::RunArgs;
use crate::exit::{Exit, Failure};
use crate::schedule::{Loader, Schedule};
use crate::simulation::{self, Craft, Loads};

/// Runs the schedule until it is over, its time has passed, or somebody stops
/// it.
pub(crate) fn run(args: &RunArgs, schedule: Schedule, teller: Teller) -> Result<Teller, Failure> {
    let Schedule { tasks, mission, loader, .. } = schedule;
    let craft = Craft::new(&mission, args.seed)?;
    let open_files = descriptors::raise();
    let mut builder = Onboard::builder(simulation::gated(&mission))?
        .bodies(Settings { open_files, ..Settings::default() });
    for (name, driver) in craft.drivers(&mission) {
        builder = builder.device(&name, driver)?;
    }
    builder = builder.reading(Arc::new(move |name: &str, text: &str| read(&loader, name, text)));
    if let Some(directory) = &args.journal {
        fs::create_dir_all(directory).map_err(|error| {
            let path = directory.display();
            Failure::failed(format!("the journal cannot be kept in {path}: {error}"))
        })?;
        builder = builder.journal(directory)?;
    }
    if let Some(path) = &args.socket {
        builder = builder.control(path);
    }
    let goes_on = builder.goes_on();
    let ground = |links: Links, tickets: &Tickets, waker: &Waker| {
        let mut craft = craft;
        craft.sense(tickets, waker.clone())?;
        Ok(Ground::new((links, teller, craft), args.time)?)
    };
    let mut executive = builder.start_with(ground)?;
    for left in executive.bodies().swept().to_vec() {
        executive.outside().teller.say(&ended(&left));
    }
    if goes_on {
        go_on(&mut executive);
    } else {
        executive.load(tasks)?;
    }
    drive(&mut executive, args.socket.is_some())?;
    end(executive)
}

/// Of the tasks of the journal nobody tells that they were accepted.
fn go_on(executive: &mut Onboard<Ground>) {
    let tasks: Vec<Task> = executive.manager().tasks().cloned().collect();
    let teller = &mut executive.outside().teller;
    teller.say("Going on where the journal ends.");
    tasks.iter().for_each(|task| teller.tally.learn(task));
}

/// A process that outlived an earlier run of the manager.
fn ended(Swept { pid, task, command }: &Swept) -> String {
    let whose = task.map(|task| format!(" of task {task}")).unwrap_or_default();
    let command = harmless(command);
    format!("Ended process {pid}{whose}, which an earlier run had left: {command}")
}

/// Takes turns until all is over. Who listens is told when that is.
fn drive(executive: &mut Onboard<Ground>, listens: bool) -> Result<(), Failure> {
    let mut loads = Loads::default();
    loop {
        // The first turn may have been taken by the load.
        look(executive, &mut loads);
        // Asked after each turn: something may be due all the time.
        let stopping = executive.outside().stopping;
        if executive.manager().is_over() && (stopping || !listens) {
            return Ok(());
        }
        if !executive.turn().map_err(cannot_go_on)? {
            executive.wait().map_err(cannot_go_on)?;
        }
    }
}

/// What follows from the last changes, beside that they were told.
fn look(executive: &mut Onboard<Ground>, loads: &mut Loads) {
    for note in std::mem::take(&mut executive.outside().changes) {
        count(executive, &note);
        let draw = loads.follow(&note, |attempt| {
            let task = executive.manager().task(attempt.occurrence.task);
            task.map_or(Milliwatts::ZERO, |task| task.peak_draw)
        });
        if let Some(draw) = draw {
            executive.outside().craft.set_tasks_draw(draw);
        }
        if let Note::Over { attempt, outcome: Outcome::Failed, .. } = note
            && let Some(output) = executive.bodies().output(attempt)
        {
            let text = String::from_utf8_lossy(&output.stderr.tail).into_owned();
            text.lines().for_each(|line| executive.outside().teller.quote(line));
        }
    }
}

/// Tasks come into the schedule from operators and from files, too.
fn count(executive: &mut Onboard<Ground>, note: &Note) {
    let accepted = match note {
        Note::Accepted(id) => executive.manager().task(*id).cloned(),
        _ => None,
    };
    let tally = &mut executive.outside().teller.tally;
    accepted.iter().for_each(|task| tally.learn(task));
    tally.count(note);
}

/// Closes the journal in order, and says what the spacecraft has to say: that
/// may wait for whoever reads it.
fn end(executive: Onboard<Ground>) -> Result<Teller, Failure> {
    let (_bodies, _tickets, kept, ground) = executive.into_ports();
    let Ground { mut teller, craft, .. } = ground;
    if let Kept::Journal(journal) = kept {
        journal.close().map_err(|error| Failure::failed(error.to_string()))?;
    }
    teller.wait_again();
    craft.report().iter().for_each(|line| teller.say(line));
    craft.lost().map_or(Ok(teller), |why| Err(Failure::failed(why)))
}

fn cannot_go_on(error: io::Error) -> Failure {
    Failure::failed(format!("the run cannot go on: {error}"))
}

/// A schedule as an operator sends it.
fn read(loader: &Loader, name: &str, text: &str) -> Result<Vec<Task>, Refused> {
    loader.read(name, text.as_bytes()).map_err(|found| onboard::refused(&found))
}

impl From<NotOnboard> for Failure {
    fn from(why: NotOnboard) -> Self {
        let exit = match &why {
            NotOnboard::Refused(_) => Exit::Never,
            _ => Exit::Failed,
        };
        Self::Because(exit, why.to_string())
    }
}
