//! The busy sol.

use faregate_planner::plan::Outcome;
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::units::{Bytes, Span, Time};
use faregate_planner::{Plan, Problem, State, schedule};
use faregate_scheduler::manager::{Exit, Note};
use faregate_scheduler::task::{Body, Preemption, Task, TaskPriority};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

use crate::stage::{Fates, Stage, adding, clock, ends_after, id, setting, state, task_id};

fn scheduled(timed: &TimedPlan) -> Vec<(u32, Time)> {
    let rows = timed.rows.iter().filter_map(|row| match row.fate {
        Fate::Scheduled(slot) => Some((row.id.get(), slot.start)),
        _ => None,
    });
    rows.collect()
}

#[test]
fn every_scheduled_activity_runs_in_its_slot_and_its_outcome_comes_back() {
    let mut stage = Stage::new(Fates::new());
    let end = stage.plan().end;
    stage.until(end);
    assert_eq!(stage.refused(), [""; 0]);
    let (_, first) = &stage.plans[0];
    let planned = scheduled(first);
    assert!(planned.len() >= 15, "the sol is busy: {}", planned.len());
    let tolerance = setting().parameters.handover_tolerance;
    for (number, start) in planned {
        let last = stage.plans.iter().rev().find_map(|(_, timed)| {
            scheduled(timed).into_iter().find(|(other, _)| *other == number)
        });
        let planned = last.map_or(start, |(_, start)| start);
        let really = stage.start_of(number);
        let late = really.map(|really| really.since(planned));
        assert!(
            late.is_some_and(|late| (Span::ZERO..=tolerance).contains(&late)),
            "activity {number}: {really:?} is not {planned}"
        );
        let ended = stage.director.state().ended.iter().find(|ended| ended.id == id(number));
        assert_eq!(ended.map(|ended| ended.outcome), Some(Outcome::Succeeded), "{number}");
    }
    assert!(stage.director.state().running.is_empty());
}

fn outcome(stage: &Stage, number: u32) -> Option<Outcome> {
    let ended = stage.director.state().ended.iter().find(|ended| ended.id == id(number));
    ended.map(|ended| ended.outcome)
}

