//! The control thread: a plan is executed, at a higher rate than it is made.
//!
//! A step function. What happened goes in, with the instant at which it did;
//! what is to be done comes out. It has no clock, device or ticket itself: its
//! host has them, and asks [`Control::due`] when to come again. Whoever plans is
//! called by the host, too, when [`Action::Replan`] says so, from
//! [`Control::state`]; the answer comes back as [`Event::Adopt`].
//!
//! # What it does
//!
//! | when | what |
//! |---|---|
//! | a planned start has come | checks everything again with what is known now, then asks for tickets |
//! | the tickets are granted | checks once more, and starts the sequence |
//! | cutoff passed; hard limit; optional and soft limit; optional and past its duration | aborts |
//! | no estimate of the charge has come for too long | aborts what draws power, and sleeps |
//! | tickets are taken | pauses what can be paused, aborts the rest |
//! | something ended early, failed or was vetoed | starts what is planned next, if nothing planned has to start later for it |
//! | an expanding activity is at its planned end | tells it to end, and gives it a grace |
//! | handover | the next plan takes over, if it is there |
//!
//! | file | what |
//! |---|---|
//! | `absorb` | what happened |
//! | `aborts` | what must not go on |
//! | `computer` | the computer and the heaters |
//! | `dispatch`, `ready` | planned starts, and what is checked |
//! | `early` | starts before the planned one |
//! | `exchange` | what goes in and what comes out |
//! | `named` | named timelines |
//! | `outlook` | limits on the projection |
//! | `silence` | when nobody knows the charge |
//! | `wishes` | when a new plan is wanted |

mod aborts;
mod absorb;
mod book;
mod computer;
mod dispatch;
mod due;
mod early;
mod exchange;
mod handover;
mod named;
mod outlook;
mod ready;
mod silence;
mod wishes;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::parameters::Parameters;
use crate::plan::{Activity, ActivityId, Plan};
use crate::state::State;
use crate::timed::{Slot, TimedPlan};
use crate::trace::Why;
use crate::units::Time;

pub use exchange::{Action, Event, Options, Start};
pub use outlook::Outlook;
pub use ready::NotReady;

pub(crate) use handover::{begin_next, with_what_runs};
pub(crate) use named::Values;
pub(crate) use ready::Look;

/// The control thread of one plan.
#[derive(Clone, Debug)]
pub struct Control {
    plan: Arc<Plan>,
    parameters: Arc<Parameters>,
    options: Options,
    index: BTreeMap<ActivityId, usize>,
    state: State,
    named: Values,
    timed: TimedPlan,
    /// What is planned and has not started.
    planned: BTreeMap<ActivityId, Slot>,
    /// Tickets that were asked for: since when, and whether before the planned
    /// start.
    asked: BTreeMap<ActivityId, Asked>,
    /// Expanding activities that were told to end.
    told: BTreeSet<ActivityId>,
    /// Zones that are warm enough, by their estimates.
    warm: BTreeMap<String, bool>,
    /// Estimates in a row below the soft limit.
    below_soft: u32,
    /// The hard limit was reached, and the charge has not recovered.
    spent: bool,
    /// When the charge was estimated last.
    estimated_at: Time,
    /// Since when nobody knows the charge.
    blind: Option<Time>,
    /// The computer has just come up, and its sensors have said nothing yet.
    looks_around: bool,
    /// Something ended before its planned end, and what comes next may start.
    freed: bool,
    /// A new plan was wanted for that: its next activity may start, too.
    tries_again: bool,
    wishes: BTreeSet<Why>,
    planned_at: Time,
    /// What a new plan was wanted for since the last one: not again.
    wished: BTreeSet<Why>,
    next_plan: NextPlan,
    /// The next plan took over, and nobody has timed it yet.
    is_untimed: bool,
    is_over: bool,
    actions: Vec<Action>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Asked {
    since: Time,
    early: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NextPlan {
    Expected,
    AskedFor,
    None,
}

impl Control {
    /// Executes a plan that was made from this state.
    #[must_use]
    pub fn new(
        plan: Arc<Plan>,
        parameters: Arc<Parameters>,
        state: State,
        timed: TimedPlan,
        options: Options,
    ) -> Self {
        let next_plan = if plan.next_plan.is_some() { NextPlan::Expected } else { NextPlan::None };
        let now = state.now;
        let mut control = Self {
            index: book::index(&plan),
            named: Values::begin(&plan, &parameters, &state),
            plan,
            parameters,
            options,
            state,
            timed: TimedPlan::default(),
            planned: BTreeMap::new(),
            asked: BTreeMap::new(),
            told: BTreeSet::new(),
            warm: BTreeMap::new(),
            below_soft: 0,
            spent: false,
            estimated_at: now,
            blind: None,
            looks_around: false,
            freed: false,
            tries_again: false,
            wishes: BTreeSet::new(),
            planned_at: now,
            wished: BTreeSet::new(),
            next_plan,
            is_untimed: false,
            is_over: false,
            actions: Vec::new(),
        };
        control.adopt(timed);
        control
    }

    /// Takes in what happened, and decides what is to be done. What happened at
    /// one instant comes in before its [`Event::Tick`].
    ///
    /// # Timing
    /// A look at each activity; for each that could start now, a projection of
    /// the charge.
    pub fn step(&mut self, now: Time, event: Event) -> Vec<Action> {
        self.pass(now);
        let all_is_said = matches!(event, Event::Tick);
        self.absorb(event);
        if !self.is_over {
            if all_is_said {
                self.notice_silence();
            }
            self.abort_what_must_not_go_on(all_is_said);
            self.take_over();
            self.close_ranges();
            self.run_computer();
            self.heat();
            self.dispatch();
            self.start_early();
            self.want_plans();
            self.end_plan();
        }
        std::mem::take(&mut self.actions)
    }

    /// What is so now, as far as is known: what a plan is made from.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The plan that is executed: the next one, after handover.
    #[must_use]
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// The timed plan that is executed.
    #[must_use]
    pub fn timed(&self) -> &TimedPlan {
        &self.timed
    }

    /// The timed plan that a new one is made from: what waits for its tickets
    /// begins now, and not in the past.
    #[must_use]
    pub fn incumbent(&self) -> TimedPlan {
        self.with_pushed_starts()
    }

    /// Whether this plan has been timed: one that took over just now has not, and
    /// a timed plan for it has no incumbent.
    #[must_use]
    pub const fn is_timed(&self) -> bool {
        !self.is_untimed
    }

    /// Whether the plan has come to its end.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    fn now(&self) -> Time {
        self.state.now
    }

    fn activity(&self, id: ActivityId) -> Option<&Activity> {
        self.plan.activities.get(*self.index.get(&id)?)
    }
}
