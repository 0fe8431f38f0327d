//! Executions in which all goes as planned, and what can be wrong with them.

use faregate_agents::Categories;
use faregate_checker::{Rule, Violation, check_trace};
use faregate_planner::plan::{Condition, Kind, Outcome, Variable};
use faregate_planner::state::Mode;
use faregate_planner::timed::{Fate, Slot};
use faregate_planner::trace::{
    Cause, Dispatch, Entry, Happened, Trace, Truth, Unstarted, Why, ZoneSeen,
};
use faregate_planner::units::{Bytes, Span, Time};
use faregate_planner::{Activity, ActivityId, Problem, TimedPlan, schedule};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::brute::seeds;
use crate::worlds::{TINY, World, world};

/// An execution, and what it is held against.
#[derive(Clone, Debug)]
pub(crate) struct Execution {
    pub(crate) world: World,
    pub(crate) trace: Trace,
}

/// Something that goes wrong: false where there is nothing that could.
pub(crate) type Change = fn(&mut Execution) -> bool;

const MS: Span = Span::new(1);

#[test]
fn an_execution_as_planned_keeps_every_rule() {
    let mut dispatched = 0;
    for seed in 0..seeds(1_000) {
        let Some(execution) = execution(seed) else { continue };
        let wrong = execution.wrong();
        assert_eq!(wrong, [], "seed {seed}: {:#?}", execution.trace.entries);
        dispatched += execution.dispatched().len();
    }
    println!("{dispatched} dispatched");
    assert!(dispatched > 1_000, "{dispatched}");
}

/// What the checker says of an execution in which this goes wrong.
pub(crate) fn changed(seed: u64, change: Change) -> Vec<Violation> {
    let Some(mut execution) = execution(seed) else { return Vec::new() };
    if !change(&mut execution) {
        return Vec::new();
    }
    execution.wrong()
}

/// The plan of a world, executed as it stands.
fn execution(seed: u64) -> Option<Execution> {
    let world = world(seed, TINY);
    // One that should be over already would have to be aborted.
    if world.state.running.iter().any(|r| r.ends <= world.state.now || r.paused.is_some()) {
        return None;
    }
    let problem = Problem::new(&world.plan, &world.parameters, &world.state).ok()?;
    let timed = schedule(&problem, None);
    let mut entries = vec![first(&world, &timed), truth(&world)];
    entries.extend(modes(&timed));
    entries.extend(windows(&world));
    for (row, activity) in timed.rows.iter().zip(&world.plan.activities) {
        let manual = matches!(activity.kind, Kind::ManualShutdown { .. });
        match row.fate {
            _ if manual => {}
            Fate::Scheduled(slot) => {
                entries.push(dispatch(activity, slot));
                entries.push(ended(activity, slot.end));
            }
            Fate::Running(slot) => entries.push(ended(activity, slot.end)),
            Fate::Out(_) => {
                let what = Happened::NotStarted { id: row.id, why: Unstarted::RangeClosed };
                entries.push(Entry { at: world.plan.end, what });
            }
            Fate::Ended(_) => {}
        }
    }
    entries.sort_by_key(|entry| (entry.at, rank(&entry.what)));
    let trace = Trace {
        begin: world.state.now,
        end: world.plan.end,
        windows: world.state.windows.clone(),
        entries,
        ..Trace::default()
    };
    Some(Execution { world, trace })
}

/// Of what happens at one instant, ends come before starts.
fn rank(what: &Happened) -> u8 {
    match what {
        Happened::Planned { .. } => 0,
        Happened::Ended { .. } | Happened::Window { open: false, .. } => 1,
        Happened::Mode(_) => 2,
        Happened::Window { .. } | Happened::NotStarted { .. } | Happened::Truth(_) => 3,
        _ => 4,
    }
}

fn first(world: &World, timed: &TimedPlan) -> Entry {
    let (state, timed) = (Box::new(world.state.clone()), Box::new(timed.clone()));
    Entry { at: world.state.now, what: Happened::Planned { why: vec![Why::First], state, timed } }
}

