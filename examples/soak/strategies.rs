//! The strategies that are soaked. A new one is added here and in the table of
//! `rows`.

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
use faregate::runtime::host::HostRestartable;
use faregate::runtime::host::{HostFenced, HostStrategy, Supported};
use faregate::tickets::lock::{Locked, Strategy};

use crate::subject::Outcome;

/// A strategy that can be soaked.
pub(crate) trait Soaked: Strategy {
    /// Whether this host has what it needs.
    fn check() -> Outcome<()>;
}

/// The host's own lock, where it is the plain one.
pub(crate) type ParkingLot = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

impl Soaked for HostStrategy {
    fn check() -> Outcome<()> {
        Ok(<Self as Supported>::check()?)
    }
}

#[cfg(target_os = "linux")]
impl Soaked for ParkingLot {
    fn check() -> Outcome<()> {
        Ok(())
    }
}

impl Soaked for HostFenced {
    fn check() -> Outcome<()> {
        Ok(<Self as Supported>::check()?)
    }
}

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
impl Soaked for HostRestartable {
    fn check() -> Outcome<()> {
        Ok(<Self as Supported>::check()?)
    }
}
