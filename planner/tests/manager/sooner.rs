//! What may start before its planned start, and what may not: in small plans,
//! in which something ends early.

use faregate_agents::Categories;
use faregate_planner::plan::{Kind, StartRange};
use faregate_planner::state::Window;
use faregate_planner::units::{Bytes, Span, Time};
use faregate_planner::{Activity, Plan, State};
use faregate_scheduler::manager::Exit;
use faregate_scheduler::task::Task;
use faregate_tickets::amount::Milliwatts;

use crate::small::{activity, bit, end_of, morning, outside, plan, setting_of, small};
use crate::stage::{Fates, Stage, adding, clock, ends_after, id};

/// Everything begins after this.
const BEGIN: Time = clock(10, 5);

/// Until 10:40 it keeps away who shares a bit with it; in truth until 10:20.
fn first(resources: Categories) -> Activity {
    Activity { resources, priority: 90, ..activity(1, 35, BEGIN) }
}

const EARLY: Time = clock(10, 20);
/// A new plan alone starts nothing before the commit window is over.
const PLANNED_ANEW: Time = clock(10, 25);

fn ends_early() -> Fates {
    Fates::from([(1, ends_after(15, Exit::Code(0)))])
}

fn next(number: u32, resources: Categories, priority: u32) -> Activity {
    Activity { resources, priority, ..activity(number, 10, BEGIN) }
}

fn executed(activities: Vec<Activity>) -> Stage {
    let mut stage = small(activities, ends_early());
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    stage
}

/// The control: so everything here begins.
#[test]
fn what_shares_a_bit_with_what_ends_early_starts_then() {
    let stage = executed(vec![first(bit(0)), next(2, bit(0), 50)]);
    assert_eq!(stage.start_of(2), Some(EARLY));
    let mut waits = small(vec![first(bit(0)), next(2, bit(0), 50)], ends_early());
    waits.director = waits.director.clone().never_early();
    waits.until(clock(13, 0));
    assert_eq!(waits.start_of(2), Some(PLANNED_ANEW));
}

/// Alone the less important one would fit before the other one's planned start.
#[test]
fn of_two_of_which_one_can_start_it_is_the_more_important_one() {
    let stage = executed(vec![first(bit(0)), next(2, bit(0), 60), next(3, bit(0), 70)]);
    assert_eq!(stage.start_of(3), Some(EARLY));
    assert!(stage.start_of(2) >= Some(clock(10, 30)));
}

/// Somebody waits for a gate, and its bit is free as long as it does.
#[test]
fn who_is_due_and_waits_for_its_tickets_is_in_the_way() {
    let sequence = Some("hazard_images".into());
    let waits = Activity { sequence, peak: Milliwatts::from_watts(8), ..next(2, bit(1), 80) };
    let both = bit(0).union(bit(1));
    let mut stage = small(vec![first(bit(0)), waits, next(3, both, 40)], ends_early());
    let gates = vec!["hazard_camera".into()];
    stage.until(clock(10, 1));
    stage.command(vec![adding(Task { gates, ..outside(clock(10, 2), 28) })]);
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert!(stage.start_of(2) >= Some(clock(10, 30)), "it waited");
    assert!(stage.start_of(3) > Some(EARLY), "{:?}", stage.start_of(3));
}

const MB: i64 = 1_000_000;

/// There is room for the data of one, and of the other one after a relay.
#[test]
fn two_that_could_start_early_each_by_itself_do_not_both() {
    let data = |one| Activity { data: Bytes::new(40 * MB), ..one };
    let both = bit(0).union(bit(1));
    let some = vec![first(both), data(next(2, bit(0), 70)), data(next(3, bit(1), 60))];
    let relay = Window {
        name: "relay".into(),
        start: clock(10, 50),
        end: clock(11, 0),
        awake: true,
        marginal: Default::default(),
        peak: Default::default(),
        data: Bytes::new(-30 * MB),
        engines: 0,
        resources: Categories::NONE,
    };
    let setting = setting_of(Plan { max_delta_data: Bytes::new(60 * MB), ..plan(some) });
    let state = State { windows: vec![relay], ..morning() };
    let mut stage = Stage::of(setting, state, ends_early());
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert_eq!(stage.start_of(2), Some(EARLY));
    assert!(stage.start_of(3) >= Some(clock(11, 0)), "{:?}", stage.start_of(3));
}

