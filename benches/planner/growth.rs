//! Rows 18 and 19: one plan, and how its cost grows with its activities.

use std::hint::black_box;
use std::time::{Duration, Instant};

use faregate_planner::generate::{Shape, World};
use faregate_planner::{schedule, schedule_plainly};
use indicatif::ProgressBar;

use crate::support::{Bench, Curve, Failure, Quantiles, Series, Target};
use crate::tightness::{Tightness, tightness};
use crate::{naive, problem};

/// Plans of so many activities: whole sols, so that each is as crowded as the
/// others.
const SIZES: [usize; 5] = [100, 300, 1_000, 3_000, 10_000];
/// The growth that is asked for is between the first of them and the last.
const LAST: usize = SIZES.len() - 1;
/// A plan that would take longer is not made: the row says so.
const PATIENCE: Duration = Duration::from_secs(120);
/// Of so many rounds; with fewer of them patience is shorter.
const ROUNDS: u32 = 2_000;
/// Worlds of each size.
const WORLDS: u64 = 5;
/// How crowded worlds are is looked at in those of these two sizes.
const LOOKS: [usize; 2] = [0, 2];

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let bar = ProgressBar::new(SIZES.len() as u64);
    let (mut ours, mut theirs): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for (nth, size) in SIZES.into_iter().enumerate() {
        if !worth_waiting(nth, &ours, PATIENCE * bench.rounds() / ROUNDS) {
            let last = SIZES[nth - 1];
            bar.println(format!("{size} activities: skipped, {last} took {:.1} s", ours[nth - 1]));
            break;
        }
        let count = if size > 1_000 { 1 } else { WORLDS };
        let worlds: Vec<World> = (0..count).map(|seed| Shape::sols(size, seed).draw()).collect();
        ours.push(seconds(&worlds, count, |world| {
            let problem = problem(world)?;
            let start = Instant::now();
            black_box(schedule(&problem, None));
            Ok(start.elapsed())
        })?);
        theirs.push(seconds(&worlds, count, |world| {
            let start = Instant::now();
            black_box(naive::schedule(&world.plan, &world.parameters, &world.state));
            Ok(start.elapsed())
        })?);
        if nth == 0 {
            plainly(bench, &worlds, ours[0])?;
        }
        if LOOKS.contains(&nth) {
            crowding(bench, &worlds, size)?;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    report(bench, &ours, &theirs);
    Ok(())
}

/// By the growth so far: the next size has about three times the activities.
fn worth_waiting(nth: usize, took: &[f64], patience: Duration) -> bool {
    let growth = match took {
        [.., before, last] => last / before,
        _ => 10.0,
    };
    nth == 0 || took[nth - 1] * growth < patience.as_secs_f64()
}

/// The median over worlds of the least of some samples, in seconds.
fn seconds(
    worlds: &[World],
    rounds: u64,
    sample: impl Fn(&World) -> Result<Duration, Failure>,
) -> Result<f64, Failure> {
    let least = |world| {
        let samples = (0..rounds).map(|_| sample(world));
        let least = samples.collect::<Result<Vec<_>, _>>()?.into_iter().min();
        Ok(least.unwrap_or_default().as_secs_f64())
    };
    let took: Result<Vec<_>, Failure> = worlds.iter().map(least).collect();
    Ok(Quantiles::of(took?).median)
}

fn report(bench: &mut Bench, ours: &[f64], theirs: &[f64]) {
    let name = "one plan of 100 activities, one sol, median";
    bench.figure(18, name, ours[0] * 1e3, "ms", Target::AtMost(5.0));
    bench.figure(18, "the same, naive: a grid, no charge", theirs[0] * 1e3, "ms", Target::None);
    let last = ours.len() - 1;
    let target = if last == LAST { Target::AtMost(400.0) } else { Target::None };
    let name = format!("one plan, {} activities / 100", SIZES[last]);
    bench.figure(19, &name, ours[last] / ours[0], "x", target);
    let name = format!("the same, naive, {} activities / 100", SIZES[last]);
    bench.figure(19, &name, theirs[last] / theirs[0], "x", Target::None);
    let series = |name, took: &[f64]| {
        let points = SIZES.iter().zip(took).map(|(&size, s)| (size as f64, s * 1e3));
        Series::new(name, points.collect())
    };
    let curve = Curve::new("plan-activities", "One plan, by its activities", "activities", "ms");
    let curve = curve.log_x().log_y().with(series("Faregate", ours));
    bench.curve(curve.with(series("naive: a grid, no charge", theirs)));
}

/// The same planner without anything kept: a world from now to the end for each
/// start, to the byte the same plans.
fn plainly(bench: &mut Bench, worlds: &[World], ours: f64) -> Result<(), Failure> {
    let plain = seconds(worlds, 1, |world| {
        let problem = problem(world)?;
        let start = Instant::now();
        let (timed, _) = black_box(schedule_plainly(&problem));
        let took = start.elapsed();
        if timed != schedule(&problem, None) {
            return Err("a plan is another one where nothing is kept".into());
        }
        Ok(took)
    })?;
    let name = "the same, each start from nothing";
    bench.figure(18, name, plain * 1e3, "ms", Target::None);
    bench.figure(18, "the same, each start from nothing / ours", plain / ours, "x", Target::None);
    Ok(())
}

/// How crowded the worlds are: where that is not alike, growth says little.
fn crowding(bench: &mut Bench, worlds: &[World], size: usize) -> Result<(), Failure> {
    let all: Result<Vec<Tightness>, Failure> = worlds.iter().map(tightness).collect();
    let all = all?.into_iter().reduce(Tightness::plus).unwrap_or_default();
    let name = format!("intervals of valid starts for each candidate, mean, of {size}");
    bench.figure(19, &name, all.intervals(), "intervals", Target::None);
    let name = format!("candidates that the charge moves or keeps out, of {size}");
    bench.figure(19, &name, all.bound_by_charge() * 100.0, "%", Target::None);
    let name = format!("starts tried for each candidate, mean, of {size}");
    bench.figure(19, &name, all.starts(), "starts", Target::None);
    Ok(())
}
