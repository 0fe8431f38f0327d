//! Whether parameters, missions and plans agree.

use std::sync::Arc;

use faregate_planner::timed::Fate;

use faregate_planner::plan::{Dependency, Outcome, Status};
use faregate_planner::state::Ended;
use faregate_planner::tasks::{Disagreement, Misfit, Setting, mission_fits, plan_fits, tasks};
use faregate_planner::timed::TimedPlan;
use faregate_planner::units::Span;
use faregate_planner::{Plan, Problem, State, schedule};
use faregate_scheduler::task::{Body, Step, Task, When};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

use crate::stage::{id, library, mission, parameters, setting, state};

#[test]
fn the_rover_of_the_example_sols_fits_their_parameters() {
    assert_eq!(mission_fits(&parameters(), &mission()), []);
}

#[test]
fn what_parameters_and_mission_say_differently_is_told_each_by_itself() {
    let mut mission = mission();
    mission.agents[0].supply = Some(Milliwatts::new(479_999));
    mission.categories.remove("mast");
    mission.categories.insert("arm".into(), 3);
    mission.categories.remove("engine 3");
    mission.devices.retain(|device| device.name != "heater_mast");
    let found = mission_fits(&parameters(), &mission);
    let words: Vec<_> = found.iter().map(ToString::to_string).collect();
    let expected = [
        "the parameters allow a peak of 480 W, and the mission's first agent has 479999 mW",
        "`arm` is bit 2 of the parameters, and category 3 of the mission",
        "the mission has no category `mast`",
        "bit 3 is `radio` by the parameters, and `arm` by the mission",
        "the mission has no category `engine 3`: each sequence engine needs one",
        "no device of the mission heats the zone `mast`: give its heater the parameter zone = \
         \"mast\"",
    ];
    assert_eq!(words, expected);
    assert!(matches!(found[0], Disagreement::Peak { .. }));
}

#[test]
fn a_supply_of_exactly_the_peak_is_enough() {
    let mut mission = mission();
    mission.agents[0].supply = Some(parameters().peak_limit);
    assert_eq!(mission_fits(&parameters(), &mission), []);
}

#[test]
fn what_cannot_become_a_task_is_told_all_at_once() {
    let mut setting = setting();
    let mut plan = (*setting.plan).clone();
    plan.activities[1].sequence = Some("unheard_of".into());
    plan.activities[3].peak = Milliwatts::from_watts(179);
    setting.plan = Arc::new(plan);
    let mut mission = mission();
    mission.devices.retain(|device| device.name != "mast_camera");
    setting.mission = Arc::new(mission);
    let problem = Problem::new(&setting.plan, &setting.parameters, &state()).unwrap();
    let timed = schedule(&problem, None);
    let wrong = tasks(&setting, &state().windows, &timed, state().now).unwrap_err();
    let of = |number: u32| {
        wrong.iter().find(|one| match one {
            Misfit::Sequence(id, _) | Misfit::Gate(id, _) | Misfit::Peak(id, _) => {
                id.get() == number
            }
            _ => false,
        })
    };
    assert!(matches!(of(2), Some(Misfit::Sequence(_, name)) if name == "unheard_of"));
    assert!(matches!(of(3), Some(Misfit::Gate(_, gate)) if gate == "mast_camera"));
    assert!(matches!(of(4), Some(Misfit::Peak(_, 1_000))), "{wrong:?}");
}

