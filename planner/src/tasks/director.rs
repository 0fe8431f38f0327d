//! Has a plan executed by the schedule manager: hears what becomes of tasks,
//! keeps the state that plans are made from, says when a new one is wanted, and
//! turns it into telecommands.
//!
//! A state machine without clock or thread. Its host forwards each
//! [`Note`](faregate_scheduler::manager::Note) of the manager and what sensors
//! say, calls [`Director::turn`] at each of these and at [`Director::due`], and
//! gives the manager the telecommands that come out, in their order and before
//! its next decision.
//!
//! | what happens | what the director does |
//! |---|---|
//! | an activity starts, ends, fails, is missed | it runs, or has ended; if that is not as planned, a new plan |
//! | what cannot be paused loses its tickets | ABORTED: its task is removed, so that it does not run again; a new plan, with its cleanup |
//! | heating is taken | the zone is cold: a new plan heats it from scratch |
//! | a condition of what is planned does not hold | its task is held until it does |
//! | windows change; a period is over; something runs too long | a new plan |
//!
//! The manager decides by priorities alone. Limits of charge and data hold
//! because the plan keeps them: what the manager starts is what is planned, when
//! it is planned or, where tickets come late, before its start range closes.

mod adopt;
mod heard;
mod keep;

use core::fmt;
use std::collections::{BTreeMap, BTreeSet};

use faregate_scheduler::manager::Telecommand;
use faregate_scheduler::task::{Task, TaskId};
use faregate_tickets::amount::Microjoules;

use super::generated::Numbers;
use super::{Misfit, Setting};
use crate::Problem;
use crate::plan::{Activity, ActivityId};
use crate::problem::Unfit;
use crate::schedule::schedule;
use crate::state::{Mode, State, Window};
use crate::timed::TimedPlan;
use crate::trace::Why;
use crate::units::{Bytes, Span, Time};

/// Has a plan executed by the schedule manager.
#[derive(Clone, Debug)]
pub struct Director {
    setting: Setting,
    state: State,
    timed: TimedPlan,
    numbers: Numbers,
    /// Tasks that the manager has and that are not over, as they were given.
    live: BTreeMap<TaskId, Live>,
    /// Tasks that wait for a condition.
    held: BTreeSet<TaskId>,
    wishes: BTreeSet<Why>,
    begin: Time,
    /// What windows that are over have brought, or sent.
    exchanged: BTreeMap<(Time, String), Bytes>,
    planned_at: Time,
    /// When something is tried again that did not get what it needs.
    again_at: Option<Time>,
    period: Span,
    orders: Vec<Telecommand>,
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
            begin: state.now,
            exchanged: BTreeMap::new(),
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

    /// What the sensors say of the battery.
    pub fn charge(&mut self, charge: Microjoules) {
        self.state.charge = charge.min(self.state.capacity);
    }

    /// What an activity has really added to the data on board by now.
    pub fn data(&mut self, id: ActivityId, data: Bytes) {
        if let Some(running) = self.state.running.iter_mut().find(|one| one.id == id) {
            running.data = data;
        } else if let Some(ended) = self.state.ended.iter_mut().find(|one| one.id == id) {
            ended.data = data;
        }
    }

    /// The communication windows are these.
    pub fn windows(&mut self, windows: Vec<Window>) {
        if self.state.windows != windows {
            self.state.windows = windows;
            self.wish(Why::Windows);
        }
    }

    /// A variable's value; none: nobody knows it any more.
    pub fn variable(&mut self, name: &str, value: Option<i64>) {
        match value {
            Some(value) => self.state.variables.insert(name.to_owned(), value),
            None => self.state.variables.remove(name),
        };
        self.hold_and_let_go();
    }

    /// A zone is not warm, though it should be: it is heated anew.
    pub fn zone_is_cold(&mut self, zone: &str) {
        self.state.heating.remove(zone);
        if !self.state.cold.iter().any(|one| one == zone) {
            self.state.cold.push(zone.to_owned());
        }
        self.wish(Why::ZoneCold);
    }

    /// Plans anew if that is wanted, and says what the manager is to be told.
    ///
    /// # Timing
    /// That of [`schedule`] where a new plan is wanted, else a look at what
    /// runs.
    ///
    /// # Errors
    /// [`NotPlanned`]: the present plan goes on.
    pub fn turn(&mut self, now: Time) -> Result<Vec<Telecommand>, NotPlanned> {
        self.state.now = now;
        self.look_at_the_time();
        self.look_at_windows();
        let made = if self.is_planning_time() { self.plan_anew() } else { Ok(()) };
        made.map(|()| std::mem::take(&mut self.orders))
    }

    /// When to call [`Director::turn`], if nothing happens before.
    #[must_use]
    pub fn due(&self) -> Time {
        let periodic = self.planned_at.after(self.period);
        let late = self.state.running.iter().filter(|one| one.paused.is_none());
        let late = late.map(|one| one.ends.max(self.looked_at_again()));
        late.chain([periodic]).chain(self.again_at).min().unwrap_or(periodic)
    }

    /// What is so now, as far as is known: what a plan is made from.
    #[must_use]
    pub const fn state(&self) -> &State {
        &self.state
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

    /// Nobody plans in sleep; the first plan is made before.
    fn is_planning_time(&self) -> bool {
        self.wishes.contains(&Why::First)
            || self.state.mode == Mode::Awake && !self.wishes.is_empty()
    }

    fn look_at_the_time(&mut self) {
        let now = self.state.now;
        if now >= self.planned_at.after(self.period) || self.again_at.is_some_and(|at| at <= now) {
            self.wish(Why::Periodic);
        }
        if now < self.looked_at_again() {
            return;
        }
        let running = self.state.running.iter();
        let too_long = running.filter(|one| one.paused.is_none() && one.ends <= now);
        let too_long: Vec<_> = too_long.map(|one| one.id).collect();
        too_long.into_iter().for_each(|id| self.wish(Why::Overran(id)));
    }

    /// What runs past its planned end is planned to end by then.
    fn looked_at_again(&self) -> Time {
        self.planned_at.after(self.setting.parameters.commit.max(Span::from_secs(1)))
    }

    fn plan_anew(&mut self) -> Result<(), NotPlanned> {
        let Setting { plan, parameters, .. } = &self.setting;
        let problem = Problem::new(plan, parameters, &self.known()).map_err(NotPlanned::Unfit)?;
        let is_first = self.wishes.contains(&Why::First);
        let incumbent = (!is_first).then(|| self.incumbent());
        let timed = schedule(&problem, incumbent.as_ref());
        self.adopt(timed).map_err(NotPlanned::Misfit)
    }

    fn look_at_windows(&mut self) {
        let (begin, now) = (self.begin, self.state.now);
        let over = self.state.windows.iter().filter(|one| begin < one.end && one.end <= now);
        for window in over {
            self.exchanged.insert((window.end, window.name.clone()), window.data);
        }
    }

    /// The state as the planner counts data: what was sent is on board no more.
    /// A window that is over counts nothing there, and only the sum of what has
    /// ended does.
    fn known(&self) -> State {
        let mut state = self.state.clone();
        if let Some(ended) = state.ended.first_mut() {
            let all = self.exchanged.values().map(|data| data.get());
            ended.data = Bytes::new(all.fold(ended.data.get(), i64::saturating_add));
        }
        state
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
