//! What would let an activity in: each number by itself, no more of it than it
//! takes.

use faregate_agents::Categories;
use faregate_planner::explain::{Change, Explanation, Number, Relaxation, Whose, explain};
use faregate_planner::parameters::{TimelineKind, TimelineSpec};
use faregate_planner::plan::{
    Activity, Constraint, Dependency, Effect, Impact, Kind, StartRange, Status,
};
use faregate_planner::timed::{Limit, Reason};
use faregate_planner::units::{Bytes, Span, Time};

use crate::rover::*;

const MINUTE: i64 = 60_000;

fn told(rover: &Rover, number: u32) -> Explanation {
    explain(&rover.problem(), None, id(number)).expect("it is a candidate")
}

/// The plan made again after the change: when it starts.
fn with(rover: &Rover, number: u32, relaxation: &Relaxation) -> Option<Time> {
    let mut changed = rover.clone();
    relaxation.apply(id(number), &mut changed.plan, &mut changed.parameters);
    changed.timed().slot(id(number)).map(|slot| slot.start)
}

/// Each change of a limit, after it was seen to be as small as can be: with it
/// the activity is in, and with one unit less it is not.
fn changes(rover: &Rover, number: u32, limit: fn(&Limit) -> bool) -> Vec<Change> {
    assert_eq!(slot(&rover.timed(), number), None, "it is left out");
    let all = told(rover, number).relaxations.into_iter().filter(|it| limit(&it.limit));
    let changes = all.filter_map(|it| Some((it.change?, it)));
    let seen = changes.map(|(change, relaxation)| {
        assert_eq!(with(rover, number, &relaxation), Some(change.start), "{relaxation:?}");
        let by = change.by - 1;
        let less = Relaxation { change: Some(Change { by, ..change }), ..relaxation };
        if change.number != Number::Without {
            assert_eq!(with(rover, number, &less), None, "{less:?}");
        }
        change
    });
    seen.collect()
}

/// What is changed, by how much, and the minute of the start.
fn first(rover: &Rover, number: u32, limit: fn(&Limit) -> bool) -> (Number, i64, i64) {
    let all = changes(rover, number, limit);
    let first = all.first().unwrap_or_else(|| panic!("{:?}", told(rover, number)));
    (first.number, first.by, first.start.get() / MINUTE)
}

fn on_bit(mask: u128, activity: Activity) -> Activity {
    Activity { resources: Categories::from_mask(mask), ..activity }
}

#[test]
fn of_data_peak_and_engines_it_says_how_much_more() {
    let data = |number, bytes, priority| Activity {
        data: Bytes::new(bytes),
        priority,
        ..activity(number, 30, 60, 60)
    };
    let full = rover(vec![data(1, 900, MANDATORY), data(2, 200, 10)]);
    assert_eq!(first(&full, 2, |it| *it == Limit::Data), (Number::Limit, 100, 60));
    let watts = |number, watts| drawing(watts, activity(number, 30, 60, 60));
    let strained = rover(vec![watts(1, 120), watts(2, 111)]);
    assert_eq!(first(&strained, 2, |it| *it == Limit::Peak), (Number::Limit, 1_000, 60));
    let engine = |number| Activity { engines: 1, ..activity(number, 30, 60, 60) };
    let busy = rover(vec![engine(1), engine(2), engine(3)]);
    assert_eq!(first(&busy, 3, |it| *it == Limit::Engines), (Number::Limit, 1, 60));
}

#[test]
fn of_a_minimum_of_charge_it_says_how_many_millionths_less() {
    let mut hungry = rover(vec![drawing(160, activity(1, 60, 0, 60))]);
    hungry.state.charge = watt_hours(350);
    let (number, by, start) = first(&hungry, 1, |it| *it == Limit::SoftMinimum);
    // 350 Wh, 55 min at 80 W, 5 min at 40 W, an hour at -140 W: 286.7 of 1000.
    // A millionth is a part of a Wh, so that it may be some seconds before 60.
    assert_eq!((number, by), (Number::Limit, 13_334));
    assert!((59..=60).contains(&start), "{start}");
    let mut frugal = rover(vec![drawing(160, activity(1, 60, 0, 0))]);
    frugal.state.mode = faregate_planner::state::Mode::Awake;
    frugal.plan.handover = min(180);
    frugal.plan.handover_min_soc = faregate_planner::units::Ppm::new(800_000);
    let (number, by, start) = first(&frugal, 1, |it| *it == Limit::Handover);
    assert_eq!((number, start), (Number::Limit, 0));
    assert!((1..800_000).contains(&by), "{by}");
}

