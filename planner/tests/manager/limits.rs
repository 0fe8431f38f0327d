//! More attempts: while nothing can be planned, while something is paused, with
//! the battery empty, with the ground's own shutdown to come.

use std::sync::Arc;

use faregate_planner::plan::{Dependency, Kind, Outcome, StartRange, Status};
use faregate_planner::state::{Mode, Window};
use faregate_planner::tasks::{NotPlanned, Setting, tasks};
use faregate_planner::timed::AwakePhase;
use faregate_planner::units::Span;
use faregate_planner::{Activity, Parameters, Problem, State, schedule};
use faregate_scheduler::manager::{Exit, Telecommand};
use faregate_scheduler::task::{Task, When};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::attacks::{for_ever, mandatory, outcome};
use crate::small::{activity, bit, end_of, morning, outside, plan, setting_of, small};
use crate::stage::{Fates, Stage, adding, clock, ends_after, id, task_id};

/// A zone is found cold while no new plan can be made.
#[test]
fn what_must_not_start_is_held_though_there_is_no_new_plan() {
    let one = Activity { zones: vec!["mast".into()], ..activity(1, 8, clock(11, 30)) };
    let mut stage = small(vec![one], Fates::new());
    stage.until(clock(11, 29));
    let (mut director, now) = (stage.director.clone(), clock(11, 29));
    let over_before_it_begins = Window {
        name: "nonsense".into(),
        start: clock(15, 0),
        end: clock(14, 0),
        awake: true,
        marginal: Milliwatts::ZERO,
        peak: Milliwatts::ZERO,
        data: Default::default(),
        engines: 0,
        resources: bit(3),
    };
    director.windows(vec![over_before_it_begins]);
    director.zone_is_cold("mast");
    let orders = director.turn(now).expect("there is something to be told");
    assert_eq!(orders, [Telecommand::Hold(task_id(1))]);
    assert!(matches!(director.turn(now), Err(NotPlanned::Unfit(_))), "and this besides");
    director.zone_is_warm("mast");
    assert_eq!(director.turn(now).expect("so it is"), [Telecommand::Resume(task_id(1))]);
}

/// Its resource is taken for an hour, and its tickets are to come back.
#[test]
fn the_computer_stays_up_for_what_is_paused() {
    let one = Activity { pausable: true, resources: bit(4), ..activity(1, 20, clock(10, 10)) };
    let mut stage = small(vec![one], Fates::new());
    stage.until(clock(10, 15));
    stage.command(vec![adding(Task { categories: bit(4), ..outside(clock(10, 15), 60) })]);
    for minute in 16..=74 {
        let now = clock(10, minute);
        stage.until(now);
        let up = |phase: &AwakePhase| phase.up <= now && now < phase.down;
        assert!(stage.director.timed().awake.iter().any(up), "at {now}");
    }
    stage.until(clock(13, 0));
    let end = end_of(&stage, 1).expect("it goes on");
    assert!(end >= clock(11, 29), "the pause is not counted");
    assert!(stage.starts_of_task("shutdown").iter().all(|at| *at >= end));
    assert_eq!(stage.refused(), [""; 0]);
}

