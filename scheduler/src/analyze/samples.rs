//! What varies, when durations do.

use rand_distr::Distribution;
use rand_distr::Triangular;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use serde::Serialize;

use crate::analyze::report::{as_seconds, seconds};
use crate::analyze::trace::{Trace, trace};
use crate::analyze::{Failed, Options, Surroundings};
use crate::executive::{Conduct, expected};
use crate::manager::Attempt;
use crate::mission::Mission;
use crate::task::{Task, TaskId};
use crate::time::Duration;

/// What was seen in so many runs, in each of which every attempt took a time of
/// its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Samples {
    /// How many runs.
    pub count: u32,
    /// What they were drawn by.
    pub seed: u64,
    /// The end of the last run of a task that is not routine.
    #[serde(rename = "makespan_s")]
    pub makespan: Option<Quantiles>,
    /// The tasks, in the order of the schedule.
    pub tasks: Vec<TaskSamples>,
}

/// What varies for one task.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskSamples {
    /// Its number.
    pub id: TaskId,
    /// When it first started, in the runs where it did.
    #[serde(rename = "start_s")]
    pub start: Option<Quantiles>,
    /// When it last ended, in the runs where it did.
    #[serde(rename = "end_s")]
    pub end: Option<Quantiles>,
    /// How long it was due and did not run.
    #[serde(rename = "waited_s")]
    pub waited: Option<Quantiles>,
    /// In which part of the runs it missed an occurrence, or never ran.
    pub miss_probability: f64,
}

/// What so many percent of the runs stay below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Quantiles {
    /// 5 %.
    #[serde(serialize_with = "seconds")]
    pub p05: Duration,
    /// Half of them.
    #[serde(serialize_with = "seconds")]
    pub p50: Duration,
    /// 95 %.
    #[serde(serialize_with = "seconds")]
    pub p95: Duration,
    /// All of them.
    #[serde(serialize_with = "seconds")]
    pub max: Duration,
}

impl Quantiles {
    /// By nearest rank: every value is one that was seen.
    fn of(mut seen: Vec<Duration>) -> Option<Self> {
        seen.sort_unstable();
        let rank = |percent: usize| {
            let rank = (seen.len() * percent).div_ceil(100).max(1);
            seen.get(rank - 1).copied()
        };
        Some(Self { p05: rank(5)?, p50: rank(50)?, p95: rank(95)?, max: rank(100)? })
    }
}

/// Runs the schedule so many times.
pub(super) fn samples(
    tasks: &[Task],
    mission: &Mission,
    options: &Options,
    surroundings: &mut dyn Surroundings,
) -> Result<Samples, Failed> {
    let mut makespans = Vec::new();
    let mut seen: Vec<Seen> = Vec::new();
    for sample in 0..options.samples {
        let seed = options.seed.wrapping_mul(SPREAD).wrapping_add(sample.into());
        let script =
            move |attempt, task: &Task| Conduct::succeeds_after(drawn(seed, attempt, task));
        let trace = trace(tasks, mission, options, script, surroundings)?;
        makespans.extend(trace.makespan());
        look(&trace, &mut seen);
        surroundings.sampled(sample.saturating_add(1), options.samples);
    }
    let tasks = seen.into_iter().map(|seen| seen.judged(options.samples)).collect();
    let makespan = Quantiles::of(makespans);
    Ok(Samples { count: options.samples, seed: options.seed, makespan, tasks })
}

#[derive(Debug)]
struct Seen {
    id: TaskId,
    starts: Vec<Duration>,
    ends: Vec<Duration>,
    waited: Vec<Duration>,
    missed: u32,
}

impl Seen {
    fn nothing_of(id: TaskId) -> Self {
        Self { id, starts: Vec::new(), ends: Vec::new(), waited: Vec::new(), missed: 0 }
    }

    fn judged(self, samples: u32) -> TaskSamples {
        TaskSamples {
            id: self.id,
            start: Quantiles::of(self.starts),
            end: Quantiles::of(self.ends),
            waited: Quantiles::of(self.waited),
            miss_probability: f64::from(self.missed) / f64::from(samples.max(1)),
        }
    }
}

/// Tracks come in the order in which tasks were accepted: with a file that is
/// loaded in some runs only, a place can be another task's.
fn look(trace: &Trace, seen: &mut Vec<Seen>) {
    for (index, track) in trace.tracks.iter().enumerate() {
        let id = track.task.id;
        let index = match seen.get(index).filter(|seen| seen.id == id) {
            Some(_) => index,
            None => seen.iter().position(|seen| seen.id == id).unwrap_or_else(|| {
                seen.push(Seen::nothing_of(id));
                seen.len() - 1
            }),
        };
        let Some(seen) = seen.get_mut(index) else { continue };
        seen.starts.extend(track.runs.first().map(|run| run.start));
        seen.ends.extend(track.runs.iter().rev().find_map(|run| run.end));
        seen.waited.push(track.waited());
        let missed = !track.misses.is_empty() || track.never.is_some();
        seen.missed = seen.missed.saturating_add(missed.into());
    }
}

/// An odd constant with well mixed bits (2^64 divided by the golden ratio):
/// neighbouring seeds and tasks get sequences that have nothing in common.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

/// How long an attempt takes: the same for the same seed, whatever else runs.
fn drawn(seed: u64, attempt: Attempt, task: &Task) -> Duration {
    let Some(spread) = task.spread else { return expected(task) };
    let mut mixed = seed;
    for part in [
        u64::from(attempt.occurrence.task.get()),
        attempt.occurrence.load.into(),
        attempt.occurrence.number,
        attempt.number.into(),
    ] {
        mixed = (mixed ^ part).wrapping_mul(SPREAD).rotate_left(29);
    }
    let shortest = as_seconds(spread.shortest.min(expected(task)));
    let longest = as_seconds(spread.longest.max(expected(task)));
    let Ok(triangle) = Triangular::new(shortest, longest, as_seconds(expected(task))) else {
        return expected(task);
    };
    let seconds = triangle.sample(&mut Pcg64Mcg::seed_from_u64(mixed));
    core::time::Duration::try_from_secs_f64(seconds).map_or(expected(task), Duration::from)
}
