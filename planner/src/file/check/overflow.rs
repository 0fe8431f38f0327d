//! Sums that could be larger than what the planner counts with are refused
//! when a file is read, with its name. Whether all files together are too large
//! is the planner's own question.

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::Report;
use faregate_tickets::amount::Milliwatts;

use crate::file::check::About;
use crate::file::check::plan::Placement;
use crate::file::xml::Element;
use crate::parameters::{Load, Parameters};
use crate::plan::Plan;
use crate::state::State;

const MOST: i128 = i64::MAX as i128;

pub(super) fn plan(plan: &Placement<'_>, report: &mut Report<'_>) {
    let mut about = About::new(plan.root, "the plan".into(), report);
    let Plan { activities, end, .. } = &plan.value;
    let peaks = activities.iter().map(|one| milliwatts(one.peak)).sum();
    let data = activities.iter().map(|one| i128::from(one.data.get()).abs()).sum();
    let durations = activities.iter().map(|one| i128::from(one.duration.get())).sum();
    let energy = power(&plan.value) * i128::from(end.get()).abs();
    let sums: [(_, i128); 4] =
        [("peaks", peaks), ("data", data), ("durations", durations), ("energy", energy)];
    tell(&sums, &mut about);
}

pub(super) fn parameters(parameters: &Parameters, root: &Element<'_>, report: &mut Report<'_>) {
    let mut about = About::new(root, "the parameters".into(), report);
    tell(&[("powers", loads(parameters))], &mut about);
}

pub(super) fn state(state: &State, root: &Element<'_>, report: &mut Report<'_>) {
    let mut about = About::new(root, "the state".into(), report);
    let data = state.windows.iter().map(|one| i128::from(one.data.get()).abs()).sum::<i128>()
        + state.ended.iter().map(|one| i128::from(one.data.get()).abs()).sum::<i128>()
        + state.running.iter().map(|one| i128::from(one.data.get()).abs()).sum::<i128>();
    let peaks = state.windows.iter().map(|one| milliwatts(one.peak)).sum();
    tell(&[("data", data), ("peaks", peaks)], &mut about);
}

fn tell(sums: &[(&str, i128)], about: &mut About<'_, '_, '_>) {
    for (what, sum) in sums {
        if *sum > MOST {
            let message = format!("the sum of all {what} is too large to be counted");
            about.error("", Rule::Range, &message, "less");
        }
    }
}

fn milliwatts(power: Milliwatts) -> i128 {
    i128::from(power.get())
}

fn power(plan: &Plan) -> i128 {
    plan.activities.iter().map(|one| milliwatts(one.marginal)).sum()
}

fn loads(parameters: &Parameters) -> i128 {
    let load = |load: Load| milliwatts(load.marginal) + milliwatts(load.peak);
    let own = [parameters.awake, parameters.wakeup.load, parameters.shutdown.load];
    let zones = parameters.zones.iter().map(|zone| zone.load);
    own.into_iter().chain(zones).map(load).sum::<i128>()
        + milliwatts(parameters.rtg)
        + milliwatts(parameters.base)
}
