//! A run in real time: processes, tickets of a broker, simulated devices.

use std::fs;
use std::io;
use std::path::Path;
use std::sync::Arc;

use faregate_client::Refused;
use faregate_scheduler::Manager;
use faregate_scheduler::bodies::{Settings, Swept};
use faregate_scheduler::control::Links;
use faregate_scheduler::executive::Waker;
use faregate_scheduler::manager::{Note, Reply, Telecommand};
use faregate_scheduler::onboard::{self, Kept, NotOnboard, Onboard};
use faregate_scheduler::task::{Outcome, Task};
use faregate_scheduler::tickets::Tickets;
use faregate_scheduler::time::Instant;
use faregate_tickets::amount::Milliwatts;

use super::descriptors;
use super::outside::Ground;
use super::planned::{Planned, Prepared};
use super::teller::{Teller, harmless};
use crate::args::RunArgs;
use crate::exit::{Exit, Failure};
use crate::schedule::{Loader, Schedule};
use crate::simulation::{self, Craft, Loads};

/// Runs the schedule until it is over, its time has passed, or somebody stops
/// it.
pub(crate) fn run(
    args: &RunArgs,
    schedule: Schedule,
    plan: Option<Prepared>,
    teller: Teller,
) -> Result<Teller, Failure> {
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
        fs::create_dir_all(directory).map_err(|error| no_journal(directory, &error))?;
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
    } else if plan.is_none() {
        executive.load(tasks)?;
    }
    let now = executive.now().wall;
    let mut planned = plan.map(|plan| plan.begin(now));
    drive(&mut executive, planned.as_mut(), args.socket.is_some())?;
    end(executive, planned)
}

fn no_journal(directory: &Path, error: &io::Error) -> Failure {
    let path = directory.display();
    Failure::failed(match directory.is_dir() || !directory.exists() {
        true => format!("the journal cannot be kept in {path}: {error}"),
        false => format!("the journal cannot be kept in {path}: it is no directory"),
    })
}

/// Of the tasks of the journal nobody tells that they were accepted.
fn go_on(executive: &mut Onboard<Ground>) {
    let tasks: Vec<Task> = executive.manager().tasks().cloned().collect();
    let teller = &mut executive.outside().teller;
    teller.say("Going on where the journal ends: its tasks count, and not those of the files.");
    tasks.iter().for_each(|task| teller.tally.learn(task));
}

/// A process that outlived an earlier run of the manager.
fn ended(Swept { pid, task, command }: &Swept) -> String {
    let whose = task.map(|task| format!(" of task {task}")).unwrap_or_default();
    let command = harmless(command);
    format!("Ended process {pid}{whose}, which an earlier run had left: {command}")
}

/// Takes turns until all is over. Who listens is told when that is.
fn drive(
    executive: &mut Onboard<Ground>,
    mut planned: Option<&mut Planned>,
    listens: bool,
) -> Result<(), Failure> {
    let mut loads = Loads::default();
    loop {
        // The first turn may have been taken by the load.
        look(executive, &mut loads, planned.as_deref_mut());
        if let Some(planned) = planned.as_deref_mut()
            && direct(executive, planned)?
        {
            continue;
        }
        // Asked after each turn: something may be due all the time.
        let stopping = executive.outside().stopping;
        if executive.manager().is_over() && (stopping || !listens) {
            return Ok(());
        }
        let due = planned.as_deref().and_then(|planned| planned.due(executive.now()));
        let mut turns = 0;
        // A turn, and where there was nothing to do a wait and another one.
        let went_on = |_: &Manager, _| std::mem::replace(&mut turns, 1) == 1;
        executive.run_until(due.unwrap_or(Instant::FAR_FUTURE), went_on).map_err(cannot_go_on)?;
    }
}

/// Gives the planner's orders to the manager; whether there were any. Who is
/// told to stop takes none.
fn direct(executive: &mut Onboard<Ground>, planned: &mut Planned) -> Result<bool, Failure> {
    if executive.outside().stopping {
        return Ok(false);
    }
    let now = executive.now();
    let Ground { craft, teller, .. } = executive.outside();
    let orders = planned.orders(now, craft.state_of_charge(), teller);
    let orders = orders.map_err(|why| Failure::failed(why.to_string()))?;
    let is_removal = |order: &Telecommand| matches!(order, Telecommand::Remove(_));
    let removals: Vec<_> = orders.iter().map(is_removal).collect();
    let replies = executive.commands(orders).map_err(cannot_go_on)?;
    for (reply, may_be_refused) in replies.into_iter().zip(&removals) {
        // What is over by now need not be removed.
        if let Reply::Refused(why) = reply
            && !may_be_refused
        {
            executive
                .outside()
                .teller
                .planner(now, &format!("the manager refused an order: {why}"));
        }
    }
    Ok(!removals.is_empty())
}

/// What follows from the last changes, beside that they were told.
fn look(executive: &mut Onboard<Ground>, loads: &mut Loads, mut planned: Option<&mut Planned>) {
    for (at, note) in std::mem::take(&mut executive.outside().changes) {
        planned.iter_mut().for_each(|planned| planned.hear(at, &note));
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
fn end(executive: Onboard<Ground>, planned: Option<Planned>) -> Result<Teller, Failure> {
    let (_bodies, _tickets, kept, ground) = executive.into_ports();
    let Ground { mut teller, craft, .. } = ground;
    if let Some(planned) = planned {
        teller.executed(planned.result(), planned.wanting());
    }
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
