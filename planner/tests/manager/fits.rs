//! Whether parameters, missions and plans agree.

use std::sync::Arc;

use faregate_planner::timed::Fate;

use faregate_planner::plan::{Dependency, Status};
use faregate_planner::tasks::{Disagreement, Misfit, mission_fits, plan_fits, tasks};
use faregate_planner::units::Span;
use faregate_planner::{Plan, Problem, schedule};
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