#[test]
fn a_failed_drive_has_its_cleanup_and_none_of_what_counted_on_it() {
    let fates = Fates::from([(4, ends_after(30, Exit::Failed("a wheel is stuck".into())))]);
    let mut stage = Stage::new(fates);
    stage.until(clock(12, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert_eq!(outcome(&stage, 4), Some(Outcome::Failed));
    // Who cleans up need not wait for the end of the commit window.
    let failed = stage.start_of(4).unwrap().after(Span::from_mins(30));
    assert_eq!(stage.start_of(5), Some(failed));
    assert_eq!(outcome(&stage, 5), Some(Outcome::Succeeded));
    stage.until(clock(17, 0));
    // The arm is placed after a drive that succeeded, images are taken after any.
    assert_eq!(stage.start_of(7), None);
    assert!(stage.start_of(6).is_some());
}

/// A drive that succeeds needs no cleanup.
#[test]
fn a_cleanup_does_not_run_for_a_drive_that_succeeded() {
    let mut stage = Stage::new(Fates::new());
    stage.until(clock(16, 0));
    assert_eq!(stage.start_of(5), None);
}

/// Somebody more important than everything takes this much power.
fn emergency(watts: u32, minutes: u64) -> Task {
    Task {
        priority: TaskPriority::TOP,
        peak_draw: Milliwatts::from_watts(watts),
        duration: Duration::from_secs(60 * minutes),
        preemption: Preemption::Wait,
        ..Task::new(task_id(9_000), Body::Hold)
    }
}

#[test]
fn an_emergency_takes_heater_power_and_the_zone_is_heated_again_from_scratch() {
    let mut stage = Stage::new(Fates::new());
    stage.until(clock(9, 40));
    let heated = |stage: &Stage| {
        let (_, timed) = stage.plans.last().unwrap();
        let of_wheels = timed.preheats.iter().find(|heating| heating.zone == "wheels").cloned();
        of_wheels.map(|heating| (heating.start, heating.end)).unwrap()
    };
    let (start, end) = heated(&stage);
    assert!(start <= clock(9, 40) && clock(9, 41) < end, "the wheels are being heated");
    let full = end.since(start);
    assert_eq!(stage.director.state().heating.get("wheels"), Some(&start));
    // Heater power goes first: the drive is less important than what else runs.
    stage.command(vec![adding(emergency(150, 1))]);
    stage.until(clock(9, 42));
    let lost = |note: &Note| matches!(note, Note::Preempted(_));
    assert_eq!(stage.story.iter().filter(|(_, note)| lost(note)).count(), 1);
    assert_eq!(stage.director.state().cold, ["wheels"], "it is heated, and not yet warm");
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    // It had no power for a minute: the last plan before the drive heats anew.
    let driven = stage.start_of(4).unwrap();
    let again = stage.starts_of_heating("wheels").into_iter().find(|at| *at >= clock(9, 40));
    assert_eq!(again.map(|again| driven.since(again)), Some(full), "all of it, from scratch");
    assert!(driven >= clock(9, 41).after(full));
    assert!(stage.director.state().cold.is_empty(), "and then it is warm");
}

/// The control: a draw that is there for all takes nothing.
#[test]
fn a_draw_that_fits_beside_the_others_takes_no_heater_power() {
    let mut stage = Stage::new(Fates::new());
    stage.until(clock(9, 40));
    stage.command(vec![adding(emergency(20, 1))]);
    stage.until(clock(9, 42));
    assert!(!stage.story.iter().any(|(_, note)| matches!(note, Note::Preempted(_))));
    stage.until(clock(13, 0));
    assert_eq!(stage.start_of(4), Some(clock(10, 30)));
}

#[test]
fn a_condition_that_does_not_hold_at_dispatch_keeps_the_drive_waiting() {
    let mut stage = Stage::new(Fates::new());
    stage.until(clock(10, 20));
    stage.director.variable("drive_permitted", Some(0));
    stage.until(clock(10, 40));
    assert_eq!(stage.start_of(4), None);
    let pushed = stage.director.incumbent().slot(id(4)).map(|slot| slot.start);
    assert!(pushed >= Some(clock(10, 40)), "nothing is planned into the past: {pushed:?}");
    stage.director.variable("drive_permitted", Some(1));
    stage.until(clock(10, 41));
    assert_eq!(stage.start_of(4), Some(clock(10, 40)), "in its range still");
    assert_eq!(stage.refused(), [""; 0]);
}

#[test]
fn what_can_be_paused_goes_on_and_what_cannot_is_aborted() {
    // Laser spectra can be paused; the arm's camera is more important, and
    // cannot.
    let mut stage = Stage::new(Fates::new());
    stage.until(clock(12, 20));
    let runs = |stage: &Stage| {
        let running = &stage.director.state().running;
        running.iter().map(|one| (one.id.get(), one.paused)).collect::<Vec<_>>()
    };
    assert_eq!(runs(&stage), [(7, None), (15, None)]);
    stage.command(vec![adding(emergency(320, 3))]);
    stage.until(clock(12, 21));
    assert_eq!(runs(&stage), [(15, Some(clock(12, 20)))]);
    assert_eq!(outcome(&stage, 7), Some(Outcome::Aborted));
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    let laser = stage.director.state().ended.iter().find(|ended| ended.id == id(15)).copied();
    let laser = laser.unwrap();
    assert_eq!(laser.outcome, Outcome::Succeeded);
    assert_eq!(laser.ended.since(laser.started.unwrap()), Span::from_mins(23));
    // It counted on the arm's camera.
    assert_eq!(stage.start_of(8), None);
}

#[test]
fn what_runs_too_long_is_aborted_if_it_is_optional_and_goes_on_if_it_is_mandatory() {
    let fates =
        Fates::from([(18, ends_after(40, Exit::Code(0))), (3, ends_after(35, Exit::Code(0)))]);
    let mut stage = Stage::new(fates);
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert_eq!(outcome(&stage, 18), Some(Outcome::Aborted), "weather");
    assert_eq!(outcome(&stage, 3), Some(Outcome::Succeeded), "images of the terrain");
    let images = stage.start_of(3).unwrap().after(Span::from_mins(35));
    assert!(stage.start_of(4) >= Some(images), "and the drive waits for them");
}

#[test]
fn windows_that_change_are_planned_around_at_once() {
    let mut stage = Stage::new(Fates::new());
    stage.until(clock(11, 0));
    let mut windows = stage.director.state().windows.clone();
    let relay = windows.iter_mut().find(|window| window.name == "afternoon relay").unwrap();
    relay.start = clock(15, 0);
    stage.director.windows(windows);
    stage.until(clock(16, 30));
    assert_eq!(stage.refused(), [""; 0]);
    assert!(stage.plans.iter().any(|(at, _)| *at == clock(11, 0)));
    assert_eq!(stage.starts_of_task("window afternoon relay"), [clock(15, 0)]);
}

/// Nothing ended early: that it failed is reason enough.
#[test]
fn a_failure_at_the_planned_end_is_planned_around_at_once() {
    let fates = Fates::from([(2, ends_after(8, Exit::Failed("no image".into())))]);
    let mut stage = Stage::new(fates);
    stage.until(clock(10, 10));
    assert_eq!(outcome(&stage, 2), Some(Outcome::Failed));
    let (at, timed) = stage.plans.last().unwrap();
    assert_eq!(*at, clock(10, 8));
    assert_eq!(timed.slot(id(4)), None, "the drive needs the images of hazards");
}

/// What a relay sent is on board no more: planned again after it, nothing is
/// left out for want of room that is there.
#[test]
fn a_plan_after_a_relay_is_the_plan_with_that_data_gone() {
    let mut stage = Stage::new(Fates::new());
    let end = stage.plan().end;
    let relays: Vec<_> = state().windows.iter().filter(|one| one.data.get() < 0).cloned().collect();
    let last = relays.iter().map(|one| one.end).max().expect("the sol has relays");
    let after = last.after(Span::new(1));
    assert!(after < end);
    stage.until(after);
    assert_eq!(stage.refused(), [""; 0]);
    let sent: i64 = relays.iter().map(|one| one.data.get()).sum();
    let known = stage.director.state();
    let planned = |plan: &Plan, state: &State| {
        let problem = Problem::new(plan, &setting().parameters, state).unwrap();
        schedule(&problem, None)
    };
    let now = planned(stage.plan(), known);
    let mut gone = known.clone();
    gone.windows.retain(|one| one.end > known.now);
    let ended: i64 =
        known.windows.iter().filter(|one| one.end <= known.now).map(|one| one.data.get()).sum();
    assert_eq!(ended, sent, "all relays are over, and nothing else was exchanged");
    let mut room = stage.plan().clone();
    room.max_delta_data = Bytes::new(room.max_delta_data.get() - sent);
    assert_eq!(now, planned(&room, &gone));
    assert_eq!(now.slot(id(31)), stage.director.timed().slot(id(31)));
    assert!(now.slot(id(31)).is_some(), "there is room for the clouds");
    // The control: what was sent makes the difference.
    assert_eq!(planned(stage.plan(), &gone).slot(id(31)), None);
}
