//! Row 21: what plans are worth, beside the best that an exact solver found.
//!
//! The optima are in `planner/tools/optima.csv`, which `ci/optimum.sh` writes.
//! They are of the worlds that are drawn here, or the bench fails.

use std::time::{Duration, Instant};

use faregate_planner::generate::Shape;
use faregate_planner::{Budget, Worth, improve, schedule};
use indicatif::ProgressBar;
use serde::Deserialize;

use crate::problem;
use crate::support::{Bench, Failure, Target};

/// What the solver found, by `ci/optimum.sh`.
const OPTIMA: &str = include_str!("../../planner/tools/optima.csv");
/// Improvement has so long.
const PATIENCE: Duration = Duration::from_millis(100);
/// Where the best leaves out less of the value than this, choosing is no art.
const LEAST_LEFT_OUT: f64 = 0.1;

/// One line of them.
#[derive(Deserialize)]
struct Optimum {
    activities: usize,
    seed: u64,
    checksum: u32,
    optimum: u64,
    bound: u64,
    total: u64,
}

/// Worth in parts of the optimum, or of what bounds it.
#[derive(Clone, Copy)]
struct Parts {
    once: f64,
    improved: f64,
}

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let optima: Result<Vec<Optimum>, _> =
        csv::Reader::from_reader(OPTIMA.as_bytes()).deserialize().collect();
    let mut optima = optima?;
    let drawn = optima.len();
    optima.retain(|one| one.left_out() >= LEAST_LEFT_OUT);
    let bar = ProgressBar::new(optima.len() as u64);
    let mut parts = Vec::new();
    for optimum in &optima {
        parts.push(optimum.compare()?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    if parts.is_empty() {
        return Err("no optimum leaves anything out: there is nothing to compare".into());
    }
    let proven = optima.iter().filter(|one| one.bound == one.optimum).count();
    report(bench, &parts, (drawn, proven));
    Ok(())
}

impl Optimum {
    /// How much of all value the optimum leaves out.
    fn left_out(&self) -> f64 {
        1.0 - self.optimum as f64 / self.total as f64
    }

    fn compare(&self) -> Result<Parts, Failure> {
        let shape = Shape::small(self.activities, self.seed);
        if shape.checksum() != self.checksum {
            let Self { activities, seed, .. } = self;
            let which = format!("{activities} activities, seed {seed}");
            return Err(
                format!("{which}: another world than the solver's; run ci/optimum.sh").into()
            );
        }
        let problem = problem(&shape.draw())?;
        let once = Worth::of(&problem, &schedule(&problem, None));
        let begin = Instant::now();
        let budget = Budget { evaluations: u64::MAX, seed: self.seed };
        let improved = improve(&problem, None, budget, &mut || begin.elapsed() >= PATIENCE);
        if improved.worth < once {
            return Err(format!("seed {}: improvement made it worse", self.seed).into());
        }
        // What is not proven counts at its bound: the comparison never flatters.
        let part = |worth: &Worth| worth.optional() as f64 / self.bound as f64;
        Ok(Parts { once: part(&once), improved: part(&improved.worth) })
    }
}

fn report(bench: &mut Bench, parts: &[Parts], (drawn, proven): (usize, usize)) {
    let mean = |of: fn(&Parts) -> f64| parts.iter().map(of).sum::<f64>() / parts.len() as f64;
    let least = |of: fn(&Parts) -> f64| parts.iter().map(of).fold(f64::INFINITY, f64::min);
    let percent = |part: f64| part * 100.0;
    let mut lost = |name: &str, part: f64, target| {
        bench.figure(21, name, percent(1.0 - part), "%", target);
    };
    lost("value lost to the optimum, one pass, mean", mean(|p| p.once), Target::AtMost(10.0));
    lost("the same, worst", least(|p| p.once), Target::None);
    let name = "value lost with 100 ms of improvement, mean";
    lost(name, mean(|p| p.improved), Target::AtMost(2.0));
    lost("the same, worst", least(|p| p.improved), Target::None);
    let beaten = parts.iter().filter(|parts| parts.once < 1.0).count();
    let share = |count: usize, of: usize| percent(count as f64 / of as f64);
    let name = "worlds in which the optimum leaves out a tenth or more";
    bench.figure(21, name, share(parts.len(), drawn), "%", Target::None);
    let name = "of these, the optimum beats the one pass in";
    bench.figure(21, name, share(beaten, parts.len()), "%", Target::None);
    bench.figure(
        21,
        "of these, the solver proved the optimum in",
        share(proven, parts.len()),
        "%",
        Target::None,
    );
}
