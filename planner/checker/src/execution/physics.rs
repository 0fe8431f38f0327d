//! The truth about load, charge and data: it follows from what was commanded,
//! and from what happened by itself.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use faregate_planner::parameters::Load;
use faregate_planner::plan::ActivityId;
use faregate_planner::state::Mode;
use faregate_planner::trace::{Happened, Trace, Truth};
use faregate_planner::{Parameters, Plan};

use super::charge::capacity;
use crate::violation::{Rule, Violation};

/// How things stand after the entries so far.
struct Physics<'a> {
    plan: &'a Plan,
    parameters: &'a Parameters,
    trace: &'a Trace,
    capacity: i128,
    mode: Mode,
    heaters: BTreeSet<&'a str>,
    windows: BTreeSet<usize>,
    working: BTreeSet<ActivityId>,
    paused: BTreeSet<ActivityId>,
    leak: i128,
    /// The charge as it must be, and the load since then.
    charge: Option<(i64, i128, i128)>,
    /// What was made and sent by what is over.
    data: i128,
    /// What each run will have made when it is over, the next one first.
    makes: BTreeMap<ActivityId, VecDeque<i128>>,
    wrong: Vec<Violation>,
}

pub(super) fn check(plan: &Plan, parameters: &Parameters, trace: &Trace) -> Vec<Violation> {
    let Some(capacity) = capacity(trace) else { return Vec::new() };
    let mut physics = Physics {
        plan,
        parameters,
        trace,
        capacity,
        mode: Mode::Asleep,
        heaters: BTreeSet::new(),
        windows: BTreeSet::new(),
        working: BTreeSet::new(),
        paused: BTreeSet::new(),
        leak: 0,
        charge: None,
        data: 0,
        makes: makes(trace),
        wrong: Vec::new(),
    };
    physics.begin();
    for entry in &trace.entries {
        physics.enter(entry.at.get(), &entry.what);
    }
    physics.wrong
}

fn makes(trace: &Trace) -> BTreeMap<ActivityId, VecDeque<i128>> {
    let mut makes: BTreeMap<_, VecDeque<_>> = BTreeMap::new();
    for entry in &trace.entries {
        if let Happened::Ended { id, data, .. } | Happened::Aborted { id, data, .. } = &entry.what {
            makes.entry(*id).or_default().push_back(i128::from(data.get()));
        }
    }
    makes
}

impl<'a> Physics<'a> {
    fn begin(&mut self) {
        let first = self.trace.entries.first().map(|entry| &entry.what);
        let Some(Happened::Planned { state, .. }) = first else { return };
        self.mode = state.mode;
        for running in &state.running {
            let to = if running.paused.is_none() { &mut self.working } else { &mut self.paused };
            to.insert(running.id);
        }
        let open = |w: &faregate_planner::state::Window| w.start < state.now && state.now < w.end;
        let windows = self.trace.windows.iter().enumerate();
        self.windows.extend(windows.filter(|(_, window)| open(window)).map(|(index, _)| index));
    }

    fn enter(&mut self, at: i64, what: &'a Happened) {
        match what {
            Happened::Dispatched(dispatch) => {
                self.working.insert(dispatch.id);
            }
            Happened::Ended { id, .. } | Happened::Aborted { id, .. } => self.ends(*id),
            Happened::Paused(id) => {
                self.working.remove(id);
                self.paused.insert(*id);
            }
            Happened::Resumed(id) => {
                self.paused.remove(id);
                self.working.insert(*id);
            }
            Happened::Heater { zone, on: true } => {
                self.heaters.insert(zone);
            }
            Happened::Heater { zone, on: false } => {
                self.heaters.remove(zone.as_str());
            }
            Happened::Mode(mode) => self.mode = *mode,
            Happened::Window { index, open } => self.window(*index, *open),
            Happened::Leak(load) => self.leak = load.get().into(),
            Happened::Lost(energy) => self.lost(at, energy.get().into()),
            Happened::HandedOver(next) => self.plan = next,
            Happened::Truth(truth) => self.truth(at, truth),
            _ => {}
        }
    }

