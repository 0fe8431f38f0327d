//! A plan with the parameters and the state that it is to be made with.

use faregate_scheduler::format::reading::Report;
use faregate_scheduler::format::{Diagnostic, Rule};

use crate::file::check::About;
use crate::file::check::plan::block;
use crate::file::schema;
use crate::file::xml::Element;
use crate::parameters::Parameters;
use crate::plan::{Activity, ActivityId, Kind, Plan};
use crate::problem::Problem;
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
    for (index, ended) in state.ended.iter().enumerate().filter(|(_, one)| !knows(plan, one.id)) {
        let element = root.nth(schema::ENDED.name, index);
        let message = format!("the plan has no {}, which has ended", ended.id);
        about.warn_at(element, "activity", Rule::UnknownActivity, &message, None);
    }
    for (index, one) in state.running.iter().enumerate().filter(|(_, one)| !knows(plan, one.id)) {
        let element = root.nth(schema::RUNNING.name, index);
        let message = format!("the plan has no {}, and what it draws is not known", one.id);
        let expected = "what runs to be in the plan, the one before included";
        about.error_at(element, "activity", Rule::UnknownActivity, &message, expected);
    }
    if plan.end < state.now {
        about.warn("now", Rule::NeverRuns, "the plan is over", None);
    }
    windows(plan, state, &mut about);
    let good = !report.found.iter().any(Diagnostic::is_error);
    if good && let Err(unfit) = Problem::new(plan, parameters, state) {
        let mut about = About::new(root, "the three together".into(), report);
        for one in unfit {
            about.error("", Rule::Range, &one.to_string(), "what can be planned from");
        }
    }
}

fn knows(plan: &Plan, id: ActivityId) -> bool {
    plan.activities.iter().any(|one| one.id == id)
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
