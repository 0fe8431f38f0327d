//! A plan with the parameters and the state that it is to be made with.

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::Report;

use crate::file::check::plan::block;
use crate::file::check::{About, overflow};
use crate::file::xml::Element;
use crate::parameters::Parameters;
use crate::plan::{Activity, ActivityId, Kind, Plan};
use crate::state::State;

/// Tells at the state's elements what does not go with the plan.
pub(in crate::file) fn together(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    root: &Element<'_>,
    report: &mut Report<'_>,
) {
    let mut about = About::new(root, "the state".into(), report);
    let ids = state.ended.iter().map(|one| ("ended", one.id));
    let ids =
        ids.enumerate().chain(state.running.iter().map(|one| ("running", one.id)).enumerate());
    for (index, (name, id)) in ids {
        if !plan.activities.iter().any(|one| one.id == id) {
            unknown(id, root.nth(name, index), &mut about);
        }
    }
    if plan.end < state.now {
        about.warn("now", Rule::NeverRuns, "the plan is over", None);
    }
    windows(plan, state, &mut about);
    overflow::together(plan, parameters, state, &mut about);
}

/// After a handover, what ran goes on, and its plan is another one.
fn unknown(id: ActivityId, element: &Element<'_>, about: &mut About<'_, '_, '_>) {
    let message = format!("the plan has no {id}");
    let help = "this is right where the activity is of the plan before this one";
    about.warn_at(element, "activity", Rule::UnknownActivity, &message, Some(help.into()));
}

/// Nothing that needs the computer overlaps a manual shutdown, and neither of
/// the two can be moved.
fn windows(plan: &Plan, state: &State, about: &mut About<'_, '_, '_>) {
    let manual = |one: &&Activity| matches!(one.kind, Kind::ManualShutdown { .. });
    for (one, (from, to)) in
        plan.activities.iter().filter(manual).filter_map(|one| Some((one, block(one)?)))
    {
        for (index, window) in state.windows.iter().enumerate() {
            if window.awake && window.start < to && from < window.end && to > state.now {
                let element = about.element.nth("window", index);
                let message = format!(
                    "the window {} needs the computer, which {} shuts down",
                    window.name, one.id
                );
                about.error_at(element, "start", Rule::Window, &message, "one or the other");
            }
        }
    }
}
