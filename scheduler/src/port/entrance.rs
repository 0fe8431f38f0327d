//! Who may issue a command for an attempt: nobody once the attempt is over.

use crate::sync::{AtomicU32, Ordering};

/// Lets commands of an attempt in until it is closed, and knows whether one is
/// inside.
///
/// | bits | who changes them | meaning |
/// |---|---|---|
/// | 0 | [`close`](Self::close) | closed: nobody enters |
/// | 1 to 31 | [`enter`](Self::enter), [`Inside::leave`] | how many are inside |
///
/// **Shut Entrance**: when [`close`](Self::close) has answered
/// [`Quiet::Now`], or the last who was inside has been told the same by
/// [`Inside::leave`], no command of the attempt is in progress and none begins.
/// One word holds both, and its changes have one order: a command enters before
/// the close, which then sees it, or finds the entrance closed.
#[derive(Debug)]
pub struct Entrance(AtomicU32);

const CLOSED: u32 = 1;
const ONE: u32 = 2;

/// Whether the attempt is known to be quiet: closed, and nobody inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "an attempt is over when it is quiet"]
pub enum Quiet {
    /// It is, and stays so.
    Now,
    /// It is not.
    NotYet,
}

impl Default for Entrance {
    fn default() -> Self {
        Self::new()
    }
}

impl Entrance {
    /// An open entrance with nobody inside.
    #[must_use]
    pub fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Enters, unless it is closed.
    pub fn enter(&self) -> Option<Inside<'_>> {
        if cfg!(feature = "mutant-look-then-enter") {
            let open = self.0.load(Ordering::Acquire) & CLOSED == 0;
            return open.then(|| {
                self.0.fetch_add(ONE, Ordering::Acquire);
                Inside(self)
            });
        }
        // Relaxed: the word guards no memory on the way in. That the tickets
        // are those of this attempt is what the order of the word itself gives.
        let entered = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |word| {
            (word & CLOSED == 0).then_some(word + ONE)
        });
        match entered {
            Ok(_) => Some(Inside(self)),
            Err(_) => None,
        }
    }

    /// Closes it: nobody enters any more.
    ///
    /// # Timing
    /// One atomic operation; waits for nobody.
    pub fn close(&self) -> Quiet {
        // Acquire, with the Release of `leave`: everything that was done inside
        // is visible to whoever is told that it is quiet.
        quiet(self.0.fetch_or(CLOSED, Ordering::Acquire) | CLOSED)
    }

    /// Whether it is closed and nobody is inside.
    pub fn quiet(&self) -> Quiet {
        // Acquire: as in `close`.
        quiet(self.0.load(Ordering::Acquire))
    }
}

const fn quiet(word: u32) -> Quiet {
    if word == CLOSED { Quiet::Now } else { Quiet::NotYet }
}

/// A command in progress. Dropped, it has left, and nobody is told.
#[derive(Debug)]
#[must_use = "a command is in progress while this lives"]
pub struct Inside<'a>(&'a Entrance);

impl Inside<'_> {
    /// Leaves. Whoever hears [`Quiet::Now`] was the last inside a closed
    /// entrance, and tells who waits for it.
    pub fn leave(self) -> Quiet {
        core::mem::ManuallyDrop::new(self).0.step_out()
    }
}

impl Drop for Inside<'_> {
    fn drop(&mut self) {
        let _ = self.0.step_out();
    }
}

impl Entrance {
    /// Whether it is closed.
    pub fn is_closed(&self) -> bool {
        // Relaxed: who closes it and who asks are one thread, or do not care.
        self.0.load(Ordering::Relaxed) & CLOSED != 0
    }

    fn step_out(&self) -> Quiet {
        // Release: see `close`. The chain of the word's changes carries it on
        // from those who left before.
        let order = if cfg!(feature = "mutant-relaxed-leave") {
            Ordering::Relaxed
        } else {
            Ordering::Release
        };
        let left = self.0.fetch_sub(ONE, order) - ONE;
        if cfg!(feature = "mutant-silent-leave") { Quiet::NotYet } else { quiet(left) }
    }
}
