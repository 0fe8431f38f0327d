//! Row 14: how late a task starts that is due at a time, and one that another
//! task's end lets go.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::thread;

use faregate_agents::Categories;
use faregate_runtime::clock::MonotonicClock;
use faregate_runtime::realtime::RealTime;
use faregate_scheduler::bodies::Moment;
use faregate_scheduler::task::Task;
use faregate_scheduler::time::{Duration, Instant};
use faregate_tickets::clock::Clock;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

use crate::scene::{Ends, Moments, brief, manager, place};
use crate::support::{Bench, Failure, Quantiles, Target};

/// Tasks in the schedule, whether or not all of them are waited for.
const TASKS: u32 = 1_000;
/// From one start to the next: more than the 50 ms ahead of which a start is
/// made durable.
const APART: Duration = Duration::from_millis(60);
/// How often the bare thread wakes.
const PERIOD: u64 = 5_000;
const FIFO: u8 = 80;

/// On a thread of its own, whose priority is not that of what is measured later.
pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    thread::scope(|scope| {
        let measured = scope.spawn(|| timed_starts(bench).map_err(|why| why.to_string()));
        measured.join().map_err(|_| "the manager's thread panicked")?.map_err(Failure::from)
    })
}

fn timed_starts(bench: &mut Bench) -> Result<(), Failure> {
    let starts = TASKS.min(bench.rounds() / 2).max(3);
    let report = RealTime::request().fifo(FIFO).apply();
    if !report.is_complete() {
        eprintln!("{report}");
    }
    let over = AtomicBool::new(false);
    let (seen, wakes) = thread::scope(|scope| {
        let bare = scope.spawn(|| wake_up(&over));
        let seen = run(timed(starts), starts);
        over.store(true, SeqCst);
        (seen, bare.join())
    });
    let wakes = wakes.map_err(|_| "the bare thread panicked")?;
    let (ends, moments) = seen?;
    let loaded = ends.loaded.ok_or("nothing was loaded")?;
    let due = |task: u32| loaded.after(APART.saturating_mul(u64::from(task)));
    let forks = at(&moments, Moment::Fork);
    let late: Vec<_> = forks.iter().map(|&(task, at)| ns(at.since(due(task)))).collect();
    if late.len() < usize::try_from(starts)? {
        return Err(format!("{} of {starts} tasks started", late.len()).into());
    }
    let (late, wakes) = (Quantiles::of(late), Quantiles::of(wakes));
    let name = "timed start, lateness / a bare thread's wake-up, p99.9";
    bench.figure(14, name, late.p999 / wakes.p999, "x", Target::AtMost(2.0));
    bench.figure(14, "the same, medians", late.median / wakes.median, "x", Target::None);
    bench.figure(14, "timed start, lateness, median", late.median / 1e3, "us", Target::None);
    bench.figure(14, "timed start, lateness, p99.9", late.p999 / 1e3, "us", Target::None);
    bench.figure(14, "a bare thread's wake-up, p99.9", wakes.p999 / 1e3, "us", Target::None);
    let forked = at(&moments, Moment::Forked);
    let took = forks.iter().zip(&forked).map(|((_, from), (_, to))| ns(to.since(*from)));
    let took = Quantiles::of(took.collect());
    bench.figure(14, "fork and exec, median", took.median / 1e3, "us", Target::None);
    after_an_end(bench, starts)
}

/// A chain in one category: each start is caused by an end, and synced.
fn after_an_end(bench: &mut Bench, starts: u32) -> Result<(), Failure> {
    let chain = (1..=starts).map(|number| {
        let mut task = brief(number, Duration::ZERO);
        task.categories = Categories::from_mask(1);
        task
    });
    let (ends, moments) = run(chain.collect(), starts)?;
    let forks = at(&moments, Moment::Fork);
    let after = |(_, over): &(u32, Instant)| {
        forks.iter().map(|(_, at)| *at).find(|at| at > over).map(|at| ns(at.since(*over)))
    };
    let took = Quantiles::of(ends.over.iter().filter_map(after).collect());
    bench.figure(
        14,
        "start after another's end, synced, median",
        took.median / 1e3,
        "us",
        Target::None,
    );
    bench.figure(14, "start after another's end, synced, p99", took.p99 / 1e3, "us", Target::None);
    Ok(())
}

/// All tasks, of which so many are due in this run.
fn timed(starts: u32) -> Vec<Task> {
    let far = Duration::from_secs(1_000_000);
    let due = |number| if number <= starts { APART.saturating_mul(u64::from(number)) } else { far };
    (1..=TASKS).map(|number| brief(number, due(number))).collect()
}

fn run(tasks: Vec<Task>, ends: u32) -> Result<(Ends, Moments), Failure> {
    let directory = place()?;
    let (mut onboard, moments) = manager(directory.path())?;
    onboard.load(tasks)?;
    let mut over = 0;
    while over < usize::try_from(ends)? {
        let soon = onboard.now().elapsed.after(Duration::from_secs(1));
        onboard.run_until(soon, |_, _| false)?;
        over = onboard.outside().over.len();
    }
    let seen = std::mem::take(onboard.outside());
    onboard.close()?;
    Ok((seen, moments))
}

fn at(moments: &Moments, which: Moment) -> Vec<(u32, Instant)> {
    let moments = moments.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    moments
        .iter()
        .filter(|(moment, ..)| *moment == which)
        .map(|&(_, task, at)| (task, at))
        .collect()
}

fn ns(duration: Duration) -> f64 {
    duration.as_micros() as f64 * 1e3
}

/// How late a thread is that does nothing but wake up: what `cyclictest`
/// measures, beside the manager and at its priority. In nanoseconds.
fn wake_up(over: &AtomicBool) -> Vec<f64> {
    let _ = RealTime::request().fifo(FIFO).apply();
    let clock = MonotonicClock::new();
    let mut due = clock.now().as_micros();
    let mut late = Vec::new();
    while !over.load(SeqCst) {
        due += PERIOD;
        let (s, us) = (due / 1_000_000, due % 1_000_000);
        let (Ok(tv_sec), Ok(us)) = (i64::try_from(s), i64::try_from(us)) else { break };
        let at = Timespec { tv_sec, tv_nsec: us * 1_000 };
        if clock_nanosleep_absolute(ClockId::Monotonic, &at).is_err() {
            continue;
        }
        late.push(clock.now().as_micros().saturating_sub(due) as f64 * 1e3);
    }
    late
}
