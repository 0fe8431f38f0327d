//! What should be looked at in a schedule.

use std::collections::HashSet;

use faregate_agents::Categories;

use crate::analyze::collide::{Routine, meeting};
use crate::analyze::phase::phase;
use crate::analyze::report::{Problem, ProblemKind, as_seconds};
use crate::analyze::trace::{Trace, Wait};
use crate::analyze::track::Track;
use crate::analyze::utilisation::Utilisation;
use crate::executive::expected;
use crate::manager::{HeldBy, WaitsFor};
use crate::task::{Body, Task, TaskId};
use crate::time::{Duration, UnixTime};

/// Of each kind, no more than this are listed.
pub(super) const LISTED: usize = 1_000;

/// Everything that can be said from one run.
pub(super) fn problems(trace: &Trace, utilisation: &Utilisation, load: UnixTime) -> Vec<Problem> {
    let mut all = Vec::new();
    for track in &trace.tracks {
        all.extend(of_task(track, trace));
    }
    all.extend(inversions(trace));
    all.extend(waits_for_draw(&trace.waits));
    all.extend(margins(utilisation));
    all.extend(collisions(&trace.tracks, load));
    all.extend(trace.is_full.then(|| {
        let message = format!(
            "too many runs: it was looked at until {} only. A shorter horizon says what is wanted",
            say(trace.horizon)
        );
        Problem::new(ProblemKind::More, message).at(trace.horizon)
    }));
    let stuck = trace.stuck.iter().map(|why| Problem::new(ProblemKind::NeverRuns, why.clone()));
    all.extend(stuck);
    listed(all)
}

/// In order of time; too many of one kind are counted.
fn listed(mut all: Vec<Problem>) -> Vec<Problem> {
    all.sort_by_key(|problem| (problem.at, problem.kind, problem.task, problem.with));
    let mut more: Vec<(ProblemKind, usize)> = Vec::new();
    let mut count = |kind| {
        if !more.iter().any(|(known, _)| *known == kind) {
            more.push((kind, 0));
        }
        let found = more.iter_mut().find(|(known, _)| *known == kind);
        found.map_or(0, |(_, count)| {
            *count = count.saturating_add(1);
            *count
        })
    };
    all.retain(|problem| count(problem.kind) <= LISTED);
    let more = more.into_iter().filter(|(_, count)| *count > LISTED);
    all.extend(more.map(|(kind, count)| {
        let message = format!("{} more problems of the kind \"{kind}\"", count - LISTED);
        Problem::new(ProblemKind::More, message)
    }));
    all
}

fn of_task<'a>(track: &'a Track, trace: &'a Trace) -> impl Iterator<Item = Problem> + 'a {
    let id = track.task.id;
    let says = [
        never(track),
        still_waits(track, trace),
        missed(track),
        track.cut.map(|at| {
            let message = format!("{id} is still at work at its cutoff, and is ended");
            Problem::new(ProblemKind::Cutoff, message).at(at)
        }),
        track.overran.map(|at| {
            let message = format!("{id} runs longer than its {}", say(track.task.duration));
            Problem::new(ProblemKind::Overrun, message).at(at)
        }),
        is_timeless(&track.task).then(|| {
            let message = format!("{id} states no duration: it is taken to be 0");
            Problem::new(ProblemKind::NoDuration, message)
        }),
    ];
    says.into_iter().flatten().map(move |problem| problem.of(id))
}

fn is_timeless(task: &Task) -> bool {
    expected(task).is_zero() && task.spread.is_none() && !matches!(task.body, Body::BuiltIn(_))
}

fn never(track: &Track) -> Option<Problem> {
    let (at, why) = track.never.as_ref()?;
    let message = format!("{} never runs: {why}", track.task.id);
    Some(Problem::new(ProblemKind::NeverRuns, message).at(*at))
}

/// It was due, and has not run at the horizon.
fn still_waits(track: &Track, trace: &Trace) -> Option<Problem> {
    let idle = track.runs.is_empty() && track.misses.is_empty() && track.never.is_none();
    let (since, _) = track.waits.first().filter(|_| idle)?;
    let id = track.task.id;
    let reason = track.longest_reason().unwrap_or("nobody knows for what");
    let (kind, message) = if trace.cut {
        let until = say(trace.horizon);
        (ProblemKind::Waiting, format!("{id} has not run until {until}, the horizon: {reason}"))
    } else {
        (
            ProblemKind::NeverRuns,
            format!("{id} never runs: nothing happens any more, and it {reason}"),
        )
    };
    Some(Problem::new(kind, message).at(*since))
}

fn missed(track: &Track) -> Option<Problem> {
    let first = *track.misses.first()?;
    let why = track.missed_because.as_deref().unwrap_or("its window closed");
    let id = track.task.id;
    let message = match track.missed {
        1 => format!("{id} misses an occurrence: {why}"),
        count => format!("{id} misses {count} occurrences: {why}"),
    };
    Some(Problem::new(ProblemKind::Missed, message).at(first).every(regular(&track.misses)))
}