/// The ground wants the computer off, and something has not ended.
#[test]
fn nothing_runs_on_into_a_manual_shutdown() {
    let five = Span::from_mins(5);
    let (begin, end) = (clock(11, 0), clock(12, 0));
    let kind = Kind::ManualShutdown { shutdown: five, wakeup: five };
    let starts = vec![StartRange { from: begin, to: begin, cutoff: end }];
    let block = Activity { kind, starts, ..activity(9, 60, begin) };
    let long = mandatory(activity(1, 8, clock(10, 50)));
    let mut stage = small(vec![long, block], for_ever());
    stage.until(clock(14, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert_eq!((end_of(&stage, 1), outcome(&stage, 1)), (Some(begin), Some(Outcome::Aborted)));
    assert_eq!(stage.starts_of_task("shutdown").first(), Some(&begin));
}

/// So many hundredths of what the battery can hold.
fn percent(stage: &Stage, percent: u64) -> Option<Microjoules> {
    Some(Microjoules::new(stage.director.state().capacity.get() / 100 * percent))
}

fn drawing(one: Activity) -> Activity {
    Activity { marginal: Milliwatts::from_watts(20), peak: Milliwatts::from_watts(20), ..one }
}

/// The hard limit is 30 %, the soft one 40 %.
#[test]
fn at_the_hard_limit_what_draws_is_aborted_and_nothing_starts_before_it_has_recovered() {
    let some = vec![
        mandatory(drawing(activity(1, 60, clock(10, 10)))),
        mandatory(activity(2, 60, clock(10, 10))),
        // It is committed when the limit is reached.
        mandatory(drawing(activity(3, 10, clock(10, 24)))),
        Activity { kind: Kind::StayAwake, ..mandatory(activity(4, 300, clock(10, 0))) },
    ];
    let mut stage = small(some, Fates::new());
    stage.until(clock(10, 20));
    stage.measured = percent(&stage, 30);
    stage.until(clock(10, 21));
    assert_eq!(outcome(&stage, 1), None, "the limit is not below it");
    stage.measured = percent(&stage, 29);
    stage.until(clock(10, 22));
    assert_eq!(outcome(&stage, 1), Some(Outcome::Aborted));
    assert_eq!(outcome(&stage, 2), None, "it draws nothing");
    stage.measured = percent(&stage, 39);
    stage.until(clock(10, 50));
    assert_eq!(stage.start_of(3), None);
    stage.measured = percent(&stage, 60);
    stage.until(clock(11, 0));
    assert!(stage.start_of(3) >= Some(clock(10, 50)));
    stage.until(clock(12, 0));
    assert_eq!(outcome(&stage, 2), Some(Outcome::Succeeded));
    assert_eq!(stage.refused(), [""; 0]);
}

#[test]
fn below_the_soft_limit_what_is_optional_is_aborted_and_what_is_mandatory_goes_on() {
    let some = vec![
        mandatory(drawing(activity(1, 60, clock(10, 10)))),
        drawing(activity(2, 60, clock(10, 10))),
    ];
    let mut stage = small(some, Fates::new());
    stage.until(clock(10, 20));
    stage.measured = percent(&stage, 40);
    stage.until(clock(10, 21));
    assert_eq!(outcome(&stage, 2), None, "the limit is not below it");
    stage.measured = percent(&stage, 39);
    for minute in 22..30 {
        stage.until(clock(10, minute));
    }
    assert_eq!(outcome(&stage, 2), Some(Outcome::Aborted));
    stage.until(clock(12, 0));
    assert_eq!(outcome(&stage, 1), Some(Outcome::Succeeded));
    assert_eq!(stage.refused(), [""; 0]);
}

/// The mission has less power than the plan was made for.
#[test]
fn what_can_never_run_is_given_up_also_where_the_computer_is_to_be_woken_for_it() {
    let prior = Dependency { prior: id(1), statuses: vec![Status::NotStarted] };
    let some = vec![
        Activity { peak: Milliwatts::from_watts(300), ..activity(1, 10, clock(12, 0)) },
        Activity { after: vec![prior], ..activity(2, 10, clock(12, 0)) },
    ];
    let mut mission = crate::stage::mission();
    mission.agents[0].supply = Some(Milliwatts::from_watts(299));
    let setting = Setting { mission: Arc::new(mission), ..setting_of(plan(some)) };
    let mut stage = Stage::of(setting, morning(), Fates::new());
    stage.until(clock(10, 1));
    assert_eq!(outcome(&stage, 1), Some(Outcome::NotStarted), "at once");
    stage.until(clock(15, 0));
    assert_eq!(stage.start_of(1), None);
    assert_eq!(outcome(&stage, 2), Some(Outcome::Succeeded), "it was to come in its place");
}

/// It starts while the computer sleeps, and long before that is woken.
#[test]
fn what_takes_no_time_needs_no_computer() {
    let asleep = State { mode: Mode::Asleep, mode_since: clock(7, 0), ..morning() };
    let some = vec![activity(1, 0, clock(11, 0)), activity(2, 20, clock(14, 0))];
    let mut stage = Stage::of(setting_of(plan(some)), asleep, Fates::new());
    stage.until(clock(13, 57));
    let state = stage.director.state();
    assert_eq!((state.mode, state.mode_since), (Mode::WakingUp, clock(13, 55)));
    stage.until(clock(15, 0));
    assert_eq!(stage.start_of(1), Some(clock(11, 0)));
    assert_eq!(stage.start_of(2), Some(clock(14, 0)));
    assert_eq!(stage.refused(), [""; 0]);
}

/// It is the last one of its phase, and over before the computer's draw ends.
#[test]
fn nothing_is_so_short_that_it_could_not_be_started() {
    let one = Activity { duration: Span::new(50), ..activity(1, 0, clock(10, 10)) };
    let setting = setting_of(plan(vec![one]));
    let problem = Problem::new(&setting.plan, &setting.parameters, &morning()).unwrap();
    let timed = schedule(&problem, None);
    let tasks = tasks(&setting, &[], &timed, morning().now).unwrap();
    let task = tasks.iter().find(|task| task.id == task_id(1)).expect("it is planned");
    let slot = timed.slot(id(1)).expect("it is planned");
    assert_eq!(timed.awake[0].down, slot.end);
    let wall = |at| When::At(setting.epoch.wall(at));
    assert_eq!((task.windows[0].opens, task.windows[0].closes), (wall(slot.start), wall(slot.end)));
}

/// A pass that nobody knew of takes a part of the drive's time; what comes after
/// the drive stays where it is.
#[test]
fn who_waits_for_a_task_that_becomes_shorter_is_not_lost() {
    let kind = Kind::Expanding { minimum: Span::from_mins(20) };
    let drive = Activity { kind, resources: bit(0), ..activity(1, 60, clock(10, 30)) };
    let prior = Dependency { prior: id(1), statuses: vec![Status::Succeeded] };
    let then = Activity { after: vec![prior], ..activity(2, 10, clock(12, 0)) };
    let mut stage = small(vec![drive, then], Fates::new());
    stage.until(clock(10, 5));
    let end = |stage: &Stage| stage.director.timed().slot(id(1)).map(|slot| slot.end);
    assert_eq!(end(&stage), Some(clock(11, 30)));
    let pass = Window {
        name: "pass".into(),
        start: clock(11, 10),
        end: clock(11, 40),
        awake: true,
        marginal: Milliwatts::ZERO,
        peak: Milliwatts::ZERO,
        data: Default::default(),
        engines: 0,
        resources: bit(0),
    };
    stage.director.windows(vec![pass]);
    stage.until(clock(10, 6));
    assert_eq!(end(&stage), Some(clock(11, 10)));
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert_eq!(stage.start_of(2), Some(clock(12, 0)));
    assert_eq!(outcome(&stage, 2), Some(Outcome::Succeeded));
}

/// The mast was heated an hour ago, and used; what cleans up there is wanted at
/// once, and the heat of then is gone.
#[test]
fn heat_that_was_used_does_not_count_for_who_comes_an_hour_later() {
    let at_the_mast = |one| Activity { zones: vec!["mast".into()], ..one };
    let statuses = vec![Status::Failed];
    let after = vec![Dependency { prior: id(2), statuses }];
    let cleanup = Activity { kind: Kind::Cleanup, after, ..activity(3, 5, clock(10, 0)) };
    let some = vec![
        at_the_mast(activity(1, 10, clock(11, 0))),
        activity(2, 30, clock(11, 30)),
        at_the_mast(cleanup),
    ];
    let failed = Exit::Failed("no image".into());
    let mut stage = small(some, Fates::from([(2, ends_after(30, failed))]));
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    let heated = stage.starts_of_heating("mast");
    assert_eq!(heated, [clock(10, 45), clock(12, 0)]);
    assert_eq!(stage.start_of(3), Some(clock(12, 15)));
}

/// It is shorter than the time for which somebody has its resource, and the
/// computer, which sleeps and wakes in no time, was up for nothing else.
#[test]
fn what_is_missed_as_the_computer_falls_asleep_is_planned_again() {
    let one = Activity {
        duration: Span::new(300),
        resources: bit(4),
        ..mandatory(activity(1, 0, clock(10, 10)))
    };
    let mut setting = setting_of(plan(vec![one]));
    let mut parameters = Parameters::clone(&setting.parameters);
    (parameters.min_awake, parameters.min_sleep) = (Span::ZERO, Span::from_mins(1));
    (parameters.wakeup.duration, parameters.shutdown.duration) = (Span::ZERO, Span::ZERO);
    setting.parameters = Arc::new(parameters);
    let mut stage = Stage::of(setting, morning(), Fates::new());
    stage.until(clock(10, 9));
    stage.command(vec![adding(Task { categories: bit(4), ..outside(clock(10, 9), 2) })]);
    stage.until(clock(10, 30));
    assert_eq!(stage.refused(), [""; 0]);
    assert!(stage.start_of(1) >= Some(clock(10, 11)), "{:?}", stage.start_of(1));
    assert_eq!(outcome(&stage, 1), Some(Outcome::Succeeded));
}
