//! Control threads that are broken, each in one way: the checker finds it in
//! what they do, and finds nothing in what a right one does with the same plan.

mod support;

use std::sync::Arc;

use faregate_agents::Categories;
use faregate_checker::Rule;
use faregate_planner::execute::Options;
use faregate_planner::plan::{Condition, Kind, StartRange, Variable};
use faregate_planner::state::Window;
use faregate_planner::trace::Happened;
use faregate_planner::units::{Bytes, Ppm, Span};
use faregate_planner::{Activity, Parameters, Plan};
use faregate_rehearsal::{Belief, Draw, Mishap, Script, Setup, rehearse};
use faregate_tickets::amount::{Microjoules, Milliwatts};
use support::{activity, early, id, min, planner, setup, started, when};

/// The rules that an execution breaks.
fn broken(setup: &Setup) -> Vec<Rule> {
    let trace = rehearse(setup, &mut planner).expect("there is a plan");
    let wrong = faregate_checker::check_trace(&setup.plan, &setup.parameters, &trace);
    wrong.into_iter().map(|violation| violation.rule).collect()
}

/// A right control thread breaks no rule; one that believes otherwise, this one.
fn is_caught(setup: &Setup, rule: Rule, change: impl FnOnce(&mut Plan, &mut Parameters)) {
    assert_eq!(broken(setup), [], "by a right control thread");
    let mut setup = setup.clone();
    let (mut plan, mut parameters) =
        (Plan::clone(&setup.plan), Parameters::clone(&setup.parameters));
    change(&mut plan, &mut parameters);
    setup.breaks.believes = Some(Belief { plan: Arc::new(plan), parameters: Arc::new(parameters) });
    let found = broken(&setup);
    assert!(found.contains(&rule), "{found:?}");
}

fn optional(number: u32) -> Activity {
    Activity { priority: 50, ..activity(number) }
}

/// It takes three times as long as planned.
const HANGS: Draw = Draw { length: 3_000, ..Draw::AS_PLANNED };

#[test]
fn a_cutoff_that_is_a_millisecond_late() {
    let mut one = activity(1);
    one.starts[0].cutoff = min(60);
    let mut setup = setup(vec![one]);
    setup.draws.set(id(1), HANGS);
    is_caught(&setup, Rule::RanPastCutoff, |plan, _| {
        let cutoff = &mut plan.activities[0].starts[0].cutoff;
        *cutoff = cutoff.after(Span::new(1));
    });
}

#[test]
fn a_grace_that_is_a_millisecond_long() {
    let kind = Kind::Expanding { minimum: Span::from_mins(10) };
    let mut setup = setup(vec![Activity { kind, ..optional(1) }]);
    setup.draws.set(id(1), Draw { ending: Span::from_mins(10), ..HANGS });
    is_caught(&setup, Rule::RanPastDuration, |_, parameters| {
        parameters.expansion_grace = Span::new(parameters.expansion_grace.get() + 1);
    });
}

#[test]
fn a_variable_that_nobody_knows_is_taken_for_right() {
    let condition =
        Condition { kind: Variable::Acm, name: "drive_permitted".into(), min: 1, max: 1 };
    let setup = setup(vec![Activity { conditions: vec![condition], ..activity(1) }]);
    is_caught(&setup, Rule::DispatchedVariables, |plan, _| plan.activities[0].conditions.clear());
}

/// So many hundredths of the capacity are lost while the first one runs.
fn loses(mut setup: Setup, percent: u64) -> Setup {
    let trace = rehearse(&setup, &mut planner).expect("there is a plan");
    let at = started(&trace, 1).expect("it starts").after(Span::from_mins(3));
    let energy = Microjoules::new(setup.state.capacity.get() / 100 * percent);
    setup.script = Script(vec![Mishap::Discharge { at, energy }]);
    setup
}

#[test]
fn a_hard_limit_that_is_lower() {
    let setup = loses(setup(vec![activity(1)]), 66);
    is_caught(&setup, Rule::RanAtHardLimit, |_, parameters| {
        parameters.hard_min_soc = Ppm::new(50_000);
    });
}

#[test]
fn samples_below_the_soft_limit_that_nobody_counts() {
    let setup = loses(setup(vec![optional(1)]), 52);
    is_caught(&setup, Rule::RanBelowSoft, |_, parameters| parameters.soft_samples = 100);
}

#[test]
fn an_abort_at_the_first_sample_where_three_are_asked_for() {
    let mut setup = setup(vec![optional(1)]);
    setup.parameters =
        Arc::new(Parameters { soft_samples: 3, ..Parameters::clone(&setup.parameters) });
    is_caught(&loses(setup, 52), Rule::AbortCause, |_, parameters| parameters.soft_samples = 1);
}

