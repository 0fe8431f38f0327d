//! Has a plan executed by the schedule manager: hears what becomes of tasks,
//! keeps the state that plans are made from, says when a new one is wanted, and
//! turns it into telecommands.
//!
//! A state machine without clock or thread. Its host forwards each
//! [`Note`](faregate_scheduler::manager::Note) of the manager and what sensors
//! say, calls [`Director::turn`] at each of these and at [`Director::due`], and
//! gives the manager the telecommands that come out, in their order and before
//! its next decision: all of them at once, as
//! [`commands`](faregate_scheduler::executive::HostExecutive::commands) does.
//! Else what one of them makes room for could start before the next one says
//! that it is not to.
//!
//! | what happens | what the director does |
//! |---|---|
//! | an activity starts, ends, fails, is missed | it runs, or has ended; if that is not as planned, a new plan |
//! | something ended early, failed or did not start | what is planned next starts now, if nothing planned has to start later for it |
//! | what cannot be paused loses its tickets | ABORTED: its task is removed, so that it does not run again; a new plan, with its cleanup |
//! | heating is taken | the zone is cold: a new plan heats it from scratch |
//! | a condition of what is planned does not hold, or its zone is cold | its task is held until that is otherwise |
//! | what runs has not ended when the computer is to be shut down | the shutdown waits for it |
//! | what runs has not ended when a manual shutdown begins, or the plan ends | its task is removed: ABORTED |
//! | windows change; a period is over; something runs too long | a new plan |
//! | handover | the next plan takes over, if it is there |
//!
//! The manager decides by priorities alone. Limits of charge and data hold
//! because the plan keeps them: what the manager starts is what is planned, when
//! it is planned or, where tickets come late, before its start range closes.
//! Where the charge is lower than planned, what draws is removed at the hard
//! limit, and what is optional below the soft one.

mod adopt;
mod early;
mod guard;
mod handover;
mod heard;
mod keep;
mod told;

use core::fmt;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use faregate_scheduler::manager::Telecommand;
use faregate_scheduler::task::{Task, TaskId};

use super::generated::Numbers;
use super::{Misfit, Setting};
use crate::execute::Values;
use crate::plan::Activity;
use crate::problem::Unfit;
use crate::schedule::schedule;
use crate::state::{Mode, State};
use crate::timed::TimedPlan;
use crate::trace::Why;
use crate::units::{Span, Time};
use crate::{Plan, Problem};

/// Has a plan executed by the schedule manager.
#[derive(Clone, Debug)]
pub struct Director {
    setting: Setting,
    state: State,
    timed: TimedPlan,
    numbers: Numbers,
    /// Tasks that the manager has and that are not over, as they were given.
    live: BTreeMap<TaskId, Live>,
    /// Tasks that must not start yet.
    held: BTreeSet<TaskId>,
    wishes: BTreeSet<Why>,
    /// Tasks that were taken out before anybody knew that they had started.
    leaving: BTreeMap<TaskId, Live>,
    /// Tasks that can start before their planned start: since when.
    early: BTreeMap<TaskId, Time>,
    /// Something ended before its planned end, and what comes next may start.
    freed: bool,
    starts_early: bool,
    next_plan: NextPlan,
    planned_at: Time,
    /// When something is tried again that did not get what it needs.
    again_at: Option<Time>,
    period: Span,
    orders: Vec<Telecommand>,
    /// What was told to end, and has not.
    ending: BTreeSet<TaskId>,
    /// Estimates of the charge in a row below the soft limit.
    below_soft: u32,
    /// The hard limit was reached, and the charge has not recovered.
    spent: bool,
    /// Values of named timelines.
    named: Values,
}

/// A task that the manager has.
#[derive(Clone, Debug)]
struct Live {
    task: Task,
    /// When it can start at the latest.
    closes: Time,
    /// Whether an attempt has started.
    started: bool,
}

/// Where the plan that follows is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NextPlan {
    Expected,
    AskedFor,
    None,
}

/// Why there is no new plan.
#[derive(Clone, Debug)]
pub enum NotPlanned {
    /// Plan, parameters and state do not agree.
    Unfit(Vec<Unfit>),
    /// It cannot become tasks.
    Misfit(Vec<Misfit>),
}

impl Director {
    /// Executes a plan from this state. [`Director::turn`] makes the first timed
    /// plan.
    #[must_use]
    pub fn new(setting: Setting, state: State) -> Self {
        Self {
            numbers: Numbers::above(&setting.plan),
            named: Values::begin(&setting.plan, &setting.parameters, &state),
            ending: BTreeSet::new(),
            below_soft: 0,
            spent: false,
            leaving: BTreeMap::new(),
            early: BTreeMap::new(),
            freed: false,
            starts_early: true,
            next_plan: NextPlan::of(&setting.plan),
            planned_at: state.now,
            setting,
            state,
            timed: TimedPlan::default(),
            live: BTreeMap::new(),
            held: BTreeSet::new(),
            wishes: BTreeSet::from([Why::First]),
            again_at: None,
            period: Span::from_mins(30),
            orders: Vec::new(),
        }
    }

    /// A new plan is made at least this often while the computer is up; without
    /// this, each half hour.
    #[must_use]
    pub fn planning_every(self, period: Span) -> Self {
        Self { period, ..self }
    }

