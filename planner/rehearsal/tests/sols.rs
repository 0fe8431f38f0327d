//! The example sols, executed.

use std::path::Path;
use std::sync::Arc;

use faregate_planner::execute::Options;
use faregate_planner::problem::Problem;
use faregate_planner::trace::{Happened, Trace};
use faregate_planner::{Parameters, Plan, State, TimedPlan, file};
use faregate_rehearsal::{Setup, Summary, Won, rehearse};

fn planner(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    incumbent: Option<&TimedPlan>,
) -> Result<TimedPlan, String> {
    let problem = Problem::new(plan, parameters, state).map_err(|unfit| format!("{unfit:?}"))?;
    Ok(faregate_planner::schedule::schedule(&problem, incumbent))
}

fn setup(sol: &str, seed: u64) -> Setup {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/sols");
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let parameters = file::parameters("parameters.xml", &read("parameters.xml")).unwrap().value;
    let plan = read(&format!("{sol}/plan.xml"));
    let plan = file::plan("plan.xml", &plan, Some(&parameters)).unwrap().value;
    let state = read(&format!("{sol}/state.xml"));
    let state = file::state("state.xml", &state, Some(&parameters)).unwrap().value;
    Setup::new(Arc::new(plan), Arc::new(parameters), state, seed)
}

fn show(plan: &Plan, trace: &Trace) {
    let name = |id| {
        let activity = plan.activities.iter().find(|one| one.id == id);
        activity.and_then(|one| one.name.clone()).unwrap_or_default()
    };
    for entry in &trace.entries {
        let at = entry.at;
        match &entry.what {
            Happened::Planned { why, .. } => eprintln!("{at}: planned {why:?}"),
            Happened::Truth(_) | Happened::Estimate { .. } | Happened::Requested(_) => {}
            Happened::Dispatched(d) => eprintln!("{at}: started {} {d:?}", name(d.id)),
            Happened::Ended { id, .. }
            | Happened::Aborted { id, .. }
            | Happened::NotStarted { id, .. } => eprintln!("{at}: {} {:?}", name(*id), entry.what),
            other => eprintln!("{at}: {other:?}"),
        }
    }
}

#[test]
fn the_busy_sol_is_executed() {
    let ours = setup("busy", 1);
    let trace = rehearse(&ours, &mut planner).unwrap();
    show(&ours.plan, &trace);
    let theirs = Setup { options: Options::STATIC, ..ours.clone() };
    let there = rehearse(&theirs, &mut planner).unwrap();
    eprintln!("{:?}", Summary::of(&ours.plan, &trace));
    eprintln!("{:?}", Summary::of(&ours.plan, &there));
    eprintln!("{:?}", Won::between(&ours.plan, &trace, &there));
}
