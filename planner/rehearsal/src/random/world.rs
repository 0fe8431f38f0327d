//! The rover and its day.

use faregate_planner::state::Mode;
use faregate_planner::units::{Bytes, Ppm, Span};
use faregate_planner::{Parameters, Plan, State};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::throws::Throws;

/// What activities may ask for at dispatch.
pub(super) const VARIABLES: [&str; 3] = ["drive_permitted", "arm_stowed", "dust_covered"];

fn percent(number: u64) -> Ppm {
    Ppm::new(i64::try_from(number).unwrap_or(0) * 10_000)
}

pub(super) fn parameters(parameters: &mut Parameters, throws: &mut Throws) {
    let soft = throws.number(28, 45);
    parameters.soft_min_soc = percent(soft);
    parameters.hard_min_soc = percent(soft - throws.number(4, 14));
    parameters.max_soc = percent(throws.number(70, 100));
    parameters.peak_limit = Milliwatts::new(throws.number(240, 480) * 1_000);
    parameters.engines = u32::try_from(throws.number(2, 5)).unwrap_or(2);
    parameters.min_awake = throws.minutes(5, 25);
    parameters.min_sleep = throws.minutes(10, 60);
    parameters.wakeup.duration = throws.seconds(120, 480);
    parameters.shutdown.duration = throws.seconds(120, 480);
    parameters.commit = throws.seconds(0, 300);
    parameters.expansion_grace = throws.seconds(1, 60);
    parameters.handover_tolerance = throws.seconds(1, 10);
    parameters.soft_samples = u32::try_from(throws.number(1, 4)).unwrap_or(1);
    for zone in &mut parameters.zones {
        let share = i64::try_from(throws.number(20, 100)).unwrap_or(100);
        for row in &mut zone.table {
            row.duration = Span::new(row.duration.get() / 100 * share);
        }
    }
}

/// A battery of 80 to 500 Wh, so that a few activities are felt.
pub(super) fn state(state: &mut State, parameters: &Parameters, throws: &mut Throws) {
    state.capacity = Microjoules::new(throws.number(80, 500) * 3_600_000_000);
    state.charge = Microjoules::new(state.capacity.get() / 100 * throws.number(45, 98));
    let within = |phase: Span| u64::try_from(phase.get() / 1_000).unwrap_or(0);
    let (mode, since) = match throws.index(0, 9) {
        0..6 => (Mode::Asleep, throws.minutes(0, 240)),
        6..8 => (Mode::Awake, throws.minutes(0, 60)),
        8 => (Mode::WakingUp, throws.seconds(0, within(parameters.wakeup.duration))),
        _ => (Mode::ShuttingDown, throws.seconds(0, within(parameters.shutdown.duration))),
    };
    (state.mode, state.mode_since) = (mode, state.now.before(since));
    for name in VARIABLES {
        if throws.chance(90) {
            state.variables.insert(name.to_owned(), i64::from(throws.chance(90)));
        }
    }
    state.windows.retain(|_| throws.chance(75));
}

pub(super) fn plan(plan: &mut Plan, state: &State, throws: &mut Throws) {
    if throws.chance(50) {
        plan.end = state.now.after(throws.minutes(8 * 60, 18 * 60));
    }
    plan.handover = throws.within(plan.end.before(Span::from_mins(240)), plan.end);
    plan.handover_min_soc = percent(throws.number(35, 65));
    plan.max_delta_data =
        Bytes::new(i64::try_from(throws.number(10, 120)).unwrap_or(10) * 1_000_000);
}