    /// Nothing starts before its planned start.
    #[must_use]
    pub fn never_early(self) -> Self {
        Self { starts_early: false, ..self }
    }

    /// Plans anew if that is wanted, and says what the manager is to be told.
    ///
    /// # Timing
    /// That of [`schedule`] where a new plan is wanted, else a look at what
    /// runs.
    ///
    /// # Errors
    /// [`NotPlanned`]: the present plan goes on. Where the manager is to be told
    /// something all the same, that comes first, and this with the next turn.
    pub fn turn(&mut self, now: Time) -> Result<Vec<Telecommand>, NotPlanned> {
        self.pass(now);
        self.look_at_the_time();
        self.give_up_early_starts();
        self.start_early();
        let made = if self.is_planning_time() { self.plan_anew() } else { Ok(()) };
        self.hold_and_let_go();
        // What must not start or go on is told whether there is a new plan or not.
        match made {
            Err(why) if self.orders.is_empty() => Err(why),
            _ => Ok(std::mem::take(&mut self.orders)),
        }
    }

    /// When to call [`Director::turn`], if nothing happens before.
    #[must_use]
    pub fn due(&self) -> Time {
        let periodic = self.planned_at.after(self.period);
        let late = self.state.running.iter();
        let late = late.map(|one| one.ends.max(self.looked_at_again()));
        let early = self.early.values().map(|since| self.early_until(*since));
        let handover = (self.next_plan == NextPlan::Expected).then_some(self.setting.plan.handover);
        let handover = handover.filter(|at| *at > self.state.now);
        let others = early.chain(handover).chain([periodic]).chain(self.again_at);
        let others = others.chain(self.last_end());
        late.chain(others).min().unwrap_or(periodic)
    }

    /// What is so now, as far as is known: what a plan is made from.
    #[must_use]
    pub const fn state(&self) -> &State {
        &self.state
    }

    /// The plan that is executed; after a handover the next one, with what runs
    /// of the one before.
    #[must_use]
    pub const fn plan(&self) -> &Arc<Plan> {
        &self.setting.plan
    }

    /// The timed plan that is executed.
    #[must_use]
    pub const fn timed(&self) -> &TimedPlan {
        &self.timed
    }

    /// Why a new plan is wanted, that was not made yet.
    pub fn wishes(&self) -> impl Iterator<Item = Why> {
        self.wishes.iter().copied()
    }

    fn wish(&mut self, why: Why) {
        self.wishes.insert(why);
    }

    /// Nobody plans in sleep; the first plan is made before, and one where the
    /// computer could not be woken as planned. Who is about to start early is
    /// planned around when it has started.
    fn is_planning_time(&self) -> bool {
        let could_not = self.again_at.is_some_and(|at| at <= self.state.now);
        let can = (self.state.mode == Mode::Awake || could_not) && self.early.is_empty();
        let is_over = self.state.now >= self.setting.plan.end;
        self.wishes.contains(&Why::First) || can && !is_over && !self.wishes.is_empty()
    }

    /// Time goes on: what runs changes timelines at its rates.
    fn pass(&mut self, now: Time) {
        self.named.pass(&self.setting.plan, &mut self.state, now);
    }

    fn look_at_the_time(&mut self) {
        let now = self.state.now;
        self.end_what_must_not_run();
        if now >= self.planned_at.after(self.period) || self.again_at.is_some_and(|at| at <= now) {
            self.wish(Why::Periodic);
        }
        if now < self.looked_at_again() {
            return;
        }
        // The computer stays up for what is paused, too.
        let too_long = self.state.running.iter().filter(|one| one.ends <= now);
        let too_long = too_long.map(|one| match one.paused {
            Some(_) => Why::Tickets(one.id),
            None => Why::Overran(one.id),
        });
        let too_long: Vec<_> = too_long.collect();
        too_long.into_iter().for_each(|why| self.wish(why));
    }

    /// What runs past its planned end is planned to end by then.
    fn looked_at_again(&self) -> Time {
        self.planned_at.after(self.setting.parameters.commit.max(Span::from_secs(1)))
    }

    fn plan_anew(&mut self) -> Result<(), NotPlanned> {
        let Setting { plan, parameters, .. } = &self.setting;
        let problem = Problem::new(plan, parameters, &self.state).map_err(NotPlanned::Unfit)?;
        let is_first = self.wishes.contains(&Why::First);
        let incumbent = (!is_first).then(|| self.incumbent());
        let timed = schedule(&problem, incumbent.as_ref());
        let made_room = self.wishes.iter().any(|why| early::makes_room(*why));
        self.adopt(timed).map_err(NotPlanned::Misfit)?;
        // What the new plan brings next may start, too.
        self.freed |= made_room;
        self.start_early();
        Ok(())
    }

    fn activity(&self, id: TaskId) -> Option<&Activity> {
        self.setting.plan.activities.iter().find(|one| one.id.get() == id.get())
    }
}

impl fmt::Display for NotPlanned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<_> = match self {
            Self::Unfit(all) => all.iter().map(ToString::to_string).collect(),
            Self::Misfit(all) => all.iter().map(ToString::to_string).collect(),
        };
        write!(f, "there is no new plan: {}", words.join("; "))
    }
}

impl core::error::Error for NotPlanned {}
