//! Random schedules on which two executives can be compared. What happens at one
//! instant can come in another order on another clock, so [`is_clear`] keeps
//! those in which nothing ends when something else ends or is due.

use faregate_agents::Categories;
use faregate_scheduler::executive::{VirtualBodies, VirtualExecutive};
use faregate_scheduler::manager::{Addition, Event, Note, Telecommand, TelecommandId};
use faregate_scheduler::mission::Mission;
use faregate_scheduler::task::{
    Body, Dependency, Preemption, Status, Task, TaskPriority, When, Window,
};
use faregate_scheduler::time::{Duration, Instant, UnixTime};
use proptest::prelude::*;

use super::{Told, id};

/// Durations and intervals are multiples of this.
pub(crate) const UNIT: Duration = Duration::from_millis(50);

/// Each task is due so far off the units, times its number: a run that began
/// when its task was due does not end when another task is due.
const OFF: Duration = Duration::from_millis(6);

/// Tasks of one schedule, at most: so many have places of their own in a unit.
pub(crate) const MOST: usize = 8;

/// What is drawn for one task, in units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drawn {
    due: u64,
    takes: u64,
    window: Option<u64>,
    interval: Option<u64>,
    mask: u8,
    priority: u8,
    preemption: u8,
    after: Option<usize>,
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let times = (0_u64..24, 3_u64..16, proptest::option::weighted(0.3, 0_u64..20));
    let interval = proptest::option::weighted(0.25, 18_u64..30);
    let claims = (0_u8..8, 0_u8..6, 0_u8..4);
    let after = proptest::option::weighted(0.15, 0_usize..MOST);
    (times, interval, claims, after).prop_map(
        |((due, takes, window), interval, (mask, priority, preemption), after)| Drawn {
            due,
            takes,
            window,
            interval,
            mask,
            priority,
            preemption,
            after,
        },
    )
}

/// A schedule of up to so many tasks, which is over a few seconds after its
/// load if its routine tasks are let run no longer.
pub(crate) fn schedule(most: usize) -> impl Strategy<Value = Vec<Task>> {
    proptest::collection::vec(drawn(), 1..=most.min(MOST)).prop_map(|all| tasks(&all))
}

pub(crate) fn tasks(all: &[Drawn]) -> Vec<Task> {
    let tasks = all.iter().enumerate();
    tasks.map(|(place, drawn)| task(place, drawn, all)).collect()
}

fn number(place: usize) -> u32 {
    u32::try_from(place).unwrap() + 1
}

fn task(place: usize, drawn: &Drawn, all: &[Drawn]) -> Task {
    let takes = UNIT.saturating_mul(drawn.takes);
    let seconds =
        format!("{}.{:02}", takes.as_micros() / 1_000_000, takes.as_micros() / 10_000 % 100);
    let body = Body::Process { program: "sleep".into(), arguments: vec![seconds] };
    let mut task = Task::new(id(number(place)), body);
    let off = OFF.saturating_mul(u64::from(number(place)));
    let due = UNIT.saturating_mul(drawn.due).saturating_add(off);
    let closes = drawn.window.map(|window| {
        When::AfterLoad(due.saturating_add(UNIT.saturating_mul(window)).saturating_add(OFF))
    });
    let closes = closes.unwrap_or(When::Unrestricted);
    task.windows = vec![Window { opens: When::AfterLoad(due), closes }];
    task.duration = takes;
    task.categories = Categories::from_mask(drawn.mask.into());
    task.priority = TaskPriority::new(drawn.priority).unwrap();
    task.interval = drawn.interval.map(|interval| UNIT.saturating_mul(interval));
    // No checkpoint: what it saves differs between a clock and a process.
    task.preemption = match drawn.preemption {
        0 => Preemption::Wait,
        1 => Preemption::Kill { grace: Duration::from_secs(1) },
        _ => Preemption::Pause,
    };
    // Only on earlier tasks: no cycles.
    let prior = drawn.after.filter(|prior| *prior < place.min(all.len()));
    task.after = prior
        .map(|prior| Dependency { task: id(number(prior)), status: Status::Finished })
        .into_iter()
        .collect();
    task
}

/// What the manager tells of these tasks until then.
pub(crate) fn told(tasks: &[Task], mission: &Mission, until: Instant) -> Vec<(Instant, Note)> {
    let bodies = VirtualBodies::as_expected();
    let mut executive =
        VirtualExecutive::new(mission.clone(), UnixTime::from_secs(0), bodies, Told::default());
    let additions = tasks.iter().map(|task| Addition { task: task.clone() }).collect();
    let telecommand = Telecommand::Add(additions);
    executive.tell(Event::Telecommand { id: TelecommandId(0), telecommand });
    executive.advance_to(until).unwrap();
    executive.into_outside().notes
}

/// Whether ends are so far from each other, and from everything that is due by
/// the clock, that no host can mix up their order.
pub(crate) fn is_clear(tasks: &[Task], mission: &Mission, until: Instant, apart: Duration) -> bool {
    let told = told(tasks, mission, until);
    let ends = told.iter().filter(|(_, note)| matches!(note, Note::Over { .. }));
    let mut ends: Vec<_> = ends.map(|(at, _)| *at).collect();
    let mut dues: Vec<_> = tasks.iter().flat_map(|task| by_the_clock(task, until)).collect();
    dues.sort_unstable();
    dues.dedup();
    ends.append(&mut dues);
    ends.sort_unstable();
    ends.windows(2).all(|pair| pair[1].since(pair[0]) >= apart)
}

fn by_the_clock(task: &Task, until: Instant) -> Vec<Instant> {
    let window = task.windows[0];
    let points = [window.opens, window.closes].into_iter().filter_map(|when| match when {
        When::AfterLoad(after) => Some(Instant::START.after(after)),
        When::Unrestricted | When::At(_) => None,
    });
    let occurrences = if task.interval.is_some() { 10_000 } else { 1 };
    let interval = task.interval.unwrap_or(Duration::ZERO);
    let all = points.flat_map(|point| {
        (0..occurrences)
            .map(move |k| point.after(interval.saturating_mul(k)))
            .take_while(|at| *at <= until)
    });
    all.collect()
}