fn truth(world: &World) -> Entry {
    let charge = world.state.capacity;
    let (load, peak) = (Milliwatts::ZERO, Milliwatts::ZERO);
    let truth = Truth { charge, load, peak, engines: 0, data: Bytes::ZERO };
    Entry { at: world.state.now, what: Happened::Truth(truth) }
}

fn modes(timed: &TimedPlan) -> Vec<Entry> {
    let of = |at, mode| Entry { at, what: Happened::Mode(mode) };
    let phases = timed.awake.iter().flat_map(|phase| {
        let waking = (phase.wakeup < phase.up).then(|| of(phase.wakeup, Mode::WakingUp));
        let down = (phase.down < phase.asleep).then(|| of(phase.down, Mode::ShuttingDown));
        let asleep = of(phase.asleep, Mode::Asleep);
        waking.into_iter().chain([of(phase.up, Mode::Awake)]).chain(down).chain([asleep])
    });
    phases.collect()
}

fn windows(world: &World) -> Vec<Entry> {
    let all = world.state.windows.iter().enumerate().filter(|(_, w)| w.end <= world.plan.end);
    let opens = all.flat_map(|(index, window)| {
        let of = |at, open| Entry { at, what: Happened::Window { index, open } };
        [of(window.start, true), of(window.end, false)]
    });
    opens.collect()
}

fn dispatch(activity: &Activity, slot: Slot) -> Entry {
    let zones = activity.zones.iter().map(|zone| ZoneSeen {
        zone: zone.clone(),
        ok: true,
        truly: 1_000,
        needed: 900,
        margin: 50,
    });
    let dispatch = Dispatch {
        id: activity.id,
        range: slot.range,
        ends: slot.end,
        early: false,
        zones: zones.collect(),
        variables: Vec::new(),
    };
    Entry { at: slot.start, what: Happened::Dispatched(Box::new(dispatch)) }
}

fn ended(activity: &Activity, at: Time) -> Entry {
    let (id, outcome, data) = (activity.id, Outcome::Succeeded, activity.data);
    Entry { at, what: Happened::Ended { id, outcome, data } }
}

impl Execution {
    fn wrong(&self) -> Vec<Violation> {
        check_trace(&self.world.plan, &self.world.parameters, &self.trace)
    }

    /// Who was dispatched, and when it ended.
    fn dispatched(&self) -> Vec<(ActivityId, Slot)> {
        let dispatches = self.trace.entries.iter().filter_map(|entry| match &entry.what {
            Happened::Dispatched(d) => {
                let (start, end, range) = (entry.at, d.ends, d.range);
                Some((d.id, Slot { start, end, range }))
            }
            _ => None,
        });
        dispatches.collect()
    }

    fn activity(&mut self, id: ActivityId) -> &mut Activity {
        let mut all = self.world.plan.activities.iter_mut();
        all.find(|activity| activity.id == id).expect("it was dispatched")
    }

    /// The first that was dispatched, and of which this is true.
    fn find(&mut self, which: impl Fn(&Activity) -> bool) -> Option<(ActivityId, Slot)> {
        let all = self.dispatched();
        all.into_iter().find(|(id, slot)| slot.length() > MS && which(self.activity(*id)))
    }

    fn dispatch_of(&mut self, id: ActivityId) -> &mut Dispatch {
        let mut entries = self.trace.entries.iter_mut();
        let found = entries.find_map(|entry| match &mut entry.what {
            Happened::Dispatched(dispatch) if dispatch.id == id => Some(&mut **dispatch),
            _ => None,
        });
        found.expect("it was dispatched")
    }

    fn end_of(&mut self, id: ActivityId) -> usize {
        let is =
            |entry: &Entry| matches!(entry.what, Happened::Ended { id: ended, .. } if ended == id);
        self.trace.entries.iter().position(is).expect("it ended")
    }

    fn insert(&mut self, at: Time, what: Happened) {
        let after = self.trace.entries.partition_point(|entry| entry.at <= at);
        self.trace.entries.insert(after, Entry { at, what });
    }

    fn truth_of(&mut self, at: Time, charge: Microjoules, peak: Milliwatts) {
        let (load, data) = (Milliwatts::ZERO, Bytes::ZERO);
        self.insert(at, Happened::Truth(Truth { charge, load, peak, engines: 0, data }));
    }

