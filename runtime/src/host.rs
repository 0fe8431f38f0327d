//! The ports of a host, chosen together.

use faregate_tickets::Platform;

use crate::clock::MonotonicClock;
use crate::contain::Caught;
use crate::lanes::RingLane;
#[cfg(target_os = "linux")]
pub use crate::sys::Tid;

/// The platform of a host with threads: on Linux a lock with priority
/// inheritance, elsewhere `parking_lot`'s, which has none.
#[derive(Clone, Copy, Debug)]
pub enum Host {}

/// How the host enters critical sections.
#[cfg(target_os = "linux")]
pub type HostStrategy = faregate_tickets::lock::PiLocked<Tid>;

/// How the host enters critical sections. Without priority inheritance,
/// *Bounded Hand-over* holds only where no thread of a priority between holder
/// and requester runs.
#[cfg(not(target_os = "linux"))]
pub type HostStrategy =
    faregate_tickets::lock::Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

impl Platform for Host {
    type Strategy = HostStrategy;
    type Clock = MonotonicClock;
    type Lane = RingLane;
    type Containment = Caught;
}

/// Whether the host has what the strategy needs. No silent fallback: a lock
/// without priority inheritance would break *Bounded Hand-over*.
#[cfg(target_os = "linux")]
pub(crate) fn check() -> std::io::Result<()> {
    if HostStrategy::is_supported() {
        return Ok(());
    }
    let why = "this kernel has no priority-inheriting futex (CONFIG_FUTEX_PI)";
    Err(std::io::Error::new(std::io::ErrorKind::Unsupported, why))
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn check() -> std::io::Result<()> {
    Ok(())
}