/// Its task has its planned end as its cutoff.
#[test]
fn an_optional_expanding_one_does_not_start_before_its_planned_start() {
    let kind = Kind::Expanding { minimum: Span::from_mins(10) };
    let drive = |priority| Activity { kind, ..next(2, bit(0), priority) };
    let first = || Activity { priority: 190, ..first(bit(0)) };
    let stage = executed(vec![first(), drive(50)]);
    assert_eq!(stage.start_of(2), Some(PLANNED_ANEW));
    // The control: a mandatory one has its own cutoff.
    let stage = executed(vec![first(), drive(150)]);
    assert_eq!(stage.start_of(2), Some(EARLY));
}

/// Its task has the cutoff of the range in which it is planned: it must be over
/// by that of the range in which it starts.
#[test]
fn nobody_starts_early_with_the_cutoff_of_another_range() {
    let before = StartRange { from: BEGIN, to: PLANNED_ANEW, cutoff: clock(10, 35) };
    let after = StartRange { from: clock(10, 40), to: clock(16, 0), cutoff: clock(17, 30) };
    let first = Activity { priority: 190, ..first(bit(0)) };
    let second = Activity { starts: vec![before, after], ..next(2, bit(0), 150) };
    let mut fates = ends_early();
    fates.insert(2, ends_after(60, Exit::Code(0)));
    let mut stage = small(vec![first, second], fates);
    stage.until(BEGIN);
    let planned = stage.director.timed().slot(id(2)).expect("it is planned");
    assert_eq!((planned.start, planned.range), (clock(10, 40), 1));
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert_eq!(stage.start_of(2), Some(EARLY), "a new plan has it in the first range");
    assert_eq!(end_of(&stage, 2), Some(before.cutoff));
}

fn at_the_mast(one: Activity) -> Activity {
    Activity { zones: vec!["mast".into()], ..one }
}

/// From eleven on, with an end at 11:10 for the first one.
fn warm_until(minutes: i64, holds: i64) -> Stage {
    let eleven = clock(11, 0);
    let first = Activity { resources: bit(1), ..activity(1, holds, eleven) };
    let second = at_the_mast(Activity { resources: bit(1), ..activity(2, 10, eleven) });
    let warm = at_the_mast(Activity { priority: 80, ..activity(3, minutes, eleven) });
    let first = Activity { priority: 70, ..first };
    let mut stage =
        small(vec![first, second, warm], Fates::from([(1, ends_after(10, Exit::Code(0)))]));
    stage.until(clock(14, 0));
    assert_eq!(stage.refused(), [""; 0]);
    stage
}

/// It is warm in the zone, as somebody else is there.
#[test]
fn a_zone_that_another_one_uses_is_warm() {
    let stage = warm_until(40, 30);
    assert_eq!(stage.start_of(2), Some(clock(11, 10)));
}

/// It is warm now, and is to be heated later: nobody waits for a start that the
/// manager would refuse, and a new plan is made at once.
#[test]
fn who_is_to_be_heated_for_is_not_asked_to_start_before_that() {
    let stage = warm_until(25, 70);
    let (_, first) = &stage.plans[0];
    let planned = first.slot(id(2)).expect("it is planned");
    assert_eq!(planned.start, clock(12, 10));
    assert!(first.preheats.iter().any(|heating| heating.end == planned.start));
    assert_eq!(stage.start_of(2), Some(clock(11, 10)), "by a new plan, as others are there");
}
