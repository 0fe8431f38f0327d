//! Row 15: analysis of a week of 7 800 activities.

use std::time::Instant;

use faregate_scheduler::analyze::{Options, analyze};

use crate::fixture::{PLANNED, mission, tasks};
use crate::support::{Bench, Failure, Quantiles, Target};

/// A week is analysed so often.
const WEEKS: u32 = 15;

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let (week, mission) = (tasks(), mission());
    let mut took = Vec::new();
    let mut decisions = 0;
    for _ in 0..WEEKS.min(bench.rounds()) {
        let start = Instant::now();
        let analysis = analyze(&week, &mission, &Options::default())?;
        took.push(start.elapsed().as_secs_f64() * 1e9);
        decisions = analysis.tasks.iter().map(|task| task.runs.len()).sum();
    }
    if decisions < PLANNED / 2 {
        return Err(format!("only {decisions} runs of {PLANNED} activities").into());
    }
    let took = Quantiles::of(took);
    let name = "analysis of a 7 800-activity week, median";
    bench.figure(15, name, took.median / 1e6, "ms", Target::AtMost(500.0));
    bench.figure(15, "the same, worst", took.p999 / 1e6, "ms", Target::None);
    Ok(())
}
