//! What became of a plan: an execution is gone through entry by entry, and each
//! is held against what was so by then.

mod aborts;
mod charge;
mod dispatch;
mod early;
mod fates;
mod handover;
mod named;
mod physics;
mod plans;
mod sleeps;

use std::collections::BTreeMap;

use faregate_planner::plan::{Activity, ActivityId, Kind, Outcome};
use faregate_planner::state::Mode;
use faregate_planner::trace::{Entry, Happened, Trace};
use faregate_planner::units::Time;
use faregate_planner::{Parameters, Plan};

use crate::violation::{Rule, Violation};

/// What is wrong with an execution: nothing, if planner and control thread are
/// right.
///
/// What the control thread cannot know at once is judged by what it was told,
/// and by the truth after the time that it takes to be told: the truth about
/// charge counts by more than the noise of its estimate and after the lag, a
/// zone's by more than the margin that the trace gives with it.
#[must_use]
pub fn check_trace(plan: &Plan, parameters: &Parameters, trace: &Trace) -> Vec<Violation> {
    let mut walk = Walk::new(plan, parameters, trace);
    for entry in &trace.entries {
        walk.enter(entry);
    }
    walk.close();
    let mut all = walk.wrong;
    all.extend(charge::check(plan, parameters, trace));
    all.extend(aborts::check(parameters, trace));
    all.extend(plans::check(plan, parameters, trace));
    all.extend(handover::check(plan, trace));
    all.extend(physics::check(plan, parameters, trace));
    all.extend(sleeps::check(plan, parameters, trace));
    all.extend(early::check(plan, parameters, trace));
    all.extend(named::check(plan, parameters, trace));
    all.sort_by_key(|violation| (violation.at, violation.rule));
    all
}

/// An activity that runs, or is paused.
#[derive(Clone, Copy, Debug)]
struct Runs {
    cutoff: i64,
    /// When it should be over, if it is not paused any more.
    ends: i64,
    paused: Option<i64>,
}

/// What is so after the entries so far.
struct Walk<'a> {
    plan: &'a Plan,
    parameters: &'a Parameters,
    trace: &'a Trace,
    now: i64,
    mode: Mode,
    runs: BTreeMap<ActivityId, Runs>,
    started: Vec<ActivityId>,
    over: BTreeMap<ActivityId, Outcome>,
    /// Open communication windows, by their place.
    windows: Vec<usize>,
    variables: BTreeMap<String, i64>,
    /// The last estimates of the charge, the latest last.
    estimates: Vec<i128>,
    /// Estimates in a row below the soft limit.
    below_soft: u32,
    /// When the charge was estimated last.
    estimated_at: i64,
    wrong: Vec<Violation>,
}

impl<'a> Walk<'a> {
    fn new(plan: &'a Plan, parameters: &'a Parameters, trace: &'a Trace) -> Self {
        let mut walk = Self {
            plan,
            parameters,
            trace,
            now: trace.begin.get(),
            mode: Mode::Asleep,
            runs: BTreeMap::new(),
            started: Vec::new(),
            over: BTreeMap::new(),
            windows: Vec::new(),
            variables: BTreeMap::new(),
            estimates: Vec::new(),
            below_soft: 0,
            estimated_at: trace.begin.get(),
            wrong: Vec::new(),
        };
        if let Some(Happened::Planned { state, .. }) = trace.entries.first().map(|e| &e.what) {
            walk.begin(state);
        }
        walk
    }

    /// What the first plan was made from.
    fn begin(&mut self, state: &faregate_planner::State) {
        self.mode = state.mode;
        self.variables.clone_from(&state.variables);
        for running in &state.running {
            self.started.push(running.id);
            let (cutoff, ends) = (running.cutoff.get(), running.ends.get());
            let paused = running.paused.map(Time::get);
            self.runs.insert(running.id, Runs { cutoff, ends, paused });
        }
        for ended in &state.ended {
            self.over.insert(ended.id, ended.outcome);
            self.started.extend(ended.started.map(|_| ended.id));
        }
        let now = state.now;
        let open = |w: &faregate_planner::state::Window| w.start < now && now < w.end;
        let windows = self.trace.windows.iter().enumerate();
        self.windows = windows.filter(|(_, w)| open(w)).map(|(index, _)| index).collect();
    }

