//! What must hold after a history, whatever was killed in it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use faregate_scheduler::journal::Journal;
use faregate_scheduler::manager::RestoredTask;
use faregate_scheduler::task::{Outcome, Restart};

use crate::schedule::{self, ROUTINE};
use crate::truth::{Fact, Try, read};
use crate::{Failure, device, manager};

/// Looks at everything that is left of a history.
pub(crate) fn check(place: &Path) -> Result<(), Failure> {
    let facts = read(place)?;
    let (_, restored, opened) = Journal::open(&manager::journal(place), manager::OPTIONS)?;
    if !opened.clean {
        return Err("the last manager did not close its journal".into());
    }
    nothing_began_twice(&facts)?;
    nobody_outlives_a_manager(&facts)?;
    nobody_is_lost(&facts, &restored.tasks, place)?;
    the_device_is_off(&facts, place)?;
    nobody_is_left(place)
}

fn nothing_began_twice(facts: &[Fact]) -> Result<(), Failure> {
    let mut attempts = BTreeSet::new();
    for one in tries(facts) {
        if !attempts.insert((one.task, one.occurrence, one.attempt)) {
            return Err(format!("an attempt began twice: {one:?}").into());
        }
    }
    Ok(())
}

/// Whoever began under a manager that died does nothing under the next one.
fn nobody_outlives_a_manager(facts: &[Fact]) -> Result<(), Failure> {
    let mut present = BTreeSet::new();
    for fact in facts {
        match fact {
            Fact::Life => present.clear(),
            Fact::Began(one) => drop(present.insert(one)),
            Fact::Ended(one, _) if !present.contains(one) => {
                return Err(format!("{one:?} has outlived its manager").into());
            }
            _ => {}
        }
    }
    Ok(())
}

fn nobody_is_lost(facts: &[Fact], known: &[RestoredTask], place: &Path) -> Result<(), Failure> {
    let known: BTreeMap<_, _> = known.iter().map(|task| (task.task.id.get(), task)).collect();
    for task in schedule::tasks(place)? {
        let id = task.id.get();
        if !facts.contains(&Fact::Accepted(id)) && !known.contains_key(&id) {
            return Err(format!("{} was never accepted", task.id).into());
        }
        let task = known.get(&id).ok_or_else(|| format!("{} is lost", task.id))?;
        match (id, task.task.restart) {
            (ROUTINE, _) => routine(facts, task)?,
            (_, Restart::Never) => at_most_once(facts, task)?,
            (_, Restart::OnFailure { .. }) => at_least_once(facts, task)?,
        }
    }
    Ok(())
}

fn at_most_once(facts: &[Fact], task: &RestoredTask) -> Result<(), Failure> {
    let id = task.task.id;
    let began = tries(facts).filter(|one| one.task == id.get()).count();
    let done = succeeded(facts, id.get());
    match task.ended {
        _ if began > 1 => Err(format!("{id} began twice, or more often: {began} times").into()),
        None => Err(format!("{id} is lost: nobody says what became of it").into()),
        Some((_, Outcome::Succeeded)) if !done => Err(format!("{id} did not succeed").into()),
        Some((_, Outcome::Succeeded | Outcome::Failed)) => Ok(()),
        Some((_, outcome)) => Err(format!("{id} is said to be {outcome:?}").into()),
    }
}

fn at_least_once(facts: &[Fact], task: &RestoredTask) -> Result<(), Failure> {
    let id = task.task.id;
    match task.ended {
        Some((_, Outcome::Succeeded)) if succeeded(facts, id.get()) => Ok(()),
        ended => Err(format!("{id} was given up: {ended:?}").into()),
    }
}

/// Each occurrence at most once, in order, and one of them in the last life.
fn routine(facts: &[Fact], task: &RestoredTask) -> Result<(), Failure> {
    let id = task.task.id;
    let numbers: Vec<_> =
        tries(facts).filter(|one| one.task == id.get()).map(|one| one.occurrence).collect();
    if !numbers.is_sorted_by(|a, b| a < b) {
        return Err(format!("an occurrence of {id} ran twice, or late: {numbers:?}").into());
    }
    let last_life = facts.iter().rposition(|fact| *fact == Fact::Life).unwrap_or(0);
    let goes_on = tries(&facts[last_life..]).any(|one| one.task == id.get());
    if goes_on { Ok(()) } else { Err(format!("{id} did not go on").into()) }
}

/// It is off in the end; and no life turns it on before it has been turned off
/// what an earlier one left on.
fn the_device_is_off(facts: &[Fact], place: &Path) -> Result<(), Failure> {
    if device::is_on(place) {
        return Err("the camera is on, and nobody uses it".into());
    }
    let mut left_on = false;
    let mut on = false;
    for fact in facts {
        match fact {
            Fact::Life => left_on = on,
            Fact::Device(true) if left_on => {
                return Err("the camera of a dead task was not turned off first".into());
            }
            Fact::Device(now) => {
                on = *now;
                left_on &= on;
            }
            _ => {}
        }
    }
    Ok(())
}

/// No process of the history lives: each has its place among its arguments.
fn nobody_is_left(place: &Path) -> Result<(), Failure> {
    let place = place.as_os_str().as_encoded_bytes();
    for entry in std::fs::read_dir("/proc")? {
        let path = entry?.path();
        // Whoever is gone meanwhile is gone.
        let arguments = std::fs::read(path.join("cmdline")).unwrap_or_default();
        if arguments.split(|byte| *byte == 0).any(|argument| argument == place) {
            return Err(format!("{} is left", path.display()).into());
        }
    }
    Ok(())
}

fn tries(facts: &[Fact]) -> impl Iterator<Item = Try> {
    facts.iter().filter_map(|fact| if let Fact::Began(one) = fact { Some(*one) } else { None })
}

fn succeeded(facts: &[Fact], task: u32) -> bool {
    facts.iter().any(|fact| matches!(fact, Fact::Ended(one, 0) if one.task == task))
}
