//! The plans that were made on the way: each keeps the rules, given what it was
//! made from, and leaves the commit window of the one before alone.

use faregate_planner::timed::{Fate, Slot};
use faregate_planner::trace::{Happened, Trace};
use faregate_planner::{ActivityId, Parameters, Plan, TimedPlan};

use crate::violation::{Rule, Violation};
use crate::{Effort, check as check_plan};

pub(super) fn check(plan: &Plan, parameters: &Parameters, trace: &Trace) -> Vec<Violation> {
    let mut plan = plan;
    let mut incumbent: Option<TimedPlan> = None;
    let mut wrong = Vec::new();
    for entry in &trace.entries {
        match &entry.what {
            Happened::Planned { state, timed, .. } => {
                let effort = Effort { grid: 0 };
                wrong.extend(check_plan(
                    plan,
                    parameters,
                    state,
                    incumbent.as_ref(),
                    timed,
                    effort,
                ));
                incumbent = Some(TimedPlan::clone(timed));
            }
            Happened::Pushed { id, slot } => push(incumbent.as_mut(), *id, *slot),
            // What comes now is another plan's: nothing of it is committed.
            Happened::HandedOver(next) => (plan, incumbent) = (next, None),
            _ => {}
        }
    }
    let commit = |violation: Violation| match violation.rule {
        Rule::Commit => Violation { rule: Rule::Recommitted, ..violation },
        _ => violation,
    };
    wrong.into_iter().map(commit).collect()
}

/// A start that waits for its tickets is planned for now instead.
fn push(incumbent: Option<&mut TimedPlan>, id: ActivityId, slot: Slot) {
    let rows = incumbent.into_iter().flat_map(|plan| &mut plan.rows);
    for row in rows.filter(|row| row.id == id) {
        row.fate = Fate::Scheduled(slot);
    }
}
