//! Executions in which all goes as planned, and what can be wrong with them.

pub(crate) mod changes;
pub(crate) mod physics;

use faregate_checker::{Rule, Violation, check_trace};
use faregate_planner::plan::{Kind, Outcome};
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

pub(super) const MS: Span = Span::new(1);

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
    let mut entries = vec![first(&world, &timed), truth(&world, &timed)];
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

/// What the computer draws then; nothing else is exact.
fn truth(world: &World, timed: &TimedPlan) -> Entry {
    let (now, p) = (world.state.now, &world.parameters);
    let mut begun = modes(timed).into_iter().filter(|entry| entry.at <= now);
    let mode = begun.next_back().map_or(world.state.mode, |entry| match entry.what {
        Happened::Mode(mode) => mode,
        _ => world.state.mode,
    });
    let load = match mode {
        Mode::Asleep => Milliwatts::ZERO,
        Mode::WakingUp => p.wakeup.load.marginal,
        Mode::Awake => p.awake.marginal,
        Mode::ShuttingDown => p.shutdown.load.marginal,
    };
    let open = world.state.windows.iter().filter(|w| w.start <= now && now < w.end);
    let load = open.fold(load, |load, window| load.saturating_add(window.marginal));
    let (charge, peak) = (world.state.capacity, Milliwatts::ZERO);
    let truth = Truth { charge, load, peak, engines: 0, data: Bytes::ZERO };
    Entry { at: now, what: Happened::Truth(truth) }
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
    let all = world.state.windows.iter().enumerate();
    let now = world.state.now;
    let all = all.filter(|(_, w)| now < w.end && w.end <= world.plan.end);
    let opens = all.flat_map(|(index, window)| {
        let of = |at, open| Entry { at, what: Happened::Window { index, open } };
        [of(window.start, true), of(window.end, false)]
    });
    // What is over by now, or open, is not recorded as new.
    opens.filter(|entry| world.state.now <= entry.at).collect()
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
    pub(super) fn wrong(&self) -> Vec<Violation> {
        check_trace(&self.world.plan, &self.world.parameters, &self.trace)
    }

    /// Who was dispatched, and when it ended.
    pub(super) fn dispatched(&self) -> Vec<(ActivityId, Slot)> {
        let dispatches = self.trace.entries.iter().filter_map(|entry| match &entry.what {
            Happened::Dispatched(d) => {
                let (start, end, range) = (entry.at, d.ends, d.range);
                Some((d.id, Slot { start, end, range }))
            }
            _ => None,
        });
        dispatches.collect()
    }

    pub(super) fn activity(&mut self, id: ActivityId) -> &mut Activity {
        let mut all = self.world.plan.activities.iter_mut();
        all.find(|activity| activity.id == id).expect("it was dispatched")
    }

    /// The first that was dispatched, and of which this is true.
    pub(super) fn find(&mut self, which: impl Fn(&Activity) -> bool) -> Option<(ActivityId, Slot)> {
        let all = self.dispatched();
        all.into_iter().find(|(id, slot)| slot.length() > MS && which(self.activity(*id)))
    }

    pub(super) fn dispatch_of(&mut self, id: ActivityId) -> &mut Dispatch {
        let mut entries = self.trace.entries.iter_mut();
        let found = entries.find_map(|entry| match &mut entry.what {
            Happened::Dispatched(dispatch) if dispatch.id == id => Some(&mut **dispatch),
            _ => None,
        });
        found.expect("it was dispatched")
    }

    pub(super) fn end_of(&mut self, id: ActivityId) -> usize {
        let is =
            |entry: &Entry| matches!(entry.what, Happened::Ended { id: ended, .. } if ended == id);
        self.trace.entries.iter().position(is).expect("it ended")
    }

    pub(super) fn insert(&mut self, at: Time, what: Happened) {
        let after = self.trace.entries.partition_point(|entry| entry.at <= at);
        self.trace.entries.insert(after, Entry { at, what });
    }

    pub(super) fn truth_of(&mut self, at: Time, charge: Microjoules, peak: Milliwatts) {
        let (load, data) = (Milliwatts::ZERO, Bytes::ZERO);
        self.insert(at, Happened::Truth(Truth { charge, load, peak, engines: 0, data }));
    }

    /// It is aborted instead of ending, with what comes of that.
    pub(super) fn abort(&mut self, cause: Cause, revoked: bool, safed: bool) -> bool {
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
