//! The wake-up latency of the host: how late a thread of the highest priority
//! here wakes from a sleep to an absolute time, as `cyclictest` measures it, and
//! how long after another CPU rang for it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};
use std::thread;
use std::time::Duration;

use rustix::io::Errno;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

use super::bell::Bell;
use super::measured::Measured;
use super::rights::{self, HOG, HOLDER, Placement, REVOKER};
use super::stage::{Answer, work};
use super::{Failure, Outcome};

/// From one wake-up to the next.
const INTERVAL: Duration = Duration::from_micros(500);
/// How many there are in one go: short enough that the kernel takes no time
/// from the hog.
const CYCLES: u32 = 50;

/// What wakes the thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum By {
    /// The timer of its own CPU, which is idle.
    Timer,
    /// The same, while a less important thread keeps the CPU busy.
    TimerWhenBusy,
    /// A thread of the other CPU.
    OtherCpu,
}

impl By {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Timer => "timer, idle CPU",
            Self::TimerWhenBusy => "timer, hog on the CPU",
            Self::OtherCpu => "rung by the other CPU",
        }
    }
}

/// Adds the wake-ups of one go.
pub(crate) fn measure(measured: &mut Measured, by: By, placement: Placement) -> Outcome<()> {
    match by {
        By::Timer => by_timer(measured, placement.holder_cpu, false),
        By::TimerWhenBusy => by_timer(measured, placement.holder_cpu, true),
        By::OtherCpu => by_other_cpu(measured, placement),
    }
}

fn by_timer(measured: &mut Measured, cpu: usize, busy: bool) -> Outcome<()> {
    let over = AtomicBool::new(!busy);
    thread::scope(|scope| {
        let hog = scope.spawn(|| {
            let permitted = rights::take(cpu, HOG);
            let longest = INTERVAL * CYCLES * 2;
            permitted.inspect(|()| work(longest, || over.load(SeqCst)))
        });
        let cycles = scope.spawn(|| {
            let cycled = rights::take(cpu, REVOKER).and_then(|()| cycle(measured));
            over.store(true, SeqCst);
            cycled
        });
        cycles.join().map_err(|_| "the wake-up loop panicked")??;
        hog.join().map_err(|_| "the hog panicked")?
    })
}

fn by_other_cpu(measured: &mut Measured, placement: Placement) -> Outcome<()> {
    let (bell, answer, rung_at) = (Bell::new()?, Bell::new()?, AtomicU64::new(0));
    thread::scope(|scope| {
        let woken = scope.spawn(|| {
            rights::take(placement.revoker_cpu, REVOKER)?;
            for _ in 0..CYCLES {
                bell.wait()?;
                let rung_at = Duration::from_nanos(rung_at.load(SeqCst));
                measured.time(now().saturating_sub(rung_at), Answer::Done);
                answer.ring();
            }
            Ok::<_, Failure>(())
        });
        let ringer = scope.spawn(|| {
            rights::take(placement.holder_cpu, HOLDER)?;
            for _ in 0..CYCLES {
                sleep(INTERVAL)?;
                rung_at.store(now().as_nanos().try_into()?, SeqCst);
                bell.ring();
                answer.wait()?;
            }
            Ok::<_, Failure>(())
        });
        woken.join().map_err(|_| "the woken thread panicked")??;
        ringer.join().map_err(|_| "the ringing thread panicked")?
    })
}

fn cycle(measured: &mut Measured) -> Outcome<()> {
    let mut due = now();
    for _ in 0..CYCLES {
        due += INTERVAL;
        sleep_until(due)?;
        measured.time(now().saturating_sub(due), Answer::Done);
    }
    Ok(())
}

/// Sleeps for so long.
pub(crate) fn sleep(time: Duration) -> Outcome<()> {
    sleep_until(now() + time)
}

fn sleep_until(due: Duration) -> Outcome<()> {
    let due = Timespec { tv_sec: due.as_secs().try_into()?, tv_nsec: due.subsec_nanos().into() };
    loop {
        match clock_nanosleep_absolute(ClockId::Monotonic, &due) {
            Err(Errno::INTR) => {}
            slept => return Ok(slept?),
        }
    }
}

/// The monotonic clock. `Instant` does not say what the kernel calls it.
fn now() -> Duration {
    let now = clock_gettime(ClockId::Monotonic);
    // Neither is ever negative.
    let seconds = u64::try_from(now.tv_sec).unwrap_or(0);
    Duration::new(seconds, u32::try_from(now.tv_nsec).unwrap_or(0))
}