    fn ends(&mut self, id: ActivityId) {
        self.working.remove(&id);
        self.paused.remove(&id);
        let made = self.makes.get_mut(&id).and_then(VecDeque::pop_front);
        self.data += made.unwrap_or(0);
    }

    fn window(&mut self, index: usize, open: bool) {
        if open {
            self.windows.insert(index);
        } else {
            self.windows.remove(&index);
            let data = self.trace.windows.get(index).map_or(0, |window| window.data.get());
            self.data += i128::from(data);
        }
    }

    fn truth(&mut self, at: i64, truth: &Truth) {
        self.load(at, truth.load.get().into());
        self.made(at, truth.data.get().into());
        self.held(at, truth);
    }

    /// Computer and windows draw what they draw; activities and heaters at most
    /// what is written of them.
    fn load(&mut self, at: i64, load: i128) {
        let draws = |load: Load| i128::from(load.marginal.get());
        let parameters = self.parameters;
        let computer = match self.mode {
            Mode::Asleep => 0,
            Mode::WakingUp => draws(parameters.wakeup.load),
            Mode::Awake => draws(parameters.awake),
            Mode::ShuttingDown => draws(parameters.shutdown.load),
        };
        let windows = self.windows.iter().filter_map(|index| self.trace.windows.get(*index));
        let windows: i128 = windows.map(|window| i128::from(window.marginal.get())).sum();
        let zones = parameters.zones.iter().filter(|zone| self.heaters.contains(&*zone.name));
        let heaters: i128 = zones.map(|zone| draws(zone.load)).sum();
        let working = self.plan.activities.iter().filter(|one| self.working.contains(&one.id));
        let working: i128 = working.map(|one| i128::from(one.marginal.get())).sum();
        let least = computer + windows + self.leak;
        let most = least + heaters + working;
        let off = (load - most).max(0) + (load - least).min(0);
        if off != 0 {
            self.wrong.push(Violation::new(Rule::TrueLoad, None, at).by(off));
        }
    }

    /// What runs has made some of what it will have made.
    fn made(&mut self, at: i64, data: i128) {
        let next = |id| self.makes.get(id).and_then(VecDeque::front);
        let running = || self.working.iter().chain(&self.paused);
        // What outlives the record can have made anything.
        if running().any(|id| next(id).is_none()) {
            return;
        }
        let part = |bound: fn(i128, i128) -> i128| -> i128 {
            running().filter_map(next).map(|made| bound(*made, 0)).sum()
        };
        let (least, most) = (self.data + part(i128::min), self.data + part(i128::max));
        let off = (data - most).max(0) + (data - least).min(0);
        if off != 0 {
            self.wrong.push(Violation::new(Rule::TrueData, None, at).by(off));
        }
    }

    fn lost(&mut self, at: i64, energy: i128) {
        if let Some((_, _, load)) = self.charge {
            let charge = self.charge_at(at).unwrap_or(0);
            self.charge = Some((at, (charge - energy).max(0), load));
        }
    }

    fn held(&mut self, at: i64, truth: &Truth) {
        let charge = i128::from(truth.charge.get());
        if let (Some(expected), Some((.., load))) = (self.charge_at(at), self.charge) {
            let off = charge - expected;
            // Rounded down; and a battery that is flat holds what a microsecond
            // would need.
            if off.abs() > 2 + load / 1_000 {
                self.wrong.push(Violation::new(Rule::TrueCharge, None, at).by(off));
            }
        }
        self.charge = Some((at, charge, truth.load.get().into()));
    }

    /// A milliwatt for a millisecond is a microjoule.
    fn charge_at(&self, at: i64) -> Option<i128> {
        let (since, charge, load) = self.charge?;
        let [rtg, base] = [self.parameters.rtg, self.parameters.base].map(|w| i128::from(w.get()));
        let charge = charge + (rtg - base - load) * i128::from(at - since);
        Some(charge.clamp(0, self.capacity))
    }
}
