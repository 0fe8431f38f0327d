//! The emergency as it is on a spacecraft, within the bound that the library
//! computes: estimates come 20 ms late, and the first safing has no effect.

use std::time::Duration;

use faregate_tickets::clock::Duration as Lag;
use faregate_tickets::device::Profile;

use crate::agency;
use crate::plant::declared;
use crate::rescue::Rescue;
use crate::sensors::Sensing;
use crate::support::{Bench, Failure, Target};

/// When an estimate of a device at rest has arrived, as declared: the next
/// measurement may be a period away, and its bringer be woken late.
const DECLARED_LAG: Lag = Lag::from_millis(20);
const PERIOD: Lag = Lag::from_millis(1);
const LAG: Lag = Lag::from_millis(18);
/// Sensors that do not keep to what is declared.
const LATE: Lag = Lag::from_millis(90);
const EMERGENCIES: u32 = 50;
const FAILED_SAFINGS: u32 = 1;

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let (slowest, bound) = slowest(LAG, EMERGENCIES.min(bench.rounds()))?;
    let name = "emergency, 20 ms lag and a failed safing: slowest / the computed bound";
    bench.figure(10, name, slowest.as_secs_f64() / bound.as_secs_f64(), "x", Target::AtMost(1.0));
    let bound = bound.as_secs_f64() * 1e3;
    bench.figure(10, "the computed bound of that emergency", bound, "ms", Target::None);
    control()
}

/// The bound is one for what was declared: with sensors that are later it has
/// to be missed, or it says nothing.
fn control() -> Result<(), Failure> {
    let (slowest, bound) = slowest(LATE, 1)?;
    if slowest > bound {
        return Ok(());
    }
    Err(format!("late sensors kept the bound of {bound:?} too: {slowest:?}").into())
}

/// The slowest of so many emergencies, and what the library computed.
fn slowest(lag: Lag, emergencies: u32) -> Result<(Duration, Duration), Failure> {
    let profile = Profile { estimate_lag: DECLARED_LAG, ..declared() };
    let sensing = Sensing::Periodic { period: PERIOD, lag };
    let rescue = Rescue::new(agency::runtime(1, profile)?, sensing, 0)?;
    let bound = rescue.bound().ok_or("the bound was not computed")?;
    let mut slowest = Duration::ZERO;
    for _ in 0..emergencies {
        slowest = slowest.max(rescue.round(FAILED_SAFINGS)?);
    }
    Ok((slowest, bound.into()))
}
