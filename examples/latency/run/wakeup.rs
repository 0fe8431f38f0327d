//! The wake-up latency of the host, as `cyclictest` measures it: how late a
//! thread of the highest priority here wakes from a sleep to an absolute time.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::thread;
use std::time::Duration;

use rustix::io::Errno;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

use super::Outcome;
use super::measured::Measured;
use super::rights::{self, HOG, REVOKER};
use super::stage::work;

/// From one wake-up to the next.
const INTERVAL: Duration = Duration::from_micros(500);
/// How many there are in one go: short enough that the kernel takes no time
/// from the hog.
const CYCLES: u32 = 50;

/// Adds the wake-ups of one go on this CPU, which is idle otherwise, or kept
/// busy by a less important thread.
pub(crate) fn measure(measured: &mut Measured, cpu: usize, busy: bool) -> Outcome<()> {
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

fn cycle(measured: &mut Measured) -> Outcome<()> {
    let mut due = now();
    for _ in 0..CYCLES {
        due += INTERVAL;
        sleep_until(due)?;
        measured.time(now().saturating_sub(due));
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
