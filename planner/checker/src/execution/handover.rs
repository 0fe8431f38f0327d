//! Handover: at its instant the next plan takes over, with what runs, or it is
//! said why not.

use faregate_planner::Plan;
use faregate_planner::plan::{Activity, ActivityId};
use faregate_planner::trace::{Happened, Trace};

use crate::violation::{Rule, Violation};

pub(super) fn check(plan: &Plan, trace: &Trace) -> Vec<Violation> {
    let mut plan = plan;
    let mut due = due(plan, trace);
    let mut running: Vec<ActivityId> = Vec::new();
    let mut wrong = Vec::new();
    for entry in &trace.entries {
        let at = entry.at.get();
        match &entry.what {
            Happened::Dispatched(dispatch) => running.push(dispatch.id),
            Happened::Ended { id, .. } | Happened::Aborted { id, .. } => {
                running.retain(|other| other != id);
            }
            Happened::NoNextPlan(_) => wrong.extend(answered(due.take(), at)),
            Happened::HandedOver(next) => {
                wrong.extend(answered(due.take(), at));
                wrong.extend(lost(plan, next, &running, at));
                plan = next;
                due = self::due(plan, trace);
            }
            _ => {}
        }
    }
    wrong.extend(
        due.filter(|due| *due < trace.end.get())
            .map(|due| Violation::new(Rule::TookOver, None, due).detail("nobody asked for it")),
    );
    wrong
}

/// When the next plan is to take over; none: there is none.
fn due(plan: &Plan, trace: &Trace) -> Option<i64> {
    plan.next_plan.as_ref().map(|_| plan.handover.max(trace.begin).get())
}

fn answered(due: Option<i64>, at: i64) -> Option<Violation> {
    match due {
        None => Some(Violation::new(Rule::TookOver, None, at).detail("there is none")),
        Some(due) if at != due => Some(Violation::new(Rule::TookOver, None, due).by(at - due)),
        Some(_) => None,
    }
}

/// What runs is as it was. That it had waited for others, or kept others out, is
/// over with its plan.
fn lost(plan: &Plan, next: &Plan, running: &[ActivityId], at: i64) -> Vec<Violation> {
    let find = |plan: &Plan, id| plan.activities.iter().find(|one| one.id == id).map(on_its_own);
    let lost = running.iter().filter(|id| {
        let known = find(plan, **id);
        known.is_some() && known != find(next, **id)
    });
    let said = |id: &ActivityId| {
        Violation::new(Rule::TookOver, Some(*id), at).detail("it runs, and is not in it as it was")
    };
    lost.map(said).collect()
}

fn on_its_own(activity: &Activity) -> Activity {
    Activity { after: Vec::new(), group: None, ..activity.clone() }
}
