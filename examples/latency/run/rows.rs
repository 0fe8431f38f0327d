//! The rows: each case, behind each lock, in each placement.

use std::io;
use std::sync::{Arc, Mutex};

use faregate::runtime::host::{HostFenced, HostStrategy, Supported};
use priority_inheriting_lock::PriorityInheritingLock;

use super::gates::ParkingLot;
use super::locks::{self, Lock, Spinning};
use super::measured::Measured;
use super::rights::Placement;
use super::stage::{Limits, Stage};
use super::{Outcome, brokers, gates};

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Case {
    Command,
    AnyInstant,
    Check,
    HandOver,
    WakeUp,
}

impl Case {
    pub(crate) const ALL: [Self; 5] =
        [Self::Command, Self::AnyInstant, Self::Check, Self::HandOver, Self::WakeUp];

    /// For figures.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Command => "inversion",
            Self::AnyInstant => "revocation at any instant",
            Self::Check => "refused holder inside its check",
            Self::HandOver => "emergency hand-over",
            Self::WakeUp => "wake-up",
        }
    }

    /// From when until when.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Command => {
                "From revocation until quiescent; the holder is pre-empted inside a command"
            }
            Self::AnyInstant => {
                "From revocation until quiescent; the holder commands all the time, one store each"
            }
            Self::Check => {
                "From a valid command until it is issued; a refused holder is pre-empted inside its check"
            }
            Self::HandOver => {
                "From the emergency's request until its first command; the victim is pre-empted inside its own"
            }
            Self::WakeUp => "The host alone: from when a thread should wake until it runs",
        }
    }
}

/// What a row is expected to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Expected {
    /// A gate of ours, with the time that its 99th percentile is to keep to on
    /// one CPU, where there is one.
    Ours(Option<u32>),
    /// A gate of ours whose waiters lend no priority, and says so.
    OursLendingNone,
    /// A plain lock whose waiters lend their priority.
    Peer,
    /// A plain lock whose waiters lend none: the control of the hog.
    PeerLendingNone,
    /// A plain lock whose waiters spin: on one CPU, for ever. The control of
    /// placement and priorities.
    Spinning,
    /// Commands after quiescence: the control of the device's count.
    Late,
    /// The host alone.
    Host,
}

type Play = fn(&Arc<Stage>, Limits) -> Outcome<Measured>;

/// One row.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    pub(crate) case: Case,
    pub(crate) who: &'static str,
    pub(crate) expected: Expected,
    /// Asks whether the host has what the row needs.
    needs: fn() -> io::Result<()>,
    play: Play,
}

impl Row {
    fn new(case: Case, who: &'static str, expected: Expected, play: Play) -> Self {
        Self { case, who, expected, needs: HostStrategy::check, play }
    }

    /// Whether the host can play it; if not, what is missing.
    pub(crate) fn check(&self) -> Result<(), String> {
        (self.needs)().map_err(|missing| format!("{}, {}: {missing}", self.case.name(), self.who))
    }

    pub(crate) fn play(&self, placement: Placement, limits: Limits) -> Outcome<Measured> {
        (self.play)(&Stage::new(placement)?, limits)
    }

    /// The target of its 99th percentile, in microseconds.
    pub(crate) fn target_us(&self, placement: Placement) -> Option<u32> {
        match self.expected {
            Expected::Ours(target) if placement.is_one_cpu() => target,
            _ => None,
        }
    }
}

/// All that are played, in order.
pub(crate) fn all() -> Vec<Row> {
    let mut rows: Vec<_> = [pi_locked(), restartable(), fenced(), locked()].concat();
    rows.extend(peers::<PriorityInheritingLock<()>>("priority-inheriting-lock", Expected::Peer));
    rows.extend(peers::<Mutex<()>>("std Mutex", Expected::PeerLendingNone));
    let lends_none = Expected::PeerLendingNone;
    rows.extend(peers::<parking_lot::Mutex<()>>("parking_lot Mutex", lends_none));
    rows.extend(peers::<Spinning>("spinning", Expected::Spinning));
    rows.extend(bare_flag());
    // Stable: within a case they stay in this order.
    rows.sort_by_key(|row| Case::ALL.iter().position(|case| *case == row.case));
    rows
}

fn pi_locked() -> Vec<Row> {
    let row = |case, expected, play| Row::new(case, "PiLocked gate", expected, play);
    let service = brokers::with_service::<HostStrategy>;
    vec![
        row(Case::Command, Expected::Ours(Some(60)), gates::inside_command::<HostStrategy>),
        row(Case::AnyInstant, Expected::Ours(None), gates::any_instant::<HostStrategy>),
        row(Case::Check, Expected::Ours(Some(60)), gates::inside_check::<HostStrategy>),
        row(Case::HandOver, Expected::Ours(None), brokers::by_requester::<HostStrategy>),
        Row::new(Case::HandOver, "PiLocked gate, service", Expected::Ours(None), service),
    ]
}

/// A command of several steps goes by the `PiLocked` within; one that is a
/// store is called back, which is what has the target.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
fn restartable() -> Vec<Row> {
    use super::restarts::Counted;
    use faregate::runtime::host::HostRestartable;

    let row = |case, expected, play| Row {
        needs: HostRestartable::check,
        ..Row::new(case, "Restartable gate", expected, play)
    };
    let service = brokers::with_service::<HostRestartable>;
    vec![
        row(Case::Command, Expected::Ours(None), gates::inside_command::<Counted>),
        row(Case::AnyInstant, Expected::Ours(Some(10)), gates::any_instant::<Counted>),
        row(Case::Check, Expected::Ours(None), gates::inside_check::<Counted>),
        row(Case::HandOver, Expected::Ours(None), brokers::by_requester::<Counted>),
        Row {
            who: "Restartable gate, service",
            ..row(Case::HandOver, Expected::Ours(None), service)
        },
    ]
}

/// There are no restartable sequences for this processor yet.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn restartable() -> Vec<Row> {
    Vec::new()
}

fn fenced() -> Vec<Row> {
    let row = |case, play| {
        let lends_none = Row::new(case, "Fenced gate", Expected::OursLendingNone, play);
        Row { needs: HostFenced::check, ..lends_none }
    };
    vec![
        row(Case::Command, gates::inside_command::<HostFenced>),
        row(Case::AnyInstant, gates::any_instant::<HostFenced>),
        row(Case::Check, gates::inside_check::<HostFenced>),
    ]
}

fn locked() -> Vec<Row> {
    let row =
        |case, play| Row::new(case, "Locked<parking_lot> gate", Expected::OursLendingNone, play);
    vec![
        row(Case::Command, gates::inside_command::<ParkingLot>),
        row(Case::AnyInstant, gates::any_instant::<ParkingLot>),
        row(Case::Check, gates::inside_check::<ParkingLot>),
        row(Case::HandOver, brokers::by_requester::<ParkingLot>),
    ]
}

fn peers<L: Lock>(who: &'static str, expected: Expected) -> [Row; 2] {
    [
        Row::new(Case::Command, who, expected, locks::inside_command::<L>),
        Row::new(Case::Check, who, expected, locks::inside_check::<L>),
    ]
}

fn bare_flag() -> [Row; 2] {
    let at_any_instant = locks::bare_flag_at_any_instant;
    [
        Row::new(Case::Command, "bare flag", Expected::Late, locks::bare_flag),
        Row::new(Case::AnyInstant, "bare flag, 1 us commands", Expected::Late, at_any_instant),
    ]
}
