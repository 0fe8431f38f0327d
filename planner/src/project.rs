//! What every timeline will be, if all goes as planned.
//!
//! Worked out from the timed plan alone, not from what the planner thought
//! while it made it: charge, peak, data, engines, awake, then the named
//! timelines. The charge is exact: a milliwatt for a millisecond is a
//! microjoule.

mod power;

use crate::parameters::Parameters;
use crate::plan::{Activity, Plan};
use crate::state::State;
use crate::timed::{Fate, Line, Projection, TimedPlan};
use crate::timeline::{Claim, Shown, Timelines, UnknownTimeline};
use crate::units::Time;

/// The values of all timelines from the present to the plan's end.
///
/// # Errors
///
/// [`UnknownTimeline`], where an activity of the timed plan names one that the
/// parameters have not got.
pub fn project(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    timed: &TimedPlan,
) -> Result<Projection, UnknownTimeline> {
    let timelines = filled(plan, parameters, state, timed)?;
    let (charge, peak) = power::lines(plan, parameters, state, timed);
    let mut lines = vec![charge, peak, shown("data", "B", timelines.data())];
    lines.push(shown("engines", "", timelines.engines()));
    lines.push(awake(state, timed));
    lines.extend(timelines.named().map(|(name, values)| shown(name, "", values)));
    Ok(Projection { lines })
}

/// Everything that happens in the timed plan.
fn filled(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    timed: &TimedPlan,
) -> Result<Timelines, UnknownTimeline> {
    let mut timelines = Timelines::new(plan, parameters, state);
    let windows = state.windows.iter().filter(|window| window.end > state.now);
    for (order, window) in (plan.activities.len()..).zip(windows) {
        timelines.insert(&Claim::window(window, order), window.start);
    }
    for (order, activity, fate) in fates(plan, timed) {
        match fate {
            Fate::Scheduled(slot) => {
                let claim = Claim::of(activity, order, slot.length(), parameters)?;
                timelines.insert(&claim, slot.start);
            }
            Fate::Running(slot) => {
                let running = state.running.iter().find(|running| running.id == activity.id);
                let Some(running) = running else { continue };
                let left = (state.now, slot.end.max(state.now));
                let claim = Claim::rest(activity, order, running, left, parameters)?;
                timelines.insert(&claim, state.now);
            }
            Fate::Ended(_) | Fate::Out(_) => {}
        }
    }
    Ok(timelines)
}

/// The activities of the plan with what becomes of them.
fn fates<'a>(
    plan: &'a Plan,
    timed: &'a TimedPlan,
) -> impl Iterator<Item = (usize, &'a Activity, &'a Fate)> {
    let activities = plan.activities.iter().enumerate();
    activities.zip(&timed.rows).map(|((order, activity), row)| (order, activity, &row.fate))
}

fn shown(name: &str, unit: &str, values: Shown) -> Line {
    Line { name: name.into(), unit: unit.into(), steps: values.steps, points: values.points }
}

/// 1 where the computer is up, 0 elsewhere.
fn awake(state: &State, timed: &TimedPlan) -> Line {
    let up = |at: Time| timed.awake.iter().any(|phase| phase.up <= at && at < phase.down);
    let changes = timed.awake.iter().flat_map(|phase| [phase.up, phase.down]);
    let mut instants: Vec<_> =
        core::iter::once(state.now).chain(changes.filter(|at| *at > state.now)).collect();
    instants.dedup();
    let points = instants.into_iter().map(|at| (at, i64::from(up(at)))).collect();
    Line { name: "awake".into(), unit: String::new(), steps: true, points }
}