#[test]
fn an_activity_comes_after_the_task_that_heats_its_zone_and_after_its_priors() {
    let (setting, state) = (setting(), state());
    let problem = Problem::new(&setting.plan, &setting.parameters, &state).unwrap();
    let timed = schedule(&problem, None);
    let tasks = tasks(&setting, &state.windows, &timed, state.now).unwrap();
    let find = |number: u32| tasks.iter().find(|task| task.id.get() == number);
    let mut heated = 0;
    for heating in &timed.preheats {
        for (activity, row) in setting.plan.activities.iter().zip(&timed.rows) {
            let Fate::Scheduled(slot) = row.fate else { continue };
            if slot.start != heating.end || !activity.zones.contains(&heating.zone) {
                continue;
            }
            let after = &find(activity.id.get()).unwrap().after;
            let priors: Vec<_> = after.iter().filter_map(|on| find(on.task.get())).collect();
            let name = format!("heat {}", heating.zone);
            assert!(priors.iter().any(|prior| prior.name.as_deref() == Some(&name)), "{name}");
            heated += 1;
        }
    }
    assert!(heated >= 4, "{heated}");
    let drive = find(4).unwrap().after.iter().map(|on| on.task.get()).collect::<Vec<_>>();
    assert_eq!(drive[..2], [2, 3]);
    // No optional one is as important as a mandatory one.
    let activities = tasks.iter().filter(|task| task.id.get() <= 31);
    let (mandatory, optional): (Vec<_>, Vec<_>) = activities.partition(|task| task.mandatory);
    let least = mandatory.iter().map(|task| task.priority.level()).min();
    assert!(optional.iter().all(|task| Some(task.priority.level()) < least));
}

fn clashes(plan: &Plan) -> Vec<String> {
    plan_fits(plan, &library(), &mission()).iter().map(ToString::to_string).collect()
}

#[test]
fn the_busy_sol_fits_the_rover_of_the_example_sols() {
    assert_eq!(clashes(&setting().plan), [""; 0]);
}

#[test]
fn two_that_command_one_gate_share_a_resource_or_never_meet() {
    let mut plan = (*setting().plan).clone();
    let at = |number: u32| move |one: &faregate_planner::Activity| one.id == id(number);
    let place = |plan: &Plan, number| plan.activities.iter().position(at(number)).unwrap();
    // Laser spectra, near and far, on one laser.
    let (near, far) = (place(&plan, 15), place(&plan, 16));
    plan.activities[far].resources = Default::default();
    let clash = "activities `15 laser spectra, near` and `16 laser spectra, far` command the \
                 gate `laser`, can overlap, and share no resource: give both the same one";
    assert_eq!(clashes(&plan), [clash]);
    // Over another one is after, too.
    let free = plan.clone();
    let after = |prior| vec![Dependency { prior: id(prior), statuses: vec![Status::Succeeded] }];
    let between = place(&plan, 18);
    plan.activities[far].after = after(18);
    plan.activities[between].after = after(15);
    assert_eq!(clashes(&plan), [""; 0]);
    let mut plan = free.clone();
    plan.activities[near].group = Some("laser".into());
    assert_eq!(clashes(&plan).len(), 1, "one of them alone is in the group");
    plan.activities[far].group = Some("laser".into());
    assert_eq!(clashes(&plan), [""; 0]);
    // Weather thrice, at other times of day.
    let mut plan = free;
    plan.activities[far].resources = plan.activities[near].resources;
    let (noon, evening) = (place(&plan, 18), place(&plan, 19));
    let range = plan.activities[evening].starts[0];
    let before = &mut plan.activities[noon].starts[0];
    before.cutoff = range.from;
    assert_eq!(clashes(&plan), [""; 0], "half-open");
    plan.activities[noon].starts[0].cutoff = range.from.after(Span::new(1));
    let clashes = clashes(&plan);
    assert_eq!(clashes.len(), 1);
    assert!(clashes[0].contains("`18 weather, noon` and `19 weather, evening`"), "{clashes:?}");
}

#[test]
fn activities_whose_devices_draw_more_than_there_is_are_told_before_anything_runs() {
    let mut mission = mission();
    let mut spare = mission.agents[0].clone();
    spare.name = "spare".into();
    spare.supply = Some(Milliwatts::from_watts(119));
    mission.agents.push(spare);
    for device in mission.devices.iter_mut().filter(|one| one.name == "drill") {
        device.agent = "spare".into();
    }
    let mut plan = (*setting().plan).clone();
    plan.activities.retain(|one| [10, 27].contains(&one.id.get()));
    plan.activities[1].sequence = Some("unheard_of".into());
    let found = plan_fits(&plan, &library(), &mission);
    let words: Vec<_> = found.iter().map(ToString::to_string).collect();
    assert_eq!(
        words,
        [
            "the devices of activity `10 core a sample` draw 120 W at the agent `spare`, which \
             has 119 W",
            "activity 27: no sequence `unheard_of` is known: give the library one",
        ]
    );
    // The control: exactly as much is enough.
    mission.agents[1].supply = Some(Milliwatts::from_watts(120));
    assert_eq!(plan_fits(&plan, &library(), &mission).len(), 1);
}

