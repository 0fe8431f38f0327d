//! What ends early lets in what is planned next, at once.

use faregate_planner::plan::Outcome;
use faregate_planner::timed::{Fate, Reason};
use faregate_planner::trace::Why;
use faregate_planner::units::{Span, Time};
use faregate_scheduler::manager::{Exit, Note, Telecommand};
use faregate_scheduler::task::{
    Body, Outcome as TaskOutcome, Preemption, Task, TaskId, TaskPriority, When, Window,
};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

use crate::stage::{Fates, Stage, adding, clock, ends_after, id, setting, task_id};

/// The arm's camera is placed in 5 minutes instead of 25.
fn placed_in_no_time() -> Fates {
    Fates::from([(7, ends_after(5, Exit::Code(0)))])
}

#[test]
fn what_is_planned_next_starts_at_the_early_end() {
    let mut usual = Stage::new(Fates::new());
    usual.until(clock(14, 0));
    let mut stage = Stage::new(placed_in_no_time());
    stage.until(clock(14, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert_eq!(usual.start_of(8), Some(clock(12, 25)));
    assert_eq!(stage.start_of(8), Some(clock(12, 5)), "the arm is warm, and nobody waits for it");
    assert!(stage.plans.iter().any(|(at, _)| *at == clock(12, 5)), "a plan is made at once");
    assert!(stage.start_of(11) < usual.start_of(11), "and what comes after that follows");
}

/// The control: a new plan alone starts nothing within the commit window.
#[test]
fn without_early_starts_it_waits_for_the_end_of_the_commit_window() {
    let mut stage = Stage::new(placed_in_no_time());
    stage.director = stage.director.clone().never_early();
    stage.until(clock(14, 0));
    assert_eq!(stage.start_of(8), Some(clock(12, 5).after(setting().parameters.commit)));
}

#[test]
fn nothing_that_is_planned_starts_later_for_an_early_start() {
    for (number, minutes) in [(2, 1), (3, 4), (4, 50), (6, 2), (7, 5), (8, 3), (15, 2), (18, 1)] {
        let mut stage = Stage::new(Fates::from([(number, ends_after(minutes, Exit::Code(0)))]));
        let mut waits = Stage::new(Fates::from([(number, ends_after(minutes, Exit::Code(0)))]));
        waits.director = waits.director.clone().never_early();
        let end = stage.plan().end;
        stage.until(end);
        waits.until(end);
        assert_eq!(stage.refused(), [""; 0]);
        let really = |stage: &Stage| {
            let ended = &stage.director.state().ended;
            ended.iter().filter(|one| one.outcome == Outcome::Succeeded).count()
        };
        assert!(really(&stage) >= really(&waits), "activity {number} in {minutes} min");
        let planned = |number: u32| {
            let before = stage.plans.iter().rev().find_map(|(_, timed)| timed.slot(id(number)));
            before.map(|slot| slot.start)
        };
        let tolerance = setting().parameters.handover_tolerance;
        for other in 1..=31 {
            let Some(start) = stage.start_of(other) else { continue };
            assert!(Some(start) <= planned(other).map(|at| at.after(tolerance)), "{other}");
        }
    }
}

/// It holds the arm, as nobody in the plan does.
fn keeps_the_arm(from: Time, minutes: u64) -> Task {
    let opens = When::At(setting().epoch.wall(from));
    Task {
        windows: vec![Window { opens, closes: When::Unrestricted }],
        priority: TaskPriority::TOP,
        categories: faregate_agents::Categories::from_mask(1 << 2),
        duration: Duration::from_secs(60 * minutes),
        preemption: Preemption::Wait,
        peak_draw: Milliwatts::ZERO,
        ..Task::new(task_id(9_000), Body::Hold)
    }
}

#[test]
fn who_does_not_get_its_tickets_in_time_waits_for_its_planned_start() {
    let mut stage = Stage::new(placed_in_no_time());
    stage.until(clock(12, 4));
    // It waits for the arm, and is more important than whoever comes next.
    stage.command(vec![adding(keeps_the_arm(clock(12, 5), 9))]);
    stage.until(clock(12, 5));
    let window = |stage: &Stage| {
        let task = stage.manager().task(task_id(8)).expect("it is in the schedule");
        task.windows[0].opens
    };
    let epoch = setting().epoch;
    let opens = |at| When::At(epoch.wall(at));
    assert_eq!(window(&stage), opens(clock(12, 5)), "it may start now");
    assert!(stage.director.wishes().any(|why| why == Why::EndedEarly(id(7))), "before the plan");
    let tolerance = setting().parameters.handover_tolerance;
    stage.until(clock(12, 5).after(tolerance));
    let planned = stage.director.timed().slot(id(8)).expect("it is planned").start;
    assert!(planned > clock(12, 5).after(tolerance));
    assert_eq!(window(&stage), opens(planned), "it is planned for later");
    assert_eq!(stage.director.wishes().count(), 0, "and the plan is made");
    stage.until(clock(15, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert!(stage.start_of(8) >= Some(clock(12, 13)));
}

/// Who loses what it waits for is taken out by the manager itself, and a removal
/// of it would be refused. Answers how many leave beside what they wait for.
fn dependants_leave_first(stage: &Stage, orders: &[Telecommand]) -> usize {
    let removed = |order: &Telecommand| match order {
        Telecommand::Remove(ids) => ids.first().copied(),
        _ => None,
    };
    let removed: Vec<_> = orders.iter().filter_map(removed).collect();
    let mut pairs = 0;
    for (place, id) in removed.iter().enumerate() {
        let after = stage.manager().task(*id).map_or(&[][..], |task| &task.after);
        for prior in after.iter().filter_map(|on| removed.iter().position(|one| *one == on.task)) {
            assert!(place < prior, "{id} leaves after {}: {removed:?}", removed[prior]);
            pairs += 1;
        }
    }
    pairs
}

/// The manager starts a task at the very moment at which a new plan takes it
/// out: what it was told comes a moment too late.
#[test]
fn a_task_that_starts_as_it_is_taken_out_has_run() {
    let mut stage = Stage::new(Fates::new());
    stage.until(clock(12, 29));
    let next = |stage: &Stage| {
        let rows = stage.director.timed().rows.iter();
        let planned = rows.filter_map(|row| match row.fate {
            Fate::Scheduled(slot) => Some((slot.start, row.id)),
            _ => None,
        });
        planned.filter(|(start, _)| *start > clock(12, 29)).min().expect("something is planned").1
    };
    let (mut director, now) = (stage.director.clone(), clock(12, 29).after(Span::new(1)));
    let leaves = next(&stage);
    let task = TaskId::new(leaves.get()).expect("activities are numbered as tasks");
    // Nothing is planned any more: everything that has not started leaves.
    let mut nothing = director.timed().clone();
    for row in &mut nothing.rows {
        if matches!(row.fate, Fate::Scheduled(_)) {
            row.fate = Fate::Out(Reason::NoRangeLeft);
        }
    }
    director.adopt(nothing).expect("tasks of nothing fit");
    let orders = director.turn(now).expect("it needs no plan");
    assert!(orders.contains(&Telecommand::Remove(vec![task])), "{orders:?}");
    assert!(dependants_leave_first(&stage, &orders) > 0, "there are some");
    let attempt = stage.attempt_of(task);
    director.heard(now, &Note::Started(attempt));
    assert!(director.state().running.iter().any(|one| one.id == leaves), "it runs");
    let occurrence = attempt.occurrence;
    director.heard(now, &Note::Ended { occurrence, outcome: TaskOutcome::Aborted });
    director.heard(now, &Note::Removed(task));
    let ended = director.state().ended.iter().find(|one| one.id == leaves);
    assert_eq!(ended.map(|one| one.outcome), Some(Outcome::Aborted), "and was ended");
    let orders = director.turn(now).expect("there is a new plan");
    let comes_back = |order: &Telecommand| matches!(order, Telecommand::Add(all) if all.iter().any(|one| one.task.id == task));
    assert!(!orders.iter().any(comes_back), "and does not run again");
    // The control: one that left in time comes back with the next plan.
    let mut director = stage.director.clone();
    let mut nothing = director.timed().clone();
    for row in &mut nothing.rows {
        if row.id == leaves {
            row.fate = Fate::Out(Reason::NoRangeLeft);
        }
    }
    director.adopt(nothing).expect("tasks of the others fit");
    director.turn(now).expect("it needs no plan");
    director.heard(now, &Note::Removed(task));
    director.zone_is_cold("wheels");
    let orders = director.turn(now).expect("there is a new plan");
    assert!(orders.iter().any(comes_back), "{orders:?}");
}
