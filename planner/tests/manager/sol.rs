//! The busy sol.

use faregate_planner::plan::{Kind, Outcome};
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::trace::Why;
use faregate_planner::units::{Span, Time};
use faregate_scheduler::manager::{Exit, Note};
use faregate_scheduler::task::{Body, Overrun, Preemption, Task, TaskPriority};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

use crate::stage::{Fates, Stage, adding, clock, ends_after, id, setting, task_id};

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
    let tolerance = stage_tolerance();
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

fn stage_tolerance() -> Span {
    setting().parameters.handover_tolerance
}

/// When an activity is planned to start, by the last plan that was made.
fn planned(stage: &Stage, number: u32) -> Option<Time> {
    let (_, timed) = stage.plans.last().unwrap();
    scheduled(timed).into_iter().find(|(other, _)| *other == number).map(|(_, start)| start)
}

fn outcome(stage: &Stage, number: u32) -> Option<Outcome> {
    let ended = stage.director.state().ended.iter().find(|ended| ended.id == id(number));
    ended.map(|ended| ended.outcome)
}

/// The images of the terrain take half as long, and the drive starts as soon as
/// its wheels are warm and the commit window is over.
#[test]
fn an_early_end_pulls_the_next_one_in() {
    let mut usual = Stage::new(Fates::new());
    usual.until(clock(14, 0));
    // The arm's camera is placed in 5 minutes instead of 25.
    let fates = Fates::from([(7, ends_after(5, Exit::Code(0)))]);
    let mut stage = Stage::new(fates);
    stage.until(clock(14, 0));
    assert_eq!(stage.refused(), [""; 0]);
    let ended = clock(12, 5);
    let commit = setting().parameters.commit;
    assert_eq!(usual.start_of(8), Some(clock(12, 25)));
    // What nobody can see ahead is not planned into the commit window.
    assert_eq!(stage.start_of(8), Some(ended.after(commit)));
    assert!(stage.plans.iter().any(|(at, _)| *at == ended), "a plan is made at once");
    assert!(stage.start_of(11) < usual.start_of(11), "and what comes after that follows");
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