/// The distance, if there is one.
fn regular(instants: &[Duration]) -> Option<Duration> {
    let pairs = instants.iter().zip(instants.iter().skip(1));
    let mut distances = pairs.map(|(from, to)| to.saturating_sub(*from));
    let first = distances.next()?;
    distances.all(|distance| distance == first).then_some(first)
}

/// Samples were wanted, and all would be equal.
pub(super) fn no_spread(samples: u32) -> Problem {
    let message = format!(
        "no task says how much its duration varies (dur_min, dur_max): all {samples} samples would \
         be the same, and none was taken"
    );
    Problem::new(ProblemKind::NoSpread, message)
}

/// Who waits for somebody less important: for its outcome, or for what it has
/// and nobody can take.
fn inversions(trace: &Trace) -> Vec<Problem> {
    let mut known = HashSet::new();
    let mut found = Vec::new();
    for wait in &trace.waits {
        let (other, what) = match &wait.waits_for {
            WaitsFor::Dependency(other) => (*other, "to end"),
            WaitsFor::Categories { by: HeldBy::Task(other), .. }
            | WaitsFor::Gate { by: HeldBy::Task(other), .. } => {
                (*other, "which cannot be pre-empted")
            }
            _ => continue,
        };
        // To find out takes a look at all waits of the task: once is enough.
        if known.contains(&(wait.task, other)) || !is_inverted(trace, wait, other) {
            continue;
        }
        known.insert((wait.task, other));
        let message = format!("{} waits for {other}, which is less important, {what}", wait.task);
        let problem = Problem::new(ProblemKind::Inversion, message);
        found.push(problem.of(wait.task).with(other).at(wait.at));
    }
    found
}

/// Less important by its priority, and waited for longer than an instant.
fn is_inverted(trace: &Trace, wait: &Wait, other: TaskId) -> bool {
    let (Some(track), Some(other)) = (trace.track(wait.task), trace.track(other)) else {
        return false;
    };
    let lasted = || track.waits.iter().any(|(from, until)| *from <= wait.at && wait.at < *until);
    other.task.priority.level() < track.task.priority.level() && lasted()
}

/// The first wait of each task.
fn waits_for_draw(waits: &[Wait]) -> Vec<Problem> {
    let mut known = HashSet::new();
    let mut found = Vec::new();
    for wait in waits {
        let WaitsFor::Draw { short_by } = wait.waits_for else { continue };
        if !known.insert(wait.task) {
            continue;
        }
        let message = format!("{} waits for draw: {short_by} are missing", wait.task);
        found.push(Problem::new(ProblemKind::Margin, message).of(wait.task).at(wait.at));
    }
    found
}

fn margins(utilisation: &Utilisation) -> impl Iterator<Item = Problem> {
    utilisation.agents.iter().filter_map(|agent| {
        let (wished, at) = agent.wished;
        let message = format!(
            "wishes for draw from {} exceed its supply of {}: up to {wished}, at {}",
            agent.name,
            agent.supply?,
            say(at)
        );
        Some(Problem::new(ProblemKind::Margin, message).at(agent.exceeded?))
    })
}

fn collisions(tracks: &[Track], load: UnixTime) -> Vec<Problem> {
    let routine = tracks.iter().filter_map(|track| {
        let length = expected(&track.task).saturating_add(track.task.gap).as_micros();
        Some((&track.task, Routine { phase: phase(&track.task, load)?, length }))
    });
    let routine: Vec<_> = routine.collect();
    let mut found = Vec::new();
    for (index, (one, first)) in routine.iter().enumerate() {
        for (other, second) in routine.iter().skip(index.saturating_add(1)) {
            if found.len() > LISTED {
                return found;
            }
            found.extend(collision((one, *first), (other, *second)));
        }
    }
    found
}

fn collision((one, first): (&Task, Routine), (other, second): (&Task, Routine)) -> Option<Problem> {
    let what = wanted_by_both(one, other)?;
    let meeting = meeting(first, second)?;
    let at = Duration::from_micros(meeting.first);
    let every = meeting.every.map(Duration::from_micros);
    let often = every.map_or("and again and again".into(), |every| {
        format!("a pattern that repeats every {}", say(every))
    });
    let message = format!(
        "{} and {} both want {what}, first at {}, in {often}: {}",
        one.id,
        other.id,
        say(at),
        who_waits(one, other)
    );
    let problem = Problem::new(ProblemKind::Collision, message);
    Some(problem.of(one.id).with(other.id).at(at).every(every))
}

fn wanted_by_both(one: &Task, other: &Task) -> Option<String> {
    let shared = one.categories.shared(other.categories);
    if shared != Categories::NONE {
        return Some(format!("categories {shared}"));
    }
    one.gates.iter().find(|gate| other.gates.contains(gate)).cloned()
}

fn who_waits(one: &Task, other: &Task) -> String {
    match one.priority.level().cmp(&other.priority.level()) {
        core::cmp::Ordering::Less => format!("{} gives way", one.id),
        core::cmp::Ordering::Greater => format!("{} gives way", other.id),
        core::cmp::Ordering::Equal => "whoever is due later waits".into(),
    }
}

/// Seconds, in as few digits as they need.
pub(super) fn say(duration: Duration) -> String {
    format!("{} s", as_seconds(duration))
}
