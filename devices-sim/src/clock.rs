//! The clock of the simulated spacecraft: virtual, or the machine's own.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use faregate_tickets::clock::{Clock, Duration, Instant};

use crate::interleave;

/// A handle to the spacecraft's clock; clones show the same time.
///
/// Virtual time stands still until somebody moves it: the interleaver, when
/// every body waits; or, outside an interleaver, whoever waits. Real time is the
/// machine's, counted from when the clock was made, so that the same spacecraft
/// also runs under real threads.
#[derive(Clone)]
pub struct SimClock(Arc<Time>);

enum Time {
    /// Microseconds. Moved by one thread at a time, and read for its value
    /// only: what happens at an instant is ordered by the locks of those who
    /// do it, so Relaxed is enough.
    Virtual(AtomicU64),
    Real(std::time::Instant),
}

impl SimClock {
    /// A clock that stands at [`Instant::START`].
    #[must_use]
    pub fn virtual_time() -> Self {
        Self(Arc::new(Time::Virtual(AtomicU64::new(0))))
    }

    /// A clock that runs with the machine's, from [`Instant::START`] on.
    #[must_use]
    pub fn real_time() -> Self {
        Self(Arc::new(Time::Real(std::time::Instant::now())))
    }

    /// Moves virtual time forward to `instant`. Never goes back; real time
    /// goes its own way.
    pub fn advance_to(&self, instant: Instant) {
        if let Time::Virtual(us) = &*self.0 {
            us.fetch_max(instant.as_micros(), Ordering::Relaxed);
        }
    }

    /// Waits until `instant`: in real time the thread sleeps; in virtual time
    /// the interleaver lets other bodies run, or, outside one, the time simply
    /// passes.
    pub fn wait_until(&self, instant: Instant) {
        match &*self.0 {
            Time::Real(_) => sleep(instant.since(self.now())),
            Time::Virtual(_) if interleave::is_running() => interleave::wait_until(instant),
            Time::Virtual(_) => self.advance_to(instant),
        }
    }
}

impl Clock for SimClock {
    fn now(&self) -> Instant {
        match &*self.0 {
            Time::Virtual(us) => Instant::from_micros(us.load(Ordering::Relaxed)),
            Time::Real(start) => Instant::START.after(Duration::from(start.elapsed())),
        }
    }
}

impl fmt::Debug for SimClock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match &*self.0 {
            Time::Virtual(_) => "virtual",
            Time::Real(_) => "real",
        };
        write!(f, "SimClock({kind}, {})", self.now())
    }
}

#[expect(clippy::disallowed_methods, reason = "here is where real time is meant")]
fn sleep(duration: Duration) {
    std::thread::sleep(duration.into());
}