/// The tasks of the busy sol with another setting and another state.
fn tasks_of(setting: &Setting, state: &State) -> (Vec<Task>, TimedPlan) {
    let problem = Problem::new(&setting.plan, &setting.parameters, state).unwrap();
    let timed = schedule(&problem, None);
    (tasks(setting, &state.windows, &timed, state.now).unwrap(), timed)
}

#[test]
fn nobody_waits_for_a_task_that_is_not_there() {
    let (setting, mut state) = (setting(), state());
    let (ended, started) = (state.now, Some(state.now.before(Span::from_mins(9))));
    let succeeded = |number: u32| Ended {
        id: id(number),
        outcome: Outcome::Succeeded,
        started,
        ended,
        data: Default::default(),
    };
    state.ended = vec![succeeded(2), succeeded(3)];
    let (tasks, _) = tasks_of(&setting, &state);
    let there = |task| tasks.iter().any(|one| one.id == task);
    for one in &tasks {
        assert!(one.after.iter().all(|on| there(on.task)), "{} waits: {:?}", one.id, one.after);
    }
    assert!(tasks.iter().any(|one| one.id.get() == 4), "the drive has what it depends on");
}

#[test]
fn heating_draws_what_the_zone_draws_beside_its_heaters() {
    let mut setting = setting();
    let mut mission = mission();
    for heater in mission.devices.iter_mut().filter(|one| one.name == "heater_wheels") {
        heater.draw = Some(Milliwatts::from_watts(50));
    }
    setting.mission = Arc::new(mission);
    let (tasks, _) = tasks_of(&setting, &state());
    let heating = tasks.iter().find(|one| one.name.as_deref() == Some("heat wheels")).unwrap();
    let zones = &setting.parameters.zones;
    let zone = zones.iter().find(|zone| zone.name == "wheels").unwrap();
    let rest = zone.load.peak.saturating_sub(Milliwatts::from_watts(50));
    assert!(!rest.is_zero());
    assert_eq!(heating.peak_draw, rest);
}

#[test]
fn an_optional_drive_is_told_to_end_and_has_a_grace_as_its_cutoff() {
    let mut setting = setting();
    let mut parameters = (*setting.parameters).clone();
    parameters.mandatory_from = 1_000;
    setting.parameters = Arc::new(parameters);
    let mut library = library();
    let mut steps = library.steps("drive").unwrap().to_vec();
    let last = Step { offset: Duration::from_secs(109 * 60), ..steps[0].clone() };
    steps.push(last.clone());
    library.add("drive", steps);
    setting.library = Arc::new(library);
    let mut plan = (*setting.plan).clone();
    // Only the minimum fits.
    let drive = plan.activities.iter_mut().find(|one| one.id == id(4)).unwrap();
    drive.duration = drive.placed();
    drive.starts[0].from = drive.starts[0].to;
    setting.plan = Arc::new(plan);
    let (tasks, timed) = tasks_of(&setting, &state());
    let slot = timed.slot(id(4)).expect("the drive is planned");
    assert!(slot.length() < Span::from_mins(109));
    let drive = tasks.iter().find(|one| one.id.get() == 4).unwrap();
    let cutoff = slot.end.after(setting.parameters.expansion_grace);
    let range = setting.plan.activities[3].starts[slot.range];
    assert!(cutoff < range.cutoff);
    assert_eq!(drive.cutoff, When::At(setting.epoch.wall(cutoff)));
    let Body::Sequence(steps) = &drive.body else { panic!("it has a sequence") };
    assert!(!steps.contains(&last), "no command after the planned end");
    assert!(!steps.is_empty());
}
