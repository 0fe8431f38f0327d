//! Wake-ups: how a thread sleeps until something happened or a deadline came.
//!
//! There is no polling interval: a sleeping thread costs nothing.

#[cfg(any(test, not(target_os = "linux")))]
#[cfg_attr(
    target_os = "linux",
    expect(unreachable_pub, reason = "built here only to test its claims")
)]
mod condvar;
#[cfg(target_os = "linux")]
mod eventfd;
#[cfg(test)]
mod tests;

#[cfg(not(target_os = "linux"))]
pub use condvar::Wakeup;
#[cfg(target_os = "linux")]
pub use eventfd::Wakeup;

/// Why a wait ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[must_use = "a wait that ended at its deadline was not told of anything"]
pub enum Woken {
    /// Somebody notified, before the wait or during it.
    Notified,
    /// The deadline came first.
    Deadline,
}
