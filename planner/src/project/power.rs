//! What is drawn, and what is left in the battery.

use crate::parameters::{Load, Parameters, Phase};
use crate::plan::{Activity, Kind, Plan};
use crate::state::{Mode, State};
use crate::timed::{Fate, Line, TimedPlan};
use crate::timeline::Total;
use crate::units::{Span, Time};

use super::fates;

/// Power over time: from when to when, how much.
struct Drawn {
    now: Time,
    /// What comes in, less what is drawn, in mW.
    net: Total,
    peak: Total,
}

/// Charge and peak.
pub(super) fn lines(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    timed: &TimedPlan,
) -> (Line, Line) {
    let drawn = Drawn::of(plan, parameters, state, timed);
    let peak = drawn.peak.shown();
    let charge = charge(&drawn.net, state, plan.end);
    let named = |name: &str, unit: &str, steps, points| Line {
        name: name.into(),
        unit: unit.into(),
        steps,
        points,
    };
    (named("charge", "uJ", false, charge), named("peak", "mW", true, peak.points))
}

impl Drawn {
    fn of(plan: &Plan, parameters: &Parameters, state: &State, timed: &TimedPlan) -> Self {
        let idle = wide(parameters.rtg.get()) - wide(parameters.base.get());
        let (net, peak) =
            (Total::new(state.now, plan.end, idle), Total::new(state.now, plan.end, 0));
        let mut drawn = Self { now: state.now, net, peak };
        drawn.computer(parameters, timed);
        drawn.blocks(plan, parameters, state);
        drawn.activities(plan, state, timed);
        for window in &state.windows {
            let load = Load { marginal: window.marginal, peak: window.peak };
            drawn.add(window.start, window.end, load);
        }
        for preheat in &timed.preheats {
            let zone = parameters.zones.iter().find(|zone| zone.name == preheat.zone);
            drawn.add(
                preheat.start,
                preheat.end,
                zone.map_or_else(Load::default, |zone| zone.load),
            );
        }
        drawn
    }

    fn computer(&mut self, parameters: &Parameters, timed: &TimedPlan) {
        for phase in &timed.awake {
            self.add(phase.wakeup, phase.up, parameters.wakeup.load);
            self.add(phase.up, phase.down, parameters.awake);
            self.add(phase.down, phase.asleep, parameters.shutdown.load);
        }
    }

    /// Manual shutdowns that were not vetoed; and the shutdown in progress, unless
    /// it is one of them.
    fn blocks(&mut self, plan: &Plan, parameters: &Parameters, state: &State) {
        let Parameters { shutdown: Phase { duration, load: down }, wakeup, .. } = *parameters;
        let mut inside = false;
        let gone = |activity: &&Activity| state.ended.iter().any(|one| one.id == activity.id);
        for activity in plan.activities.iter().filter(|activity| !gone(activity)) {
            let Kind::ManualShutdown { shutdown, wakeup: up } = activity.kind else { continue };
            let Some(range) = activity.starts.first() else { continue };
            let (from, to) = (range.from, range.from.after(activity.duration));
            self.add(from, from.after(shutdown), down);
            self.add(to.before(up), to, wakeup.load);
            inside |= from <= self.now && self.now < to;
        }
        if state.mode == Mode::ShuttingDown && !inside {
            self.add(self.now, state.mode_since.after(duration), down);
        }
    }

    fn activities(&mut self, plan: &Plan, state: &State, timed: &TimedPlan) {
        for (_, activity, fate) in fates(plan, timed) {
            let (Fate::Scheduled(slot) | Fate::Running(slot)) = fate else { continue };
            let running = state.running.iter().find(|running| running.id == activity.id);
            let mut load = Load { marginal: activity.marginal, peak: activity.peak };
            if running.is_some_and(|running| running.paused.is_some()) {
                load.marginal = Load::default().marginal;
            }
            self.add(slot.start, slot.end, load);
        }
    }

    fn add(&mut self, from: Time, to: Time, load: Load) {
        let from = from.max(self.now);
        self.net.add(from, to, -wide(load.marginal.get()));
        self.peak.add(from, to, wide(load.peak.get()));
    }
}

fn wide(amount: u64) -> i128 {
    amount.into()
}

/// The charge wherever its rate changes. Where it reaches the capacity, the
/// last ms before and the first at which it is there: every ms is exact.
fn charge(net: &Total, state: &State, end: Time) -> Vec<(Time, i64)> {
    let capacity = wide(state.capacity.get());
    let mut charge = wide(state.charge.get()).min(capacity);
    let mut points = vec![(state.now, charge)];
    for (from, to, net) in net.steps() {
        let to = to.min(end);
        let full = charge + net * i128::from(to.since(from).get());
        if full > capacity && charge < capacity {
            let ms = (capacity - charge).div_euclid(net);
            let last = from.after(Span::new(narrow(ms)));
            points.push((last, charge + net * ms));
            points.push((last.after(Span::new(1)), capacity));
        }
        charge = full.min(capacity);
        points.push((to, charge));
    }
    points.dedup();
    points.into_iter().map(|(at, charge)| (at, narrow(charge))).collect()
}

fn narrow(wide: i128) -> i64 {
    i64::try_from(wide).unwrap_or(if wide < 0 { i64::MIN } else { i64::MAX })
}