#[test]
fn of_resource_bits_it_says_which_and_who_holds_them_until_when() {
    let held = rover(vec![
        on_bit(0b0011, activity(1, 30, 60, 60)),
        on_bit(0b1000, activity(2, 30, 60, 60)),
        on_bit(0b0110, activity(3, 30, 60, 60)),
    ]);
    let all = changes(&held, 3, |it| matches!(it, Limit::Resources(_)));
    let [change] = all.as_slice() else { panic!("{all:?}") };
    assert_eq!((change.number, change.by), (Number::Without, 0));
    assert_eq!((change.with, change.until), (Some(id(1)), Some(min(90))));
    let limits = told(&held, 3).relaxations.into_iter().map(|it| it.limit);
    assert!(limits.into_iter().any(|it| it == Limit::Resources(0b0010)), "one bit is enough");
}

#[test]
fn of_a_dependency_it_says_on_whom() {
    let after = vec![Dependency { prior: id(1), statuses: vec![Status::Succeeded] }];
    let next = Activity { after, ..activity(2, 10, 0, 400) };
    let waiting = rover(vec![activity(1, 30, 0, 0), next]);
    let all = changes(&waiting, 2, |it| *it == Limit::Dependency);
    assert_eq!(
        all.iter().map(|it| (it.with, it.start)).collect::<Vec<_>>(),
        [(Some(id(1)), min(5))]
    );
}

#[test]
fn of_start_ranges_it_says_which_end_of_which_one() {
    let mut held =
        rover(vec![on_bit(1, activity(1, 400, 60, 60)), on_bit(1, activity(2, 30, 100, 120))]);
    let is_range: fn(&Limit) -> bool = |it| *it == Limit::Range;
    assert_eq!(first(&held, 2, is_range), (Number::From(0), 70 * MINUTE, 30));
    held.plan.activities[0].starts[0] = StartRange { from: min(5), to: min(5), cutoff: min(405) };
    assert_eq!(first(&held, 2, is_range), (Number::To(0), 285 * MINUTE, 405));
    let mut short = activity(1, 30, 60, 90);
    short.starts[0].cutoff = min(85);
    let all = changes(&rover(vec![short]), 1, is_range);
    let said: Vec<_> = all.iter().map(|it| (it.number, it.by / MINUTE, it.start)).collect();
    assert_eq!(said, [(Number::From(0), 5, min(55)), (Number::Cutoff(0), 5, min(60))]);
}

fn named(mut rover: Rover, name: &str, kind: TimelineKind, (initial, max): (i64, i64)) -> Rover {
    let name = name.to_owned();
    rover.parameters.timelines.push(TimelineSpec { name, kind, initial, min: 0, max });
    rover
}

fn touching(timeline: &str, effect: Effect, activity: Activity) -> Activity {
    Activity { impacts: vec![Impact { timeline: timeline.into(), effect }], ..activity }
}

#[test]
fn of_a_named_timeline_it_says_whose_minimum_or_maximum() {
    let is_line: fn(&Limit) -> bool = |it| matches!(it, Limit::Timeline(_));
    let drill = touching("tubes", Effect::AddAtStart(-3), activity(1, 30, 60, 60));
    let empty = named(rover(vec![drill]), "tubes", TimelineKind::Consumable, (1, 40));
    assert_eq!(first(&empty, 1, is_line), (Number::Least(Whose::Timeline), 2, 60));
    let asks = |number, max| {
        let constraint = Constraint { timeline: "arm".into(), min: 0, max };
        Activity { constraints: vec![constraint], ..activity(number, 30, 60, 60) }
    };
    let out = named(rover(vec![asks(1, 1)]), "arm", TimelineKind::State, (3, 9));
    let own = Number::Most(Whose::Constraint(id(1), 0));
    assert_eq!(first(&out, 1, is_line), (own, 2, 60));
    let moves = touching("arm", Effect::SetAtStart(5), activity(2, 10, 70, 70));
    let other = named(rover(vec![asks(1, 4), moves]), "arm", TimelineKind::State, (3, 9));
    let theirs = Number::Most(Whose::Constraint(id(1), 0));
    assert_eq!(first(&other, 2, is_line), (theirs, 1, 70));
}

#[test]
fn of_a_unit_it_says_who_holds_it_until_when() {
    let holds = |number| touching("bus", Effect::Hold(1), activity(number, 30, 60, 60));
    let taken = named(rover(vec![holds(1), holds(2)]), "bus", TimelineKind::Unit, (0, 1));
    let all = changes(&taken, 2, |it| matches!(it, Limit::Timeline(_)));
    let [change] = all.as_slice() else { panic!("{all:?}") };
    assert_eq!((change.number, change.with), (Number::Without, Some(id(1))));
    assert_eq!(change.until, Some(min(90)));
}

const IS_COMPUTER: fn(&Limit) -> bool = |it| *it == Limit::Computer;

