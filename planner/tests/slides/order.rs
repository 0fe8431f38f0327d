//! "For each activity in priority order": who is placed before whom, at which
//! start, and what the order of the ground means for dependants.

use faregate_agents::Categories;
use faregate_planner::plan::{Activity, Dependency, Outcome, Status};
use faregate_planner::state::{Ended, Mode, Running};
use faregate_planner::timed::{Fate, Limit, Reason};
use faregate_planner::units::Bytes;

use crate::rover::*;

fn on_bit(bit: u8, activity: Activity) -> Activity {
    Activity { resources: Categories::from_mask(1 << bit), ..activity }
}

fn with_priority(priority: u32, activity: Activity) -> Activity {
    Activity { priority, ..activity }
}

fn ended(number: u32, outcome: Outcome, has_started: bool) -> Ended {
    let started = has_started.then_some(min(-40));
    Ended { id: id(number), outcome, started, ended: min(-10), data: Bytes::ZERO }
}

#[test]
fn the_more_important_one_is_placed_first_and_among_equals_the_first_in_the_file() {
    let one = |number, priority| with_priority(priority, on_bit(0, activity(number, 30, 60, 200)));
    let timed = rover(vec![one(1, 10), one(2, 20), one(3, 10)]).timed();
    let slots = [1, 2, 3].map(|number| slot(&timed, number));
    assert_eq!(slots, [Some((90, 120)), Some((60, 90)), Some((120, 150))]);
}

#[test]
fn the_earliest_start_that_all_of_its_timelines_leave_is_taken() {
    let held = on_bit(0, activity(1, 30, 60, 60));
    let busy = Activity { engines: 2, ..activity(2, 30, 90, 90) };
    let needs = |minutes| Activity { engines: 1, ..on_bit(0, activity(3, minutes, 60, 400)) };
    let start = |last: Activity, others: Vec<Activity>| {
        let timed = rover(others.into_iter().chain([last]).collect()).timed();
        slot(&timed, 3).map(|(start, _)| start)
    };
    assert_eq!(start(needs(30), vec![held.clone()]), Some(90), "the bit alone");
    assert_eq!(start(needs(30), vec![busy.clone()]), Some(60), "the engines alone: a hole");
    assert_eq!(start(needs(31), vec![busy.clone()]), Some(120), "the hole is too short");
    assert_eq!(start(needs(30), vec![held, busy]), Some(120), "both of them");
}

#[test]
fn each_of_128_resource_bits_counts_by_itself() {
    for bit in 0..128 {
        let one = on_bit(bit, activity(1, 30, 60, 60));
        let other = |bit| {
            let timed = rover(vec![one.clone(), on_bit(bit, activity(2, 30, 60, 90))]).timed();
            slot(&timed, 2)
        };
        assert_eq!(other(bit), Some((90, 120)), "bit {bit}");
        assert_eq!(other((bit + 1) % 128), Some((60, 90)), "the one beside bit {bit}");
    }
}

#[test]
fn a_start_range_contains_both_its_ends() {
    let held = on_bit(0, activity(1, 30, 60, 60));
    let until = |to| rover(vec![held.clone(), on_bit(0, activity(2, 40, 30, to))]).timed();
    assert_eq!(slot(&until(90), 2), Some((90, 130)));
    assert_eq!(limit(&until(89), 2), Limit::Resources(1));
}

#[test]
fn nothing_runs_after_the_plans_end() {
    let of = |from| {
        let mut short = rover(vec![activity(1, 30, from, 200)]);
        (short.plan.end, short.plan.handover) = (min(100), min(100));
        short.timed()
    };
    assert_eq!(slot(&of(70), 1), Some((70, 100)));
    assert_eq!(reason(&of(71), 1), Reason::NoRangeLeft);
}

#[test]
fn a_dependant_needs_one_of_its_statuses_of_what_has_ended() {
    use Outcome as Is;
    let allowed = [
        (Status::Succeeded, vec![Is::Succeeded]),
        (Status::Failed, vec![Is::Failed]),
        (Status::Aborted, vec![Is::Aborted]),
        (Status::NotStarted, vec![Is::NotStarted]),
        (Status::Completed, vec![Is::Succeeded, Is::Failed]),
    ];
    for (status, allowed) in allowed {
        for outcome in [Is::Succeeded, Is::Failed, Is::Aborted, Is::NotStarted] {
            let after = vec![Dependency { prior: id(1), statuses: vec![status] }];
            let next = Activity { after, ..activity(2, 10, 0, 400) };
            let mut rover = rover(vec![activity(1, 30, -40, -40), next]);
            rover.state.ended = vec![ended(1, outcome, outcome != Is::NotStarted)];
            let timed = rover.timed();
            if allowed.contains(&outcome) {
                assert_eq!(slot(&timed, 2), Some((5, 15)), "{status:?} after {outcome:?}");
            } else {
                let said = Reason::PriorEnded(id(1), outcome);
                assert_eq!(reason(&timed, 2), said, "{status:?} after {outcome:?}");
            }
        }
    }
}

/// To put priors first is the ground's work: here somebody in between has the
/// place that the dependant would have had.
#[test]
fn a_dependant_above_its_prior_takes_what_is_left_when_everything_else_is_placed() {
    let of = |dependant, prior| {
        let after = vec![Dependency { prior: id(1), statuses: vec![Status::Succeeded] }];
        let next = on_bit(0, Activity { after, ..activity(2, 10, 60, 400) });
        let between = with_priority(30, on_bit(0, activity(3, 90, 90, 200)));
        let first = with_priority(prior, activity(1, 30, 60, 60));
        let timed = rover(vec![first, with_priority(dependant, next), between]).timed();
        (slot(&timed, 2), slot(&timed, 3))
    };
    assert_eq!(of(50, 60), (Some((90, 100)), Some((100, 190))), "in the order of dependencies");
    assert_eq!(of(50, 10), (Some((180, 190)), Some((90, 180))), "not in that order");
}

#[test]
fn a_member_that_has_started_has_used_its_group_up_and_one_that_was_vetoed_has_not() {
    let member = |it: Activity| Activity { group: Some("image".into()), ..it };
    let mut two = rover(vec![member(activity(1, 30, -40, -40)), member(activity(2, 10, 60, 90))]);
    for outcome in [Outcome::Succeeded, Outcome::Failed, Outcome::Aborted] {
        two.state.ended = vec![ended(1, outcome, true)];
        assert_eq!(reason(&two.timed(), 2), Reason::GroupTaken(id(1)), "{outcome:?}");
    }
    two.state.ended = vec![ended(1, Outcome::NotStarted, false)];
    assert_eq!(slot(&two.timed(), 2), Some((60, 70)));
    let (started, ends) = (min(-40), min(20));
    let running =
        Running { id: id(1), started, ends, cutoff: ends, paused: None, data: Bytes::ZERO };
    two.state.ended = Vec::new();
    two.state.running = vec![running];
    two.state.mode = Mode::Awake;
    assert_eq!(reason(&two.timed(), 2), Reason::GroupTaken(id(1)));
}

#[test]
fn more_activities_run_when_more_power_is_available() {
    let count = |wh| {
        let hungry = (1..8).map(|number| drawing(160, activity(number, 60, 0, 300))).collect();
        let mut rover = rover(hungry);
        rover.state.charge = watt_hours(wh);
        let rows = rover.timed().rows;
        rows.iter().filter(|row| matches!(row.fate, Fate::Scheduled(_))).count()
    };
    let counts = [350, 500, 800].map(count);
    assert!(counts[0] < counts[1] && counts[1] < counts[2], "{counts:?}");
}
