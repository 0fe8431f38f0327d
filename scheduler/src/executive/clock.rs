//! The host's two clocks, and the timers that end a wait.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::io::Errno;
use rustix::time::{
    ClockId, Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, Timespec, clock_gettime,
    timerfd_create, timerfd_settime,
};

use crate::time::{Due, Instant, Now, UnixTime};

/// `CLOCK_BOOTTIME`, counted from the manager's start, and the wall clock.
#[derive(Clone, Copy, Debug)]
pub struct HostClock {
    /// Microseconds of `CLOCK_BOOTTIME` at the start.
    origin: u64,
}

impl HostClock {
    /// The clocks, with the present as the start.
    #[must_use]
    pub fn start() -> Self {
        Self { origin: boottime() }
    }

    /// The present.
    #[must_use]
    pub fn now(&self) -> Now {
        let wall = clock_gettime(ClockId::Realtime);
        Now {
            elapsed: Instant::from_micros(boottime().saturating_sub(self.origin)),
            wall: UnixTime::from_micros(
                wall.tv_sec.saturating_mul(1_000_000).saturating_add(wall.tv_nsec / 1_000),
            ),
        }
    }

    fn boot_instant(&self, elapsed: Instant) -> Timespec {
        let micros = self.origin.saturating_add(elapsed.as_micros());
        timespec(i64::try_from(micros).unwrap_or(i64::MAX))
    }
}

fn boottime() -> u64 {
    let time = clock_gettime(ClockId::Boottime);
    let micros = time.tv_sec.saturating_mul(1_000_000).saturating_add(time.tv_nsec / 1_000);
    // The kernel never gives a negative one.
    u64::try_from(micros).unwrap_or(0)
}

fn timespec(micros: i64) -> Timespec {
    Timespec { tv_sec: micros.div_euclid(1_000_000), tv_nsec: micros.rem_euclid(1_000_000) * 1_000 }
}

/// Two timers whose file descriptors become readable when they run out.
///
/// Both are set to absolute instants, so a late wake-up is not added to the
/// next. The one of the wall clock is told by the kernel when somebody sets the
/// clock: a wait for a time of day ends when that time has come, however it
/// came.
#[derive(Debug)]
pub struct Timers {
    clock: HostClock,
    elapsed: OwnedFd,
    wall: OwnedFd,
    armed: Due,
}

impl Timers {
    /// Timers that are not set.
    ///
    /// # Errors
    /// When the host has no file descriptor left.
    pub fn new(clock: HostClock) -> io::Result<Self> {
        let flags = TimerfdFlags::CLOEXEC | TimerfdFlags::NONBLOCK;
        Ok(Self {
            clock,
            elapsed: timerfd_create(TimerfdClockId::Boottime, flags)?,
            wall: timerfd_create(TimerfdClockId::Realtime, flags)?,
            armed: Due::default(),
        })
    }

    /// Sets both timers, each to its instant or to none.
    ///
    /// # Errors
    /// The kernel's.
    pub fn arm(&mut self, due: Due) -> io::Result<()> {
        if due.elapsed != self.armed.elapsed {
            let at = due.elapsed.map(|at| self.clock.boot_instant(at));
            set(&self.elapsed, TimerfdTimerFlags::ABSTIME, at)?;
        }
        if due.wall != self.armed.wall {
            let flags = TimerfdTimerFlags::ABSTIME | TimerfdTimerFlags::CANCEL_ON_SET;
            set(&self.wall, flags, due.wall.map(|at| timespec(at.as_micros())))?;
        }
        self.armed = due;
        Ok(())
    }

    /// What to wait for.
    pub fn fds(&self) -> [BorrowedFd<'_>; 2] {
        [self.elapsed.as_fd(), self.wall.as_fd()]
    }

    /// Takes note that timers ran out, or that the clock was set: they are to
    /// be set again.
    pub fn rearm(&mut self) {
        // A timer that is set anew forgets that it ran out, and that the clock
        // jumped: there is nothing to be read from it.
        self.armed =
            Due { elapsed: Some(Instant::FAR_FUTURE), wall: Some(UnixTime::from_micros(i64::MIN)) };
    }
}

fn set(timer: &OwnedFd, flags: TimerfdTimerFlags, at: Option<Timespec>) -> io::Result<()> {
    // All zero would switch it off.
    let at = at.map_or(timespec(0), |at| if at == timespec(0) { timespec(1) } else { at });
    let once = Itimerspec { it_interval: timespec(0), it_value: at };
    match timerfd_settime(timer, flags, &once) {
        // The clock was set since: told once, and by the second call forgotten.
        Err(Errno::CANCELED) => timerfd_settime(timer, flags, &once).map(drop)?,
        set => set.map(drop)?,
    }
    Ok(())
}
