//! Row 13: a decision, at every size of the schedule.

use std::hint::black_box;
use std::time::Instant;

use faregate_scheduler::manager::{Addition, Telecommand};
use indicatif::ProgressBar;

use crate::smaarte::Schedule;
use crate::support::{Bench, Curve, Failure, Quantiles, Series, Target};
use crate::world::{World, id, peer, task};

/// Schedules of so many tasks.
const SIZES: [u32; 4] = [100, 1_000, 10_000, 100_000];

/// What can happen. Of the worst of these, at its 99th percentile, the figure
/// is made.
const KINDS: [&str; 5] = ["due", "end", "add", "remove", "revoke"];

/// Nanoseconds of each kind of event, one list for each.
type Samples = [Vec<f64>; KINDS.len()];

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let rounds = bench.rounds() / 5 + 3;
    let bar = ProgressBar::new(u64::from(rounds) * SIZES.len() as u64);
    bar.set_prefix("decisions");
    let worlds = SIZES.map(World::new);
    let peers = SIZES.map(peer);
    let mut ours = [(); SIZES.len()].map(|()| Samples::default());
    let mut theirs = [(); SIZES.len()].map(|()| Samples::default());
    for _ in 0..rounds {
        for size in 0..SIZES.len() {
            sample_ours(worlds[size].clone(), SIZES[size], &mut ours[size]);
            // The peer's worst is so much slower that fewer samples do.
            if theirs[size][0].len() < 100 {
                sample_peer(peers[size].clone(), SIZES[size], &mut theirs[size]);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    report(bench, &ours, &theirs);
    Ok(())
}

fn timed(samples: &mut Vec<f64>, event: impl FnOnce()) {
    let start = Instant::now();
    event();
    samples.push(start.elapsed().as_secs_f64() * 1e9);
}

/// One event of each kind, in a world of its own.
fn sample_ours(mut world: World, size: u32, samples: &mut Samples) {
    let [due, end, add, remove, revoke] = samples;
    // What copying the world left of the caches is nobody's measure.
    world.become_due();
    timed(due, || world.become_due());
    timed(revoke, || world.revoke());
    world.restore();
    let addition = Addition { task: task(size + 1, 0, 7) };
    timed(add, || world.telecommand(Telecommand::Add(vec![addition])));
    timed(remove, || world.telecommand(Telecommand::Remove(vec![id(size / 2)])));
    // An end is two decisions: who is next, and, when its tickets are valid,
    // that it starts.
    let mut both = [0.0; 2];
    let mut one = Vec::new();
    timed(&mut one, || world.end());
    world.follow();
    let grants = world.grants();
    timed(&mut one, || world.step(grants));
    both.copy_from_slice(&one);
    end.push(both[0].max(both[1]));
    world.follow();
    assert!(world.runs.is_some(), "after an end the next one runs");
}

fn sample_peer(mut schedule: Schedule, size: u32, samples: &mut Samples) {
    let [due, end, add, remove, revoke] = samples;
    black_box(schedule.process(1));
    timed(due, || {
        black_box(schedule.process(2));
    });
    timed(revoke, || {
        black_box(schedule.process(2));
    });
    let more = schedule.entries[0];
    timed(add, || {
        schedule.entries.push(crate::smaarte::Entry { id: size + 1, active: false, ..more });
        black_box(schedule.process(2));
    });
    timed(remove, || {
        schedule.remove(size / 2);
        black_box(schedule.process(2));
    });
    timed(end, || {
        schedule.remove(1);
        black_box(schedule.process(2));
    });
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
    for (kind, name) in KINDS.iter().enumerate() {
        let p99 = Quantiles::of(ours[last][kind].clone()).p99 / 1e3;
        let name = format!("decision among 100 000, {name}, p99");
        bench.figure(13, &name, p99, "us", Target::None);
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