    /// It is aborted instead of ending, with what comes of that.
    fn abort(&mut self, cause: Cause, revoked: bool, safed: bool) -> bool {
        let Some((id, slot)) = self.find(|_| true) else { return false };
        let place = self.end_of(id);
        let at = slot.end.before(MS);
        self.trace.entries.remove(place);
        self.insert(at, Happened::Aborted { id, cause, data: Bytes::ZERO });
        if revoked {
            self.insert(at, Happened::Revoked(id));
        }
        if safed {
            self.insert(at, Happened::Safed(id));
        }
        true
    }
}

pub(crate) fn before_its_range(e: &mut Execution) -> bool {
    let Some((id, slot)) = e.find(|_| true) else { return false };
    e.activity(id).starts[slot.range].from = slot.start.after(MS);
    true
}

pub(crate) fn prior_fails(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|activity| !activity.after.is_empty()) else { return false };
    let prior = e.activity(id).after[0].prior;
    let ends = e.trace.entries.iter_mut().find_map(|entry| match &mut entry.what {
        Happened::Ended { id, outcome, .. } if *id == prior => Some(outcome),
        _ => None,
    });
    ends.map(|outcome| *outcome = Outcome::Failed).is_some()
}

pub(crate) fn cold(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|activity| !activity.zones.is_empty()) else { return false };
    e.dispatch_of(id).zones[0].ok = false;
    true
}

pub(crate) fn truly_cold(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|activity| !activity.zones.is_empty()) else { return false };
    let zone = &mut e.dispatch_of(id).zones[0];
    zone.truly = zone.needed - zone.margin - 1;
    true
}

pub(crate) fn unknown(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|_| true) else { return false };
    let condition = Condition { kind: Variable::Ddi, name: "arm stowed".into(), min: 1, max: 1 };
    e.activity(id).conditions.push(condition);
    true
}

pub(crate) fn goes_down(e: &mut Execution) -> bool {
    let Some((_, slot)) = e.find(|_| true) else { return false };
    e.insert(slot.start, Happened::Mode(Mode::ShuttingDown));
    true
}

/// Two that run at the same time.
fn together(e: &Execution) -> Option<(ActivityId, ActivityId)> {
    let all = e.dispatched();
    let pairs = all.iter().flat_map(|a| all.iter().map(move |b| (a, b)));
    let mut both = pairs.filter(|((a, x), (b, y))| a != b && x.start < y.end && y.start < x.end);
    both.next().map(|((a, _), (b, _))| (*a, *b))
}

pub(crate) fn shares_bits(e: &mut Execution) -> bool {
    let Some((a, b)) = together(e) else { return false };
    for id in [a, b] {
        e.activity(id).resources = Categories::from_mask(1 << 100);
    }
    true
}

pub(crate) fn too_many_engines(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|activity| activity.engines > 0) else { return false };
    e.world.parameters.engines = e.activity(id).engines - 1;
    true
}

pub(crate) fn too_much_peak(e: &mut Execution) -> bool {
    let Some((_, slot)) = e.find(|_| true) else { return false };
    let peak = e.world.parameters.peak_limit.saturating_add(Milliwatts::new(1));
    e.truth_of(slot.start, e.world.state.capacity, peak);
    true
}

pub(crate) fn past_cutoff(e: &mut Execution) -> bool {
    let Some((id, slot)) = e.find(|_| true) else { return false };
    e.activity(id).starts[slot.range].cutoff = slot.end.before(MS);
    true
}

pub(crate) fn below_hard(e: &mut Execution) -> bool {
    let Some((_, slot)) = e.find(|activity| !activity.marginal.is_zero()) else { return false };
    e.insert(slot.start, Happened::Estimate { charge: Microjoules::ZERO });
    true
}

pub(crate) fn truly_below_hard(e: &mut Execution) -> bool {
    let Some((_, slot)) = e.find(|activity| !activity.marginal.is_zero()) else { return false };
    let (lag, empty) = (Span::new(1), Microjoules::ZERO);
    e.trace.charge_lag = lag;
    e.truth_of(slot.start, empty, Milliwatts::ZERO);
    e.truth_of(slot.end, empty, Milliwatts::ZERO);
    true
}

