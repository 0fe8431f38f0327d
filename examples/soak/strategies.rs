//! The strategies that are soaked. A new one is added here and in the table of
//! `rows`.

use std::thread;
use std::time::{Duration, Instant};

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
use faregate::runtime::host::HostRestartable;
use faregate::runtime::host::{HostFenced, HostStrategy, Supported};
use faregate::tickets::clock;
use faregate::tickets::lock::{Fenced, Locked, Strategy, Wait};

use crate::subject::Outcome;

/// A strategy that can be soaked.
pub(crate) trait Soaked: Strategy {
    /// Whether this host has what it needs.
    fn check() -> Outcome<()>;
}

/// The host's own lock, where it is the plain one.
pub(crate) type ParkingLot = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

/// Like [`HostFenced`], for holders that are pre-empted inside a command all
/// the same: who waits sleeps, because it may be what keeps them from running.
pub(crate) type FencedAsleep = Fenced<HostStrategy, Asleep>;

/// Sleeps between two looks: long enough that the kernel does let others run.
#[derive(Debug)]
pub(crate) enum Asleep {}

impl Wait for Asleep {
    fn until(timeout: clock::Duration, mut over: impl FnMut() -> bool) -> bool {
        let begun = Instant::now();
        while !over() {
            if begun.elapsed() > timeout.into() {
                return over();
            }
            thread::park_timeout(Duration::from_micros(50));
        }
        true
    }
}

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

impl Soaked for FencedAsleep {
    fn check() -> Outcome<()> {
        Ok(<HostFenced as Supported>::check()?)
    }
}

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
impl Soaked for HostRestartable {
    fn check() -> Outcome<()> {
        Ok(<Self as Supported>::check()?)
    }
}
