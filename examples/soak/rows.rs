//! What is soaked, in which share of the revocations.

use std::sync::atomic::AtomicU64;

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
use faregate::runtime::host::HostRestartable;
use faregate::runtime::host::{HostFenced, HostStrategy};

use crate::agents::{ByHand, WithService};
use crate::drive::{Drive, Tally};
use crate::driver::{Register, Worker};
use crate::gates::Gates;
use crate::rivals::{Flagged, Flags};
#[cfg(target_os = "linux")]
use crate::strategies::ParkingLot;
use crate::strategies::Soaked;
use crate::subject::Outcome;

/// Soaks one kind of subject.
pub(crate) type Soak = fn(Drive, &AtomicU64) -> Outcome<Tally>;

/// Where a row's threads run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Where {
    AllCores,
    OneCpu,
}

/// One kind of subject in one place.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    pub(crate) strategy: &'static str,
    /// What is revoked through.
    pub(crate) through: &'static str,
    pub(crate) place: Where,
    /// Of 1000 revocations; of a control, none of them.
    pub(crate) share: u64,
    /// Whether late commands are what must be seen.
    pub(crate) control: bool,
    pub(crate) check: fn() -> Outcome<()>,
    pub(crate) soak: Soak,
}

const GATE: &str = "key and gate";
const BROKER: &str = "broker";
const SERVICE: &str = "broker, service thread";

/// All rows. The shares are such that each takes a like time.
pub(crate) fn all() -> Vec<Row> {
    let mut rows = host(280);
    #[cfg(target_os = "linux")]
    rows.extend(parking_lot(280));
    rows.extend(fenced());
    #[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
    rows.extend(restartable());
    rows
}

fn host(share: u64) -> Vec<Row> {
    const NAME: &str = if cfg!(target_os = "linux") { "PiLocked" } else { "Locked<parking_lot>" };
    let gate: Soak = |drive, done| drive.soak(Gates::<HostStrategy, Worker>::new, done);
    let service: Soak =
        |drive, done| drive.soak(WithService::<Worker, HostStrategy>::with_service, done);
    in_both_places::<HostStrategy>(NAME, share, gate, (SERVICE, service))
}

#[cfg(target_os = "linux")]
fn parking_lot(share: u64) -> Vec<Row> {
    let gate: Soak = |drive, done| drive.soak(Gates::<ParkingLot, Worker>::new, done);
    let broker: Soak =
        |drive, done| drive.soak(ByHand::<Worker, ParkingLot, ParkingLot>::by_hand, done);
    in_both_places::<ParkingLot>("Locked<parking_lot>", share, gate, (BROKER, broker))
}

fn fenced() -> Vec<Row> {
    let gate: Soak = |drive, done| drive.soak(Gates::<HostFenced, Worker>::new, done);
    let service: Soak =
        |drive, done| drive.soak(WithService::<Worker, HostFenced>::with_service, done);
    in_both_places::<HostFenced>("Fenced", 280, gate, (SERVICE, service))
}

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
fn restartable() -> Vec<Row> {
    let gate: Soak = |drive, done| drive.soak(Gates::<HostRestartable, Register>::new, done);
    let service: Soak =
        |drive, done| drive.soak(WithService::<Register, HostRestartable>::with_service, done);
    in_both_places::<HostRestartable>("Restartable", 76, gate, (SERVICE, service))
}

fn in_both_places<S: Soaked>(
    strategy: &'static str,
    share: u64,
    gate: Soak,
    broker: (&'static str, Soak),
) -> Vec<Row> {
    use Where::{AllCores, OneCpu};
    vec![
        row::<S>(strategy, GATE, AllCores, share, gate),
        row::<S>(strategy, broker.0, AllCores, 10, broker.1),
        row::<S>(strategy, GATE, OneCpu, 8, gate),
        row::<S>(strategy, broker.0, OneCpu, 3, broker.1),
    ]
}

fn row<S: Soaked>(
    strategy: &'static str,
    through: &'static str,
    place: Where,
    share: u64,
    soak: Soak,
) -> Row {
    Row { strategy, through, place, share, control: false, check: S::check, soak }
}

/// What must be seen to be wrong, in each place.
pub(crate) fn controls() -> Vec<Row> {
    let bare: Soak = |drive, done| drive.soak(|| Ok(Flags::new(Flagged::Bare)), done);
    let store: Soak = |drive, done| drive.soak(|| Ok(Flags::new(Flagged::BareStore)), done);
    let places = [Where::AllCores, Where::OneCpu].into_iter();
    places
        .flat_map(|place| {
            [control("bare flag", place, bare), control("bare flag, store", place, store)]
        })
        .collect()
}

/// Broken on purpose: the mark is set without waiting for quiescence. Each row
/// must show it. (On all cores a broker rings its service before it answers,
/// which takes longer than most commands: there it is too rare to ask for.)
pub(crate) fn where_quiescence_counts() -> Vec<Row> {
    let mut rows = all();
    rows.retain(|row| row.place == Where::OneCpu || row.through == GATE);
    rows.iter_mut().for_each(|row| (row.control, row.share) = (true, 80));
    rows
}

/// Broken on purpose: the flag is looked at outside the lock.
pub(crate) fn outside_the_lock() -> Row {
    let outside: Soak = |drive, done| drive.soak(|| Ok(Flags::new(Flagged::OutsideTheLock)), done);
    Row { share: 1000, ..control("flag outside the lock", Where::AllCores, outside) }
}

fn control(strategy: &'static str, place: Where, soak: Soak) -> Row {
    let check = || Ok(());
    Row { strategy, through: "the flag", place, share: 0, control: true, check, soak }
}

#[cfg(all(test, target_os = "linux", target_arch = "x86_64"))]
mod tests {
    #[test]
    fn the_shares_are_all_of_the_revocations() {
        assert_eq!(super::all().iter().map(|row| row.share).sum::<u64>(), 1000);
    }
}