pub(crate) fn below_soft(e: &mut Execution) -> bool {
    let from = e.world.parameters.mandatory_from;
    let optional = |a: &Activity| a.priority < from && !a.marginal.is_zero();
    let Some((_, slot)) = e.find(optional) else { return false };
    let p = &e.world.parameters;
    let between = i128::from(p.soft_min_soc.get() + p.hard_min_soc.get()) / 2;
    let charge = between * i128::from(e.world.state.capacity.get()) / 1_000_000;
    let charge = Microjoules::new(u64::try_from(charge).expect("a charge"));
    e.insert(slot.start, Happened::Estimate { charge });
    true
}

pub(crate) fn past_duration(e: &mut Execution) -> bool {
    let from = e.world.parameters.mandatory_from;
    let fixed = |a: &Activity| a.priority < from && a.kind == Kind::Generic;
    let Some((id, slot)) = e.find(fixed) else { return false };
    e.dispatch_of(id).ends = slot.end.before(MS);
    true
}

pub(crate) fn aborted_for_nothing(e: &mut Execution) -> bool {
    e.abort(Cause::Cutoff, true, true)
}

pub(crate) fn not_revoked(e: &mut Execution) -> bool {
    e.abort(Cause::Ordered, false, true)
}

pub(crate) fn not_safed(e: &mut Execution) -> bool {
    e.abort(Cause::Ordered, true, false)
}

#[test]
fn an_ordered_abort_that_is_revoked_and_made_safe_is_right() {
    let mut aborted = 0;
    for seed in 0..300 {
        let Some(mut execution) = execution(seed) else { continue };
        let applies = execution.abort(Cause::Ordered, true, true);
        // What depended on it is another matter.
        let wrong = execution.wrong();
        assert!(wrong.iter().all(|v| v.rule == Rule::DispatchedAfter), "seed {seed}: {wrong:?}");
        aborted += usize::from(applies);
    }
    assert!(aborted > 100, "{aborted}");
}

pub(crate) fn paused(e: &mut Execution) -> bool {
    let Some((id, slot)) = e.find(|activity| !activity.pausable) else { return false };
    e.insert(slot.start, Happened::Paused(id));
    e.insert(slot.start, Happened::Resumed(id));
    true
}

pub(crate) fn cleans_up(e: &mut Execution) -> bool {
    let waits = |a: &Activity| !a.after.is_empty() && a.kind == Kind::Generic;
    let Some((id, _)) = e.find(waits) else { return false };
    e.activity(id).kind = Kind::Cleanup;
    true
}

pub(crate) fn two_of_a_group(e: &mut Execution) -> bool {
    let all = e.dispatched();
    for (id, _) in all.iter().take(2) {
        e.activity(*id).group = Some("one of us".into());
    }
    all.len() > 1
}

pub(crate) fn recommitted(e: &mut Execution) -> bool {
    let Happened::Planned { state, timed, why } = e.trace.entries[0].what.clone() else {
        return false;
    };
    let until = state.now.after(e.world.parameters.commit);
    let mut later = timed.clone();
    let slot = later.rows.iter_mut().find_map(|row| match &mut row.fate {
        Fate::Scheduled(slot) if slot.start < until => Some(slot),
        _ => None,
    });
    let Some(slot) = slot else { return false };
    (slot.start, slot.end) = (slot.start.after(MS), slot.end.after(MS));
    let what = Happened::Planned { state, timed: later, why };
    e.trace.entries.insert(1, Entry { at: e.trace.begin, what });
    true
}

pub(crate) fn out_of_order(e: &mut Execution) -> bool {
    let Some(last) = e.trace.entries.last_mut() else { return false };
    let before = last.at;
    last.at = e.trace.begin.before(MS);
    before > e.trace.begin
}

pub(crate) fn loses_one(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|_| true) else { return false };
    let place = e.end_of(id);
    e.trace.entries.remove(place);
    true
}

pub(crate) fn twice(e: &mut Execution) -> bool {
    let Some((id, slot)) = e.find(|_| true) else { return false };
    let again = e.dispatch_of(id).clone();
    e.insert(slot.end, Happened::Dispatched(Box::new(again)));
    true
}