    fn activity(&self, id: ActivityId) -> Option<&'a Activity> {
        self.plan.activities.iter().find(|activity| activity.id == id)
    }

    fn is_optional(&self, id: ActivityId) -> bool {
        self.activity(id).is_some_and(|a| a.priority < self.parameters.mandatory_from)
    }

    fn say(&mut self, violation: Violation) {
        self.wrong.push(violation);
    }

    fn blame(&mut self, rule: Rule, id: ActivityId, detail: &str) {
        let violation = Violation::new(rule, Some(id), self.now).detail(detail);
        self.say(violation);
    }

    fn enter(&mut self, entry: &'a Entry) {
        if entry.at.get() < self.now {
            self.say(Violation::new(Rule::InOrder, None, entry.at.get()));
        }
        self.pass(entry.at.get());
        match &entry.what {
            Happened::Dispatched(dispatch) => self.dispatched(dispatch),
            Happened::Ended { id, outcome, .. } => self.ends(*id, *outcome),
            Happened::Aborted { id, cause, .. } => self.aborted(*id, *cause),
            Happened::NotStarted { id, .. } => self.not_started(*id),
            Happened::Paused(id) => self.paused(*id),
            Happened::Resumed(id) => self.resumed(*id),
            Happened::Mode(mode) => self.mode(*mode),
            Happened::Window { index, open: true } => self.windows.push(*index),
            Happened::Window { index, open: false } => self.windows.retain(|w| w != index),
            Happened::Variable { name, value: Some(value) } => {
                self.variables.insert(name.clone(), *value);
            }
            Happened::Variable { name, value: None } => {
                self.variables.remove(name);
            }
            Happened::Estimate { charge } => self.estimate(charge.get().into()),
            Happened::Truth(truth) => self.truth(truth),
            Happened::HandedOver(next) => self.handed_over(next),
            Happened::Planned { .. }
            | Happened::Pushed { .. }
            | Happened::Requested(_)
            | Happened::ToldToEnd(_)
            | Happened::Revoked(_)
            | Happened::Safed(_)
            | Happened::Heater { .. }
            | Happened::Leak(_)
            | Happened::Lost(_)
            | Happened::NoNextPlan(_) => {}
        }
    }

    /// Time goes on to `at`: what should have been over by now?
    fn pass(&mut self, at: i64) {
        let late: Vec<Violation> = self
            .runs
            .iter()
            .flat_map(|(id, runs)| [self.late(*id, runs, at), self.blind(*id, runs, at)])
            .flatten()
            .collect();
        for violation in late {
            let said =
                |known: &Violation| known.rule == violation.rule && known.who == violation.who;
            if !self.wrong.iter().any(said) {
                self.wrong.push(violation);
            }
        }
        self.now = self.now.max(at);
    }

    fn late(&self, id: ActivityId, runs: &Runs, at: i64) -> Option<Violation> {
        let who = Some(id);
        if at > runs.cutoff {
            let violation = Violation::new(Rule::RanPastCutoff, who, runs.cutoff);
            return Some(violation.by(at - runs.cutoff));
        }
        let grace = match self.activity(id)?.kind {
            Kind::Expanding { .. } => self.parameters.expansion_grace.get(),
            _ => 0,
        };
        let until = runs.ends + grace;
        let past = at > until && runs.paused.is_none() && self.is_optional(id);
        let violation = Violation::new(Rule::RanPastDuration, who, until);
        past.then(|| violation.by(at - until))
    }

    /// Draws power although no estimate has come for longer than one is believed.
    fn blind(&self, id: ActivityId, runs: &Runs, at: i64) -> Option<Violation> {
        let until = self.estimated_at.saturating_add(self.trace.charge_holds?.get());
        let draws = runs.paused.is_none() && !self.activity(id)?.marginal.is_zero();
        // What goes on and is aborted at one instant has not run.
        let from = until.max(self.now);
        let violation = Violation::new(Rule::RanBlind, Some(id), from);
        (draws && at > from).then(|| violation.by(at - from))
    }

    fn paused(&mut self, id: ActivityId) {
        if !self.activity(id).is_some_and(|activity| activity.pausable) {
            self.blame(Rule::Paused, id, "");
        }
        let now = self.now;
        match self.runs.get_mut(&id) {
            Some(runs) if runs.paused.is_none() => runs.paused = Some(now),
            _ => self.blame(Rule::Paused, id, "it did not run"),
        }
    }

    fn resumed(&mut self, id: ActivityId) {
        let now = self.now;
        match self.runs.get_mut(&id) {
            Some(Runs { ends, paused, .. }) if paused.is_some() => {
                *ends += now - paused.take().unwrap_or(now);
            }
            _ => self.blame(Rule::Paused, id, "resumed although it was not paused"),
        }
    }

    /// What runs needs the computer.
    fn mode(&mut self, mode: Mode) {
        self.mode = mode;
        let working: Vec<ActivityId> =
            self.runs.iter().filter(|(_, runs)| runs.paused.is_none()).map(|(id, _)| *id).collect();
        for id in working {
            if mode != Mode::Awake {
                self.blame(Rule::DispatchedAwake, id, "the computer goes down");
            }
        }
    }
}
