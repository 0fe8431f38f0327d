//! Sleeps: a wakeup that was planned comes after a sleep that was worth it. One
//! that a window, the ground's own shutdown or a handover wants may come sooner,
//! and so may the end of a sleep that was in progress when all began.

use faregate_planner::plan::Kind;
use faregate_planner::state::Mode;
use faregate_planner::trace::{Happened, Trace};
use faregate_planner::units::Time;
use faregate_planner::{Parameters, Plan, TimedPlan};

use crate::violation::{Rule, Violation};

pub(super) fn check(plan: &Plan, parameters: &Parameters, trace: &Trace) -> Vec<Violation> {
    let mut plan = plan;
    let mut timed: Option<&TimedPlan> = None;
    let mut asleep: Option<Time> = None;
    let mut was_up = false;
    let mut wrong = Vec::new();
    for entry in &trace.entries {
        match &entry.what {
            Happened::Planned { state, timed: new, .. } => {
                was_up |= state.mode == Mode::Awake;
                timed = Some(new);
            }
            Happened::HandedOver(next) => (plan, timed) = (next, None),
            Happened::Mode(Mode::Awake) => was_up = true,
            Happened::Mode(Mode::Asleep) => asleep = was_up.then_some(entry.at),
            Happened::Mode(Mode::WakingUp) => {
                let planned = timed.is_some_and(|timed| is_planned(timed, entry.at));
                let slept = asleep.take().map(|since| entry.at.since(since));
                let short = slept.filter(|slept| *slept < parameters.min_sleep);
                if let Some(slept) = short.filter(|_| planned && !by_ground(plan, entry.at)) {
                    let by = parameters.min_sleep.get() - slept.get();
                    let violation = Violation::new(Rule::SleptTooShort, None, entry.at.get());
                    wrong.push(violation.by(by));
                }
            }
            _ => {}
        }
    }
    wrong
}

fn is_planned(timed: &TimedPlan, at: Time) -> bool {
    timed.awake.iter().any(|phase| phase.wakeup == at)
}

/// The ground sleeps and wakes as it likes.
fn by_ground(plan: &Plan, at: Time) -> bool {
    plan.activities.iter().any(|activity| {
        let from = activity.starts.first().map(|range| range.from);
        matches!(activity.kind, Kind::ManualShutdown { .. })
            && from.is_some_and(|from| from <= at && at <= from.after(activity.duration))
    })
}
