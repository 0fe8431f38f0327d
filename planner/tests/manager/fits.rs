//! Whether parameters, missions and plans agree.

use std::sync::Arc;

use faregate_planner::timed::Fate;

use faregate_planner::tasks::{Disagreement, Misfit, mission_fits, tasks};
use faregate_planner::{Problem, schedule};
use faregate_tickets::amount::Milliwatts;

use crate::stage::{mission, parameters, setting, state};

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
