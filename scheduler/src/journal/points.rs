//! Where a test kills the process: the named places between which a journal,
//! an exec or a reap must never be in two minds.
//!
//! Without the feature `kill-points` all of this is nothing. With it,
//! `FAREGATE_KILL_POINT=before-sync:3` makes the process kill itself, as
//! `kill -9` does, when it comes to that place for the third time. `census`
//! tells how often it came to each.

use core::fmt;

/// A place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Point {
    /// Before a journal file is written.
    BeforeWrite,
    /// Half of the bytes are written.
    InsideWrite,
    /// The bytes are written, and nothing was done of what they tell.
    AfterWrite,
    /// Before a log is synced.
    BeforeSync,
    /// It is durable, and nothing was done of what it tells.
    AfterSync,
    /// Some frames of a snapshot are written.
    InsideSnapshot,
    /// A snapshot is durable, and what it replaces is still there.
    AfterSnapshot,
    /// Before a file that a snapshot replaces is removed.
    BeforeRemoval,
    /// Before a process is forked.
    BeforeExec,
    /// In the child, before it becomes the task's program: its parent dies.
    InsideExec,
    /// The task's program runs, and nobody knows of it yet.
    AfterExec,
    /// A body has ended, and was not collected.
    BeforeReap,
    /// It was collected, and the manager was not told.
    InsideReap,
    /// The manager was told.
    AfterReap,
}

impl Point {
    /// All of them, in this order.
    pub const ALL: [Self; 14] = [
        Self::BeforeWrite,
        Self::InsideWrite,
        Self::AfterWrite,
        Self::BeforeSync,
        Self::AfterSync,
        Self::InsideSnapshot,
        Self::AfterSnapshot,
        Self::BeforeRemoval,
        Self::BeforeExec,
        Self::InsideExec,
        Self::AfterExec,
        Self::BeforeReap,
        Self::InsideReap,
        Self::AfterReap,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::BeforeWrite => "before-write",
            Self::InsideWrite => "inside-write",
            Self::AfterWrite => "after-write",
            Self::BeforeSync => "before-sync",
            Self::AfterSync => "after-sync",
            Self::InsideSnapshot => "inside-snapshot",
            Self::AfterSnapshot => "after-snapshot",
            Self::BeforeRemoval => "before-removal",
            Self::BeforeExec => "before-exec",
            Self::InsideExec => "inside-exec",
            Self::AfterExec => "after-exec",
            Self::BeforeReap => "before-reap",
            Self::InsideReap => "inside-reap",
            Self::AfterReap => "after-reap",
        }
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(feature = "kill-points")]
pub use armed::{census, hit, is_due, torn};
#[cfg(not(feature = "kill-points"))]
pub use disarmed::{hit, is_due, torn};

#[cfg(not(feature = "kill-points"))]
mod disarmed {
    use super::Point;

    /// The process comes to this place; it dies if it is to die here.
    #[inline(always)]
    pub const fn hit(_: Point) {}

    /// As [`hit`], after doing this if it is to die here.
    #[inline(always)]
    pub fn torn(_: Point, _: impl FnOnce()) {}

    /// Counts a visit, and answers whether the process is to die here: for
    /// places where somebody else must do it.
    #[inline(always)]
    #[must_use]
    pub const fn is_due(_: Point) -> bool {
        false
    }
}

#[cfg(feature = "kill-points")]
mod armed {
    use core::sync::atomic::{AtomicU64, Ordering};
    use std::sync::LazyLock;

    use super::Point;

    static VISITS: [AtomicU64; Point::ALL.len()] = [const { AtomicU64::new(0) }; Point::ALL.len()];
    static DEATH: LazyLock<Option<(Point, u64)>> = LazyLock::new(|| {
        let order = std::env::var("FAREGATE_KILL_POINT").ok()?;
        let (name, visit) = order.split_once(':')?;
        let point = Point::ALL.into_iter().find(|point| point.name() == name)?;
        Some((point, visit.parse().ok()?))
    });

    /// The process comes to this place; it dies if it is to die here.
    pub fn hit(point: Point) {
        torn(point, || {});
    }

    /// As [`hit`], after doing this if it is to die here.
    pub fn torn(point: Point, half: impl FnOnce()) {
        if is_due(point) {
            half();
            die();
        }
    }

    /// Counts a visit, and answers whether the process is to die here: for
    /// places where somebody else must do it.
    #[must_use]
    pub fn is_due(point: Point) -> bool {
        // Only a count: no other memory is read because of it.
        let visit = VISITS[point as usize].fetch_add(1, Ordering::Relaxed) + 1;
        *DEATH == Some((point, visit))
    }

    /// How often this process came to each place.
    pub fn census() -> impl Iterator<Item = (Point, u64)> {
        let visits = |point| VISITS[point as usize].load(Ordering::Relaxed);
        Point::ALL.into_iter().map(move |point| (point, visits(point)))
    }

    /// No destructor, no flush, no handler: as if the power button of the
    /// process had been pressed.
    fn die() -> ! {
        let own = rustix::process::getpid();
        let _ = rustix::process::kill_process(own, rustix::process::Signal::KILL);
        loop {
            // The signal is on its way to this thread.
            std::thread::park();
        }
    }
}
