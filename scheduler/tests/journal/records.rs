//! Records to write, sensible and not.

use faregate_scheduler::manager::{Attempt, Occurrence, Record};
use faregate_scheduler::task::{Body, Dependency, Outcome, Status, Task, TaskId};
use faregate_scheduler::time::{Duration, Instant, UnixTime};

pub(crate) fn id(number: u32) -> TaskId {
    TaskId::new(number).expect("not 0")
}

pub(crate) fn task(number: u32) -> Task {
    let mut task = Task::new(id(number), Body::Hold);
    task.name = Some(format!("task {number}"));
    task
}

pub(crate) fn routine(number: u32) -> Task {
    Task { interval: Some(Duration::from_secs(60)), ..task(number) }
}

pub(crate) fn accepted(task: Task) -> Record {
    let position = u64::from(task.id.get());
    accepted_as(task, 0, position)
}

pub(crate) fn accepted_as(task: Task, load: u32, position: u64) -> Record {
    let (at, wall) = (Instant::START, UnixTime::from_secs(1_000_000));
    Record::Accepted { task: Box::new(task), load, position, at, wall }
}

pub(crate) fn occurrence(task: u32, number: u64) -> Occurrence {
    Occurrence { task: id(task), load: 0, number }
}

pub(crate) fn attempt(task: u32, number: u32) -> Attempt {
    Attempt { occurrence: occurrence(task, 0), number }
}

pub(crate) fn starting(task: u32) -> Record {
    Record::Starting { attempt: attempt(task, 1) }
}

pub(crate) fn armed(task: u32) -> Record {
    Record::Armed { occurrence: occurrence(task, 0) }
}

pub(crate) fn over(task: u32) -> Record {
    Record::Over { attempt: attempt(task, 1), outcome: Some(Outcome::Succeeded) }
}

pub(crate) fn ended(task: u32, outcome: Outcome) -> Record {
    let wall = UnixTime::from_secs(2_000_000);
    Record::Ended { occurrence: occurrence(task, 0), outcome, wall }
}

/// Any record about a few tasks, whatever was there before.
pub(crate) fn any(random: &mut fastrand::Rng) -> Record {
    let number = random.u32(1..6);
    let occurrence = Occurrence {
        task: id(number),
        load: u32::from(random.u8(..) < 30),
        number: random.u64(0..3),
    };
    let attempt = Attempt { occurrence, number: random.u32(1..4) };
    match random.u8(0..17) {
        0 | 1 => accepted_as(any_task(number, random), occurrence.load, random.u64(0..40)),
        2 => Record::Changed { task: Box::new(any_task(number, random)), held: random.bool() },
        3 => Record::Removed { task: id(number), load: occurrence.load },
        4..=6 => Record::Armed { occurrence },
        7 => Record::Disarmed { occurrence },
        8 | 9 => Record::Starting { attempt },
        10 => Record::Over { attempt, outcome: None },
        12 => Record::Over { attempt, outcome: Some(Outcome::Aborted) },
        13 => Record::Paused { attempt, paused: random.bool() },
        11 => ended_any(occurrence, random),
        14 => Record::Leaving { task: id(number), load: occurrence.load },
        15 => Record::CleansUp { task: id(number), load: occurrence.load },
        _ => Record::Mode { name: format!("mode {}", random.u8(0..3)), entered: random.bool() },
    }
}

fn ended_any(occurrence: Occurrence, random: &mut fastrand::Rng) -> Record {
    let outcomes = [Outcome::Succeeded, Outcome::Failed, Outcome::Aborted, Outcome::Missed];
    let outcome = outcomes[random.usize(..outcomes.len())];
    Record::Ended { occurrence, outcome, wall: UnixTime::from_secs(2_000_000) }
}

fn any_task(number: u32, random: &mut fastrand::Rng) -> Task {
    let mut task = if random.bool() { routine(number) } else { task(number) };
    task.name = Some("x".repeat(random.usize(0..200)));
    if random.u8(0..4) == 0 {
        task.after = vec![Dependency { task: id(random.u32(1..6)), status: Status::Finished }];
    }
    if random.u8(0..4) == 0 {
        task.cleanup = Some(id(random.u32(1..6)));
    }
    task
}
