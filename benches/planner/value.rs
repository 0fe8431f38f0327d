//! Row 21: what plans are worth, beside the best that an exact solver found.
//! Values are of mandatory and optional activities together.
//!
//! The optima are in `planner/tools/optima.csv`, which `ci/optimum.sh` writes.
//! They are of the worlds that are drawn here, or the bench fails.

use std::time::{Duration, Instant};

use faregate_planner::generate::Shape;
use faregate_planner::{Activity, Budget, TimedPlan, Worth, improve, schedule};
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
    /// How many evaluations improvement had time for.
    evaluations: f64,
    /// The optimum is proven.
    proven: bool,
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
    let (proven, bounded): (Vec<Parts>, Vec<Parts>) = parts.iter().partition(|part| part.proven);
    if proven.is_empty() {
        return Err("no proven optimum leaves anything out: there is nothing to compare".into());
    }
    beside_optima(bench, &proven);
    beside_bounds(bench, &bounded);
    rates(bench, &proven, (drawn, parts.len()));
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
        let world = shape.draw();
        let problem = problem(&world)?;
        let once = schedule(&problem, None);
        let begin = Instant::now();
        let budget = Budget { evaluations: u64::MAX, seed: self.seed };
        let improved = improve(&problem, None, budget, &mut || begin.elapsed() >= PATIENCE);
        if improved.worth < Worth::of(&problem, &once) {
            return Err(format!("seed {}: improvement made it worse", self.seed).into());
        }
        let value = |timed: &TimedPlan| {
            let activities = world.plan.activities.iter();
            let values = activities.filter(|one| timed.slot(one.id).is_some()).map(Activity::worth);
            let part = values.sum::<u64>() as f64 / self.bound as f64;
            // Mandatory activities may exceed limits that the solver's model
            // keeps; that is not better than the optimum.
            if timed.excess.is_empty() { part } else { part.min(1.0) }
        };
        if value(&once).max(value(&improved.timed)) > 1.0 {
            return Err(format!("seed {}: worth more than can be", self.seed).into());
        }
        Ok(Parts {
            once: value(&once),
            improved: value(&improved.timed),
            evaluations: improved.evaluations as f64,
            proven: self.optimum == self.bound,
        })
    }
}

fn mean(parts: &[Parts], of: fn(&Parts) -> f64) -> f64 {
    parts.iter().map(of).sum::<f64>() / parts.len() as f64
}

fn least(parts: &[Parts], of: fn(&Parts) -> f64) -> f64 {
    parts.iter().map(of).fold(f64::INFINITY, f64::min)
}

fn lost(bench: &mut Bench, name: &str, part: f64, target: Target) {
    bench.figure(21, name, 100.0 * (1.0 - part), "%", target);
}

fn beside_optima(bench: &mut Bench, proven: &[Parts]) {
    let name = "value lost to the optimum, one pass, mean";
    lost(bench, name, mean(proven, |p| p.once), Target::AtMost(10.0));
    lost(bench, "the same, worst", least(proven, |p| p.once), Target::None);
    let name = "value lost with 100 ms of improvement, mean";
    lost(bench, name, mean(proven, |p| p.improved), Target::AtMost(2.0));
    lost(bench, "the same, worst", least(proven, |p| p.improved), Target::None);
    let name = "candidates evaluated in these 100 ms, mean";
    bench.figure(21, name, mean(proven, |p| p.evaluations), "", Target::None);
}

/// What is not proven is compared with its bound: that never flatters.
fn beside_bounds(bench: &mut Bench, bounded: &[Parts]) {
    if bounded.is_empty() {
        return;
    }
    let name = "value lost to the bound where the optimum is not proven, one pass, mean";
    lost(bench, name, mean(bounded, |p| p.once), Target::None);
    let name = "the same, with 100 ms of improvement, mean";
    lost(bench, name, mean(bounded, |p| p.improved), Target::None);
}

/// Which worlds they are.
fn rates(bench: &mut Bench, proven: &[Parts], (drawn, tight): (usize, usize)) {
    let percent = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
    let mut rate = |name: &str, share: f64| bench.figure(21, name, share, "%", Target::None);
    let name = "worlds in which the optimum leaves out a tenth or more of the value";
    rate(name, percent(tight, drawn));
    rate("of these, the solver proved the optimum in", percent(proven.len(), tight));
    let beaten = proven.iter().filter(|parts| parts.once < 1.0).count();
    rate("of these, the optimum beats the one pass in", percent(beaten, proven.len()));
    bench.figure(21, "such worlds", proven.len() as f64, "", Target::None);
}
