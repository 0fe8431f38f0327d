//! Row 13: a decision, at every size of the schedule, in time.

use std::time::Instant;

use faregate_scheduler::manager::State;
use indicatif::ProgressBar;

use crate::smaarte;
use crate::stream::{KINDS, Schedule, Stream};
use crate::support::{Bench, Curve, Failure, Quantiles, Series, Target};
use crate::world::World;

/// Schedules of so many tasks.
const SIZES: [u32; 4] = [100, 1_000, 10_000, 100_000];
/// The peer's decisions differ so little that fewer samples do.
const PEERS: u32 = 200;

/// Nanoseconds of each kind of event, one list for each.
type Samples = [Vec<f64>; KINDS.len()];

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let rounds = bench.rounds();
    let bar = ProgressBar::new(u64::from(rounds));
    let mut ours = SIZES.map(Stream::<World>::new);
    let mut theirs = SIZES.map(Stream::<smaarte::Schedule>::new);
    let [mut our_samples, mut their_samples] =
        [(); 2].map(|()| [(); SIZES.len()].map(|()| Samples::default()));
    for nth in 0..rounds {
        for (stream, samples) in ours.iter_mut().zip(&mut our_samples) {
            sample(stream, samples);
        }
        for (stream, samples) in theirs.iter_mut().zip(&mut their_samples) {
            if nth < PEERS {
                sample(stream, samples);
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    ours.iter().try_for_each(as_many_wait)?;
    report(bench, &our_samples, &their_samples);
    Ok(())
}

/// A round that is not measured, and one that is. Of the first one's events the
/// second one finds in the caches what any event touches: what other schedules
/// left of them is nobody's measure.
fn sample<S: Schedule>(stream: &mut Stream<S>, samples: &mut Samples) {
    for _ in KINDS {
        stream.pass();
    }
    for samples in samples {
        let event = stream.make();
        let start = Instant::now();
        stream.schedule.happen(event);
        samples.push(start.elapsed().as_secs_f64() * 1e9);
        stream.follow();
    }
}

/// A schedule that empties would be measured as a small one.
fn as_many_wait(stream: &Stream<World>) -> Result<(), Failure> {
    let states = stream.schedule.manager.status();
    let waiting = states.filter(|task| matches!(task.state, State::Waiting(_))).count();
    if waiting == stream.waiting() {
        return Ok(());
    }
    Err(format!("{waiting} tasks wait, and not {}", stream.waiting()).into())
}

/// The 99th percentile of the worst kind, in nanoseconds.
fn worst(samples: &Samples) -> f64 {
    samples.iter().map(|kind| Quantiles::of(kind.clone()).p99).fold(0.0, f64::max)
}

fn report(bench: &mut Bench, ours: &[Samples], theirs: &[Samples]) {
    let (our, their): (Vec<_>, Vec<_>) =
        ours.iter().zip(theirs).map(|(ours, theirs)| (worst(ours), worst(theirs))).unzip();
    let last = SIZES.len() - 1;
    let name = "decision, 100 000 tasks / 100, p99 of the worst";
    bench.figure(13, name, our[last] / our[0], "x", Target::AtMost(3.0));
    let name = "the same, SMAARTE's sort and sweep";
    bench.figure(13, name, their[last] / their[0], "x", Target::None);
    let name = "SMAARTE's sort and sweep / ours, 100 000 tasks";
    bench.figure(13, name, their[last] / our[last], "x", Target::None);
    for size in [0, last] {
        for (kind, samples) in KINDS.iter().zip(&ours[size]) {
            let p99 = Quantiles::of(samples.clone()).p99 / 1e3;
            let name = format!("decision among {}, {}, p99", SIZES[size], kind.name());
            bench.figure(13, &name, p99, "us", Target::None);
        }
    }
    let series = |name, worst: &[f64]| {
        let points = SIZES.iter().zip(worst).map(|(&size, ns)| (f64::from(size), ns / 1e3));
        Series::new(name, points.collect())
    };
    let curve = Curve::new(
        "decision-tasks",
        "A decision of the schedule manager, p99 of the worst event",
        "tasks",
        "us",
    );
    bench.curve(
        curve
            .log_x()
            .log_y()
            .with(series("Faregate", &our))
            .with(series("SMAARTE: sort and sweep", &their)),
    );
}
