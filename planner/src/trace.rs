//! What really happened while a plan was executed: written by a rehearsal, read
//! by checkers. It holds the truth beside what the control thread was told.

use serde::{Deserialize, Serialize};

use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::plan::{ActivityId, Outcome, Plan};
use crate::state::{Mode, State, Window};
use crate::timed::{Slot, TimedPlan};
use crate::units::{Bytes, Span, Time};

/// One execution of a plan, from its begin to its end.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trace {
    /// When it began.
    pub begin: Time,
    /// When it was over: the end of the plan, or of the last that took over.
    pub end: Time,
    /// Whether the first timed plan was executed as it stood: no new plans, no
    /// early starts.
    pub is_static: bool,
    /// How late what the control thread knew of the charge was at most: samples
    /// that old may still hold it up.
    pub charge_lag: Span,
    /// How wrong it was at most, in uJ.
    pub charge_noise: Microjoules,
    /// How long the control thread believes an estimate of the charge while the
    /// computer is up; none: for ever.
    pub charge_holds: Option<Span>,
    /// The communication windows, as they really were.
    pub windows: Vec<Window>,
    /// What happened, in order; of what happened at one instant, causes first.
    pub entries: Vec<Entry>,
}

/// Something happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// When.
    pub at: Time,
    /// What.
    pub what: Happened,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Happened {
    /// A timed plan was made from this state, and is executed from now on. The
    /// first entry of every trace is one.
    Planned {
        /// Why.
        why: Vec<Why>,
        /// What it was made from.
        state: Box<State>,
        /// The plan.
        timed: Box<TimedPlan>,
    },
    /// A start that is late for want of tickets is planned for now instead: the
    /// plan that is made next leaves it alone.
    Pushed {
        /// Which one.
        id: ActivityId,
        /// When it is to run.
        slot: Slot,
    },
    /// An activity's tickets were asked for.
    Requested(ActivityId),
    /// Its tickets were granted, and it was started.
    Dispatched(Box<Dispatch>),
    /// An expanding activity was told to end.
    ToldToEnd(ActivityId),
    /// It ended by itself.
    Ended {
        /// Which one.
        id: ActivityId,
        /// Never [`Outcome::Aborted`] or [`Outcome::NotStarted`].
        outcome: Outcome,
        /// What it really added to the data on board.
        data: Bytes,
    },
    /// It was aborted.
    Aborted {
        /// Which one.
        id: ActivityId,
        /// Why.
        cause: Cause,
        /// What it really added to the data on board.
        data: Bytes,
    },
    /// Its tickets were revoked: none of its commands is accepted any more.
    Revoked(ActivityId),
    /// Its devices were made safe and seen off.
    Safed(ActivityId),
    /// It stands still: its tickets were taken.
    Paused(ActivityId),
    /// It goes on.
    Resumed(ActivityId),
    /// It will not start: this is its fate.
    NotStarted {
        /// Which one.
        id: ActivityId,
        /// Why.
        why: Unstarted,
    },
    /// A zone's heater was switched.
    Heater {
        /// The zone.
        zone: String,
        /// Whether it is on.
        on: bool,
    },
    /// The computer begins to do this.
    Mode(Mode),
    /// A communication window opened or closed, by its place in the list.
    Window {
        /// Which one.
        index: usize,
        /// Whether it opened.
        open: bool,
    },
    /// A variable really changed. None: it is not known any more.
    Variable {
        /// Its name.
        name: String,
        /// Its value.
        value: Option<i64>,
    },
    /// The control thread learned of an estimate of the charge.
    Estimate {
        /// The charge as estimated.
        charge: Microjoules,
    },
    /// How things really stand from now on. One after each change of loads.
    Truth(Truth),
    /// Something that nobody planned draws so much from now on.
    Leak(Milliwatts),
    /// The battery has lost so much at once.
    Lost(Microjoules),
    /// This plan took over, with the definitions of what runs.
    HandedOver(Box<Plan>),
    /// The next plan could not take over: this plan goes on to its end.
    NoNextPlan(String),
}

/// An activity was started.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dispatch {
    /// Which one.
    pub id: ActivityId,
    /// Which of its start ranges it uses.
    pub range: usize,
    /// Its planned end.
    pub ends: Time,
    /// Whether it was before its planned start.
    pub early: bool,
    /// The zones that it uses.
    pub zones: Vec<ZoneSeen>,
    /// The variables of its conditions, as they were looked at.
    pub variables: Vec<(String, Option<i64>)>,
}

/// A zone, as it was estimated and as it was.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ZoneSeen {
    /// The zone.
    pub zone: String,
    /// What the control thread was told: warm enough.
    pub ok: bool,
    /// How warm it really is, in thousandths of a degree.
    pub truly: i64,
    /// How warm it must be.
    pub needed: i64,
    /// How wrong the estimate can be: noise, and what can have changed since the
    /// measurement.
    pub margin: i64,
}

/// How things really stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Truth {
    /// What the battery holds.
    pub charge: Microjoules,
    /// What is drawn beside the base load, on average.
    pub load: Milliwatts,
    /// The sum of what can be drawn at most.
    pub peak: Milliwatts,
    /// Sequence engines in use.
    pub engines: u32,
    /// Data on board since the plan's begin.
    pub data: Bytes,
}

/// Why an activity was aborted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Cause {
    /// It had not finished by its cutoff.
    Cutoff,
    /// The charge was at the hard limit.
    HardLimit,
    /// It is optional, and the charge was below the soft limit.
    SoftLimit,
    /// It is optional, and ran past its duration.
    Duration,
    /// It draws power, and nobody knew the charge any more.
    ChargeUnknown,
    /// Its tickets were taken, and it cannot be paused.
    TicketsTaken,
    /// The ground or the host wanted it.
    Ordered,
}

/// Why an activity did not start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Unstarted {
    /// Its last start range closed before it could.
    RangeClosed,
    /// It was vetoed.
    Vetoed,
    /// The plan ended, or did not have it.
    NotPlanned,
    /// The next plan took over.
    HandedOver,
}

/// Why a new plan was wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Why {
    /// It is the first one.
    First,
    /// The period was over.
    Periodic,
    /// Something ended earlier than planned.
    EndedEarly(ActivityId),
    /// Something ended otherwise than planned: its dependants and its cleanup.
    Outcome(ActivityId),
    /// Something runs longer than planned.
    Overran(ActivityId),
    /// Something started before its planned start.
    StartedEarly(ActivityId),
    /// Something could not start when it should.
    Late(ActivityId),
    /// Something was vetoed or will not start.
    NotStarted(ActivityId),
    /// A zone was not warm when it should be.
    ZoneCold,
    /// The communication windows changed.
    Windows,
    /// Tickets were taken, or came back.
    Tickets(ActivityId),
    /// The next plan took over.
    HandOver,
}