/// A window comes sooner than planned, and takes the only engine.
#[test]
fn what_is_paused_and_draws() {
    let mut setup = setup(vec![Activity { pausable: true, ..activity(1) }]);
    setup.parameters = Arc::new(Parameters { engines: 1, ..Parameters::clone(&setup.parameters) });
    let load = Milliwatts::from_watts(10);
    let later = |start| Window {
        name: "pass".into(),
        start,
        end: start.after(Span::from_mins(4)),
        awake: true,
        marginal: load,
        peak: load,
        data: Bytes::ZERO,
        engines: 1,
        resources: Categories::NONE,
    };
    setup.state.windows = vec![later(min(500))];
    let trace = rehearse(&setup, &mut planner).expect("there is a plan");
    let at = started(&trace, 1).expect("it starts").after(Span::from_mins(3));
    let becomes = Some(later(at.after(Span::from_mins(1))));
    setup.script = Script(vec![Mishap::Window { at, index: 0, becomes }]);
    assert_eq!(broken(&setup), []);
    let trace = rehearse(&setup, &mut planner).expect("there is a plan");
    assert!(when(&trace, |what| *what == Happened::Paused(id(1))).is_some());
    setup.breaks.goes_on = true;
    let found = broken(&setup);
    assert!(found.contains(&Rule::TrueLoad), "{found:?}");
}

#[test]
fn an_early_start_for_which_another_one_starts_later() {
    let fixed = StartRange { from: min(60), to: min(60), cutoff: min(80) };
    let second = Activity { starts: vec![fixed], ..activity(2) };
    // Where the second one is, it does not fit in front of it.
    let third = Activity { duration: Span::from_mins(60), ..activity(3) };
    let first = Activity { resources: Categories::NONE, ..activity(1) };
    let mut setup = setup(vec![first, second, third]);
    // What is needed before is there without new plans.
    setup.options = Options { replans: false, ..setup.options };
    setup.state.mode = faregate_planner::state::Mode::Awake;
    setup.parameters = Arc::new(Parameters {
        min_sleep: Span::from_mins(300),
        ..Parameters::clone(&setup.parameters)
    });
    setup.draws.set(id(1), early(500));
    is_caught(&setup, Rule::EarlyBeside, |plan, _| {
        plan.activities.iter_mut().for_each(|one| one.resources = Categories::NONE);
    });
}

/// The same, where it is power that there is for one of them alone.
#[test]
fn an_early_start_for_which_another_one_lacks_power() {
    let fixed = StartRange { from: min(60), to: min(60), cutoff: min(80) };
    let drawing = |one| Activity { resources: Categories::NONE, peak: watts(100), ..one };
    let second = Activity { starts: vec![fixed], ..drawing(activity(2)) };
    let third = Activity { duration: Span::from_mins(60), ..drawing(activity(3)) };
    let mut setup = setup(vec![drawing(activity(1)), second, third]);
    setup.options = Options { replans: false, ..setup.options };
    setup.state.mode = faregate_planner::state::Mode::Awake;
    let parameters = Parameters::clone(&setup.parameters);
    let peak_limit = parameters.awake.peak.saturating_add(watts(199));
    let min_sleep = Span::from_mins(300);
    setup.parameters = Arc::new(Parameters { min_sleep, peak_limit, ..parameters });
    setup.draws.set(id(1), early(500));
    is_caught(&setup, Rule::EarlyBeside, |plan, _| {
        plan.activities.iter_mut().for_each(|one| one.peak = Milliwatts::ZERO);
    });
}

const fn watts(watts: u32) -> Milliwatts {
    Milliwatts::from_watts(watts)
}

#[test]
fn a_nap_that_is_not_worth_it() {
    let fixed = StartRange { from: min(62), to: min(62), cutoff: min(90) };
    let second = Activity { starts: vec![fixed], ..activity(2) };
    let mut setup = setup(vec![activity(1), second]);
    setup.options = Options::STATIC;
    // It ends so late that less than the minimum sleep is left.
    setup.draws.set(id(1), Draw { length: 1_200, ..Draw::AS_PLANNED });
    is_caught(&setup, Rule::SleptTooShort, |_, parameters| parameters.min_sleep = Span::ZERO);
}

#[test]
fn a_handover_at_the_end() {
    let mut setup = setup(vec![activity(1)]);
    setup.plan = Arc::new(Plan {
        handover: min(200),
        next_plan: Some("next".into()),
        ..Plan::clone(&setup.plan)
    });
    is_caught(&setup, Rule::TookOver, |plan, _| plan.handover = plan.end);
}
