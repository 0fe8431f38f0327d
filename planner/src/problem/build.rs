//! Makes a problem: first everything that must hold is checked, then names
//! become indices.

mod checks;
mod items;

use std::collections::BTreeMap;

use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::parameters::Parameters;
use crate::plan::{ActivityId, Plan};
use crate::state::State;
use crate::units::Ppm;

use super::{Battery, Computer, Problem, Unfit, ZoneModel};

/// Instants are at most this far from the origin: more than 30 000 years, and
/// far enough from the end of an i64 for any sum of a few.
pub(super) const FAR: i64 = 1 << 50;

/// No power or charge is larger: so sums of products are checked once, in wide
/// integers, and need no check afterwards.
pub(super) const LARGE: i64 = 1 << 61;

/// Numbers of activities, to indices.
pub(super) type Index = BTreeMap<ActivityId, usize>;

pub(super) fn build(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
) -> Result<Problem, Vec<Unfit>> {
    let unfit = checks::all(plan, parameters, state);
    if !unfit.is_empty() {
        return Err(unfit);
    }
    let (now, end) = (state.now.get(), plan.end.get().max(state.now.get()));
    let items = items::items(plan, parameters, state);
    let mut order: Vec<usize> = (0..items.len()).filter(|&at| items[at].is_candidate()).collect();
    order.sort_by_key(|&at| core::cmp::Reverse(plan.activities[at].priority));
    let handover = plan.handover.get();
    Ok(Problem {
        now,
        end,
        handover: (now <= handover && handover <= end).then_some(handover),
        battery: battery(plan, parameters, state),
        computer: computer(parameters, state),
        zones: zones(parameters, state),
        blocks: items::blocks(plan, state),
        order,
        items,
        peak_limit: small(parameters.peak_limit),
        commit: parameters.commit.get(),
        plan: plan.clone(),
        parameters: parameters.clone(),
        state: state.clone(),
    })
}

/// An amount that was checked to be one.
pub(super) fn small(power: Milliwatts) -> i64 {
    i64::try_from(power.get()).unwrap_or(LARGE).min(LARGE)
}

fn charge(charge: Microjoules) -> i64 {
    i64::try_from(charge.get()).unwrap_or(LARGE).min(LARGE)
}

/// A fraction of the capacity: the smallest charge that is not below it, and
/// the largest that is not above.
pub(crate) fn fraction(part: Ppm, capacity: i64) -> (i64, i64) {
    let exact = i128::from(part.get()) * i128::from(capacity);
    let floor = exact.div_euclid(1_000_000);
    let ceiling = floor + i128::from(exact.rem_euclid(1_000_000) != 0);
    let narrow = |wide: i128| i64::try_from(wide).unwrap_or(LARGE);
    (narrow(ceiling), narrow(floor))
}

fn battery(plan: &Plan, parameters: &Parameters, state: &State) -> Battery {
    let capacity = charge(state.capacity);
    Battery {
        charge: charge(state.charge).min(capacity),
        capacity,
        soft: fraction(parameters.soft_min_soc, capacity).0,
        handover: fraction(plan.handover_min_soc, capacity).0,
        max: fraction(parameters.max_soc, capacity).1,
        idle: small(parameters.rtg) - small(parameters.base),
    }
}

fn computer(parameters: &Parameters, state: &State) -> Computer {
    Computer {
        mode: state.mode,
        since: state.mode_since.get(),
        awake: parameters.awake.into(),
        wakeup: parameters.wakeup.load.into(),
        shutdown: parameters.shutdown.load.into(),
        wakeup_time: parameters.wakeup.duration.get(),
        shutdown_time: parameters.shutdown.duration.get(),
        min_awake: parameters.min_awake.get(),
        min_sleep: parameters.min_sleep.get(),
    }
}

fn zones(parameters: &Parameters, state: &State) -> Vec<ZoneModel> {
    let zone = |zone: &crate::parameters::Zone| ZoneModel {
        name: zone.name.clone(),
        draw: zone.load.into(),
        day: parameters.day,
        table: zone.table.clone(),
        heating: state.heating.get(&zone.name).map(|since| since.get()),
        cold: state.cold.contains(&zone.name),
    };
    parameters.zones.iter().map(zone).collect()
}