fn night(minutes: i64, from: i64) -> Activity {
    let (shutdown, wakeup) = (Span::from_mins(5), Span::from_mins(5));
    Activity { kind: Kind::ManualShutdown { shutdown, wakeup }, ..activity(2, minutes, from, from) }
}

fn told_of_computer(rover: &Rover) -> Vec<(Number, i64, Time)> {
    let all = changes(rover, 1, IS_COMPUTER).into_iter();
    all.map(|it| (it.number, it.by / MINUTE, it.start)).collect()
}

#[test]
fn of_a_manual_shutdown_it_says_how_much_shorter_or_how_far_away() {
    let down = rover(vec![activity(1, 30, 350, 380), night(300, 100)]);
    let said = told_of_computer(&down);
    let shorter = (Number::Shutdown(id(2)), 20, min(380));
    assert_eq!(said, [shorter, (Number::Earlier(id(2)), 20, min(380))], "either is enough");
    let within = rover(vec![activity(1, 30, 102, 104), night(300, 100)]);
    let later = (Number::Later(id(2)), 32, min(102));
    assert_eq!(told_of_computer(&within), [later], "shutting down alone takes until 105");
}

#[test]
fn a_manual_shutdown_is_not_moved_to_where_something_is() {
    let beside = |at| Activity { priority: 20, ..activity(3, 30, at, at) };
    let of = |at| rover(vec![activity(1, 30, 350, 380), beside(at), night(300, 100)]);
    let moved = |rover: &Rover| told_of_computer(rover).into_iter().map(|(it, ..)| it).collect();
    let both: Vec<Number> = moved(&of(50));
    assert_eq!(
        both,
        [Number::Shutdown(id(2)), Number::Earlier(id(2))],
        "from minute 80 on it fits"
    );
    let both: Vec<Number> = moved(&of(51));
    assert_eq!(both, [Number::Shutdown(id(2)), Number::Later(id(2))], "what is there ends at 81");
    let mut pass = of(20);
    let window = |from: i64| faregate_planner::state::Window {
        name: "pass".into(),
        start: min(from),
        end: min(from + 10),
        awake: true,
        marginal: Default::default(),
        peak: Default::default(),
        data: Bytes::ZERO,
        engines: 0,
        resources: Categories::NONE,
    };
    pass.state.windows = vec![window(85)];
    let both: Vec<Number> = moved(&pass);
    assert_eq!(both, [Number::Shutdown(id(2)), Number::Later(id(2))], "a window is there");
}

#[test]
fn what_no_other_time_of_a_manual_shutdown_is_enough_for_would_need_none() {
    let mut short = rover(vec![activity(1, 30, 102, 104), night(300, 100)]);
    (short.plan.end, short.plan.handover) = (min(420), min(420));
    assert_eq!(told_of_computer(&short), [(Number::Without, 0, min(102))]);
}

#[test]
fn of_the_time_before_it_says_what_would_take_less() {
    let arm = Activity { zones: vec!["arm".into()], ..activity(1, 30, 10, 10) };
    let heated = rover(vec![arm]);
    assert_eq!(limit(&heated.timed(), 1), Limit::Lead);
    let is_lead: fn(&Limit) -> bool = |it| *it == Limit::Lead;
    assert_eq!(first(&heated, 1, is_lead), (Number::Heating(0, 0), 15 * MINUTE, 10));
    assert_eq!(first(&heated, 1, |it| *it == Limit::Range), (Number::To(0), 15 * MINUTE, 25));
    let soon = rover(vec![activity(1, 30, 3, 3)]);
    assert_eq!(first(&soon, 1, is_lead), (Number::Wakeup, 2 * MINUTE, 3));
}

#[test]
fn what_two_limits_keep_out_no_single_change_lets_in() {
    let both = Activity { data: Bytes::new(1_100), ..drawing(400, activity(1, 30, 60, 60)) };
    let told = told(&rover(vec![both]), 1);
    let said: Vec<_> = told.relaxations.iter().map(|it| (&it.limit, it.change)).collect();
    assert_eq!(said, [(&Limit::Data, None), (&Limit::Peak, None)]);
}

#[test]
fn a_reason_says_when_there_is_too_much_data_by_the_most() {
    let data = |number, bytes, from, priority| Activity {
        data: Bytes::new(bytes),
        priority,
        ..activity(number, 30, from, from)
    };
    let full = rover(vec![
        data(1, 900, 60, MANDATORY),
        data(3, 400, 200, MANDATORY),
        data(2, 200, 90, 10),
    ]);
    let Reason::Limit { limit, at, amount, .. } = reason(&full.timed(), 2) else { panic!() };
    assert_eq!((limit, at, amount), (Limit::Data, min(200), 500));
}
