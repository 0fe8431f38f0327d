//! The rows: each case, behind each lock, in each placement.

use std::sync::Arc;
use std::sync::Mutex;

use faregate::runtime::host::HostStrategy;
use faregate::tickets::lock::Locked;
use priority_inheriting_lock::PriorityInheritingLock;

use super::locks::{self, Spinning};
use super::measured::Measured;
use super::rights::Placement;
use super::stage::{Limits, Stage};
use super::{Outcome, brokers, gates};

type ParkingLot = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

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
    /// A plain lock.
    Peer,
    /// No way to wait on one CPU.
    NeverOnOneCpu,
    /// Commands after quiescence: the control.
    Late,
    /// The host alone.
    Host,
}

/// One row.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    pub(crate) case: Case,
    pub(crate) who: &'static str,
    pub(crate) expected: Expected,
    play: fn(&Arc<Stage>, Limits) -> Outcome<Measured>,
}

impl Row {
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

const PI: &str = "PiLocked gate";
const LOCKED: &str = "Locked<parking_lot> gate";
const STD: &str = "std Mutex";
const PARKING_LOT: &str = "parking_lot Mutex";
const PI_CRATE: &str = "priority-inheriting-lock";
const SPINNING: &str = "spinning";

/// All that are played, in order.
pub(crate) fn all() -> Vec<Row> {
    let row = |case, who, expected, play| Row { case, who, expected, play };
    let mut rows = vec![
        row(Case::Command, PI, Expected::Ours(Some(60)), gates::inside_command::<HostStrategy>),
        row(Case::Command, LOCKED, Expected::Ours(None), gates::inside_command::<ParkingLot>),
        row(Case::AnyInstant, PI, Expected::Ours(None), gates::any_instant::<HostStrategy>),
        row(Case::AnyInstant, LOCKED, Expected::Ours(None), gates::any_instant::<ParkingLot>),
        row(Case::Check, PI, Expected::Ours(Some(60)), gates::inside_check::<HostStrategy>),
        row(Case::Check, LOCKED, Expected::Ours(None), gates::inside_check::<ParkingLot>),
        row(
            Case::HandOver,
            "PiLocked, service thread",
            Expected::Ours(None),
            brokers::with_service,
        ),
        row(Case::HandOver, PI, Expected::Ours(None), brokers::by_requester::<HostStrategy>),
        row(Case::HandOver, LOCKED, Expected::Ours(None), brokers::by_requester::<ParkingLot>),
    ];
    rows.extend(peers::<PriorityInheritingLock<()>>(PI_CRATE, Expected::Peer));
    rows.extend(peers::<Mutex<()>>(STD, Expected::Peer));
    rows.extend(peers::<parking_lot::Mutex<()>>(PARKING_LOT, Expected::Peer));
    rows.extend(peers::<Spinning>(SPINNING, Expected::NeverOnOneCpu));
    rows.push(row(Case::Command, "bare flag", Expected::Late, locks::bare_flag));
    let bare_flag = locks::bare_flag_at_any_instant;
    rows.push(row(Case::AnyInstant, "bare flag, 1 us commands", Expected::Late, bare_flag));
    rows.sort_by_key(|row| Case::ALL.iter().position(|case| *case == row.case));
    rows
}

fn peers<L: locks::Lock>(who: &'static str, expected: Expected) -> [Row; 2] {
    [
        Row { case: Case::Command, who, expected, play: locks::inside_command::<L> },
        Row { case: Case::Check, who, expected, play: locks::inside_check::<L> },
    ]
}
