//! What goes into a control thread, and what comes out.

use std::collections::BTreeMap;
use std::sync::Arc;

use faregate_tickets::amount::Microjoules;

use crate::plan::{ActivityId, Outcome, Plan};
use crate::state::{Mode, Window};
use crate::timed::{Slot, TimedPlan};
use crate::trace::{Cause, Unstarted, Why};
use crate::units::{Bytes, Span};

/// How a plan is executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Whether activities may start before their planned start.
    pub early_starts: bool,
    /// Whether new plans are made.
    pub replans: bool,
    /// A new plan is made at least this often while the computer is up.
    pub period: Span,
    /// So long an estimate of the charge is believed while the computer is up.
    /// When no other has come by then, nobody knows the charge: what draws power
    /// is aborted, and nothing is started.
    pub charge_holds: Span,
}

impl Default for Options {
    /// All that the planner can do; a new plan at least every half hour; five
    /// minutes without an estimate of the charge.
    fn default() -> Self {
        let (period, charge_holds) = (Span::from_mins(30), Span::from_mins(5));
        Self { early_starts: true, replans: true, period, charge_holds }
    }
}

impl Options {
    /// The first timed plan, as it stands.
    pub const STATIC: Self = Self {
        early_starts: false,
        replans: false,
        period: Span::new(i64::MAX),
        charge_holds: Span::from_mins(5),
    };
}

/// Something happened, or was found out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// Nothing: time has passed.
    Tick,
    /// The sensors say this.
    Estimate {
        /// What the battery holds.
        charge: Microjoules,
        /// Which zones are warm enough; one that is not named is not.
        zones: BTreeMap<String, bool>,
    },
    /// A variable's value changed; none: nobody knows it any more.
    Variable(String, Option<i64>),
    /// All tickets of an activity were granted.
    Granted(ActivityId),
    /// Its tickets were taken, and its devices were made safe.
    Taken(ActivityId),
    /// Its tickets are valid again.
    Returned(ActivityId),
    /// It ended by itself.
    Ended(ActivityId, Outcome, Bytes),
    /// What it has really added to the data on board by now.
    Data(ActivityId, Bytes),
    /// The computer has begun to do this.
    Mode(Mode),
    /// The communication windows are these.
    Windows(Vec<Window>),
    /// An activity must not start.
    Veto(ActivityId),
    /// A running activity must not go on.
    Stop(ActivityId),
    /// A new timed plan is executed from now on.
    Adopt(Box<TimedPlan>),
    /// The next plan, as it was asked for; or why there is none.
    Next(Result<Arc<Plan>, String>),
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Ask for the tickets of an activity, all or nothing.
    Request(ActivityId),
    /// Give its tickets back, granted or not: it does not start now.
    Withdraw(ActivityId),
    /// Start it: its tickets are valid.
    Start(Start),
    /// Tell it to end.
    TellToEnd(ActivityId),
    /// Revoke its tickets, make its devices safe.
    Abort(ActivityId, Cause),
    /// It stands still.
    Pause(ActivityId),
    /// It goes on.
    Resume(ActivityId),
    /// It will not start.
    NotStarted(ActivityId, Unstarted),
    /// A block that nobody starts is over.
    BlockOver(ActivityId),
    /// Switch a zone's heater.
    Heat {
        /// The zone.
        zone: String,
        /// On or off.
        on: bool,
    },
    /// Wake the computer, which takes this long.
    Wake(Span),
    /// Shut the computer down, which takes this long.
    ShutDown(Span),
    /// A new plan is wanted.
    Replan(Vec<Why>),
    /// The next plan is wanted.
    LoadNext(String),
    /// The next plan took over.
    HandedOver,
    /// The next plan could not take over.
    NoNextPlan(String),
}

/// An activity is started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Start {
    /// Which one.
    pub id: ActivityId,
    /// Its planned end and the start range that it uses.
    pub slot: Slot,
    /// Whether this is before its planned start.
    pub early: bool,
}
