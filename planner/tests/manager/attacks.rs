//! Attempts to make the director do what it must not: run past a cutoff, start
//! in a cold zone or with the computer asleep, survive an abort, lose a cleanup,
//! start inside the commit window, forget what was used up.

use std::sync::Arc;

use faregate_planner::plan::{
    Dependency, Effect, Impact, Kind, Outcome, StartRange, Status, Variable,
};
use faregate_planner::state::Mode;
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::units::{Span, Time};
use faregate_planner::{Activity, Plan, State};
use faregate_scheduler::manager::{Exit, Note, Telecommand};
use faregate_scheduler::task::Task;
use faregate_tickets::amount::Milliwatts;

use crate::small::{activity, bit, end_of, morning, outside, plan, setting_of, small};
use crate::stage::{Fates, Stage, adding, clock, ends_after, id, setting, state, task_id};

/// It ends in the night, if nobody ends it before.
pub(crate) fn for_ever() -> Fates {
    Fates::from([(1, ends_after(900, Exit::Code(0)))])
}

pub(crate) fn mandatory(activity: Activity) -> Activity {
    Activity { priority: 150, ..activity }
}

fn cut_off_at(at: Time, activity: Activity) -> Activity {
    let starts = activity.starts.iter().map(|range| StartRange { cutoff: at, ..*range }).collect();
    Activity { starts, ..activity }
}

pub(crate) fn outcome(stage: &Stage, number: u32) -> Option<Outcome> {
    let ended = stage.director.state().ended.iter().find(|ended| ended.id == id(number));
    ended.map(|ended| ended.outcome)
}

/// It takes all power, of whoever can be stopped.
fn emergency(from: Time, minutes: u64) -> Task {
    Task { peak_draw: Milliwatts::from_watts(330), ..outside(from, minutes) }
}

#[test]
fn nothing_runs_past_its_cutoff_or_the_plans_end() {
    let over = clock(11, 0);
    let expanding = Kind::Expanding { minimum: Span::from_mins(20) };
    let some = [
        cut_off_at(over, mandatory(activity(1, 20, clock(10, 10)))),
        cut_off_at(over, Activity { kind: expanding, ..mandatory(activity(1, 30, clock(10, 10))) }),
    ];
    for one in some {
        let mut stage = small(vec![one], for_ever());
        stage.until(clock(12, 0));
        assert_eq!(end_of(&stage, 1), Some(over));
        assert_eq!(outcome(&stage, 1), Some(Outcome::Aborted));
    }
    let late = cut_off_at(clock(23, 0), mandatory(activity(1, 20, clock(10, 10))));
    let mut stage = small(vec![late], for_ever());
    let end = stage.plan().end;
    stage.until(end.after(Span::from_mins(60)));
    assert_eq!(end_of(&stage, 1), Some(end));
}

#[test]
fn what_is_paused_at_its_cutoff_does_not_come_back() {
    let one = Activity { pausable: true, resources: bit(4), ..activity(1, 20, clock(10, 10)) };
    let mut stage = small(vec![cut_off_at(clock(10, 40), one)], Fates::new());
    stage.until(clock(10, 15));
    stage.command(vec![adding(Task { categories: bit(4), ..outside(clock(10, 15), 60) })]);
    stage.until(clock(10, 20));
    assert_eq!(stage.director.state().running[0].paused, Some(clock(10, 15)));
    stage.until(clock(13, 0));
    assert_eq!(
        (end_of(&stage, 1), outcome(&stage, 1)),
        (Some(clock(10, 40)), Some(Outcome::Aborted))
    );
    let resumed = |(_, note): &(Time, Note)| matches!(note, Note::Resumed(one) if one.occurrence.task == task_id(1));
    assert!(!stage.story.iter().any(resumed));
    assert_eq!(stage.refused(), [""; 0]);
}

/// Whoever runs past its planned end is with a computer that is up.
#[test]
fn the_computer_is_not_shut_down_while_something_runs() {
    let long = Fates::from([(1, ends_after(28, Exit::Code(0)))]);
    let mut stage = small(vec![mandatory(activity(1, 8, clock(10, 10)))], long);
    stage.until(clock(10, 9));
    let down = stage.director.timed().awake[0].down;
    assert_eq!(down, clock(10, 18), "it was to be shut down as soon as that is over");
    stage.until(clock(13, 0));
    assert_eq!(end_of(&stage, 1), Some(clock(10, 38)));
    let downs = stage.starts_of_task("shutdown");
    assert!(downs.iter().all(|at| *at >= clock(10, 38)), "{downs:?}");
    assert!(!downs.is_empty(), "and then it is");
    assert_eq!(stage.director.state().mode, Mode::Asleep);
    assert_eq!(stage.refused(), [""; 0]);
}

/// The computer sleeps, and somebody has the power for its wakeup.
#[test]
fn nothing_starts_that_needs_a_computer_that_was_not_woken() {
    let asleep = State { mode: Mode::Asleep, mode_since: clock(7, 0), ..morning() };
    let one = activity(1, 20, clock(12, 0));
    let mut stage = Stage::of(setting_of(plan(vec![one])), asleep, Fates::new());
    stage.until(clock(11, 0));
    let wakeup = stage.director.timed().awake[0].wakeup;
    assert_eq!(wakeup, clock(11, 55));
    let needed = Task { peak_draw: Milliwatts::from_watts(341), ..outside(clock(11, 50), 8) };
    stage.command(vec![adding(needed)]);
    stage.until(clock(17, 0));
    assert_eq!(stage.refused(), [""; 0]);
    let wakeups = stage.starts_of_task("wakeup");
    let start = stage.start_of(1).expect("it has all afternoon");
    let woken = wakeups.iter().any(|at| at.after(Span::from_mins(5)) <= start);
    assert!(woken, "it starts at {start}, and wakeups at {wakeups:?}");
    assert_eq!(outcome(&stage, 1), Some(Outcome::Succeeded));
}

/// The heating is over, the start is committed, and the heat is gone.
#[test]
fn a_zone_that_is_found_cold_at_the_last_moment_is_heated_anew() {
    let one = Activity { zones: vec!["mast".into()], ..activity(1, 8, clock(11, 30)) };
    let mut stage = small(vec![one], Fates::new());
    let last = clock(11, 30).before(Span::new(1));
    stage.until(last);
    stage.director.zone_is_cold("mast");
    stage.until(clock(14, 0));
    assert_eq!(stage.refused(), [""; 0]);
    let start = stage.start_of(1).expect("there is time to heat again");
    let heated = stage.starts_of_heating("mast").last().copied();
    assert!(heated >= Some(last), "{heated:?}");
    assert_eq!(heated.map(|at| start.since(at)), Some(Span::from_mins(15)));
}

/// It was found cold, and then its estimate was right again.
#[test]
fn a_zone_that_is_warm_after_all_need_not_be_heated_again() {
    let one = Activity { zones: vec!["mast".into()], ..activity(1, 8, clock(11, 30)) };
    let mut stage = small(vec![one], Fates::new());
    stage.until(clock(11, 29));
    stage.director.zone_is_cold("mast");
    stage.director.zone_is_warm("mast");
    stage.until(clock(14, 0));
    assert_eq!(stage.start_of(1), Some(clock(11, 30)));
}

/// All sample tubes but none, and then one more.
#[test]
fn what_was_used_up_is_not_there_for_the_next_plan() {
    let takes = |tubes: i64, one: Activity| {
        let effect = Effect::AddAtEnd(-tubes);
        Activity { impacts: vec![Impact { timeline: "empty_tubes".into(), effect }], ..one }
    };
    let some = vec![
        takes(38, activity(1, 20, clock(10, 10))),
        takes(1, activity(2, 20, clock(11, 0))),
        // It brings the computer up, and with it new plans.
        Activity { kind: Kind::StayAwake, ..activity(3, 300, clock(10, 0)) },
    ];
    let mut stage = small(some.clone(), Fates::new());
    stage.until(clock(15, 0));
    assert_eq!(outcome(&stage, 1), Some(Outcome::Succeeded));
    assert!(stage.plans.len() > 3, "it was planned again");
    assert_eq!(stage.start_of(2), None, "there are none left");
    assert_eq!(stage.director.state().timelines.get("empty_tubes"), Some(&0));
    // The control: 37 are not all.
    let mut some = some;
    some[0] = takes(37, some[0].clone());
    let mut stage = small(some, Fates::new());
    stage.until(clock(15, 0));
    assert_eq!(stage.start_of(2), Some(clock(11, 0)));
}

fn cleanup_of(number: u32) -> Activity {
    let statuses = vec![Status::Failed, Status::Aborted];
    let after = vec![Dependency { prior: id(1), statuses }];
    Activity { kind: Kind::Cleanup, after, ..activity(number, 5, clock(10, 0)) }
}

/// However it is aborted, and whatever else happens then.
#[test]
fn whoever_is_aborted_has_its_cleanup() {
    let runs = || activity(1, 20, clock(10, 10));
    let drawing = |one| Activity { peak: Milliwatts::from_watts(100), ..one };
    let second = || Activity { resources: bit(0), ..activity(3, 20, clock(10, 50)) };
    let by = |one: Activity, at: Time, what: Option<Telecommand>| {
        let mut stage = small(vec![one, cleanup_of(2), second()], for_ever());
        stage.until(at);
        stage.command(what.into_iter().collect());
        stage.until(clock(13, 0));
        assert_eq!(stage.refused(), [""; 0]);
        assert_eq!(outcome(&stage, 1), Some(Outcome::Aborted));
        (end_of(&stage, 1), stage.start_of(2), outcome(&stage, 2))
    };
    let cleaned = |at| (Some(at), Some(at), Some(Outcome::Succeeded));
    let at = clock(10, 15);
    assert_eq!(by(runs(), at, None), cleaned(clock(10, 30)), "past its duration");
    let short = cut_off_at(clock(10, 40), mandatory(runs()));
    assert_eq!(by(short, at, None), cleaned(clock(10, 40)), "at its cutoff");
    let taken = adding(emergency(at, 3));
    assert_eq!(by(drawing(runs()), at, Some(taken)).1, Some(at), "its tickets were taken");
    let ordered = Telecommand::Remove(vec![task_id(1)]);
    assert_eq!(by(runs(), at, Some(ordered)), cleaned(at), "by the ground");
}

/// An emergency that lasts past the range: what was killed stays dead.
#[test]
fn what_lost_its_tickets_does_not_start_again() {
    let one = Activity { peak: Milliwatts::from_watts(100), ..activity(1, 20, clock(10, 10)) };
    let mut stage = small(vec![one], Fates::new());
    stage.until(clock(10, 15));
    stage.command(vec![adding(emergency(clock(10, 15), 3))]);
    stage.until(clock(17, 0));
    assert_eq!(stage.refused(), [""; 0]);
    let started = |(_, note): &&(Time, Note)| matches!(note, Note::Started(one) if one.occurrence.task == task_id(1));
    assert_eq!(stage.story.iter().filter(started).count(), 1);
    assert_eq!(outcome(&stage, 1), Some(Outcome::Aborted));
}

/// What new plans start within the commit window: where the plan before had
/// nothing.
fn put_in(plan: &Plan, at: Time, before: &TimedPlan, timed: &TimedPlan) -> Vec<u32> {
    let until = at.after(setting().parameters.commit);
    let is_cleanup = |row: &&faregate_planner::timed::Row| {
        plan.activities.iter().any(|one| one.id == row.id && one.kind == Kind::Cleanup)
    };
    let rows = timed.rows.iter().filter(|row| !is_cleanup(row));
    let soon = rows.filter(|row| match row.fate {
        Fate::Scheduled(slot) => slot.start < until && before.slot(row.id) != Some(slot),
        _ => false,
    });
    soon.map(|row| row.id.get()).collect()
}

/// But for who waits, and begins now, and for who has started before.
#[test]
fn no_new_plan_starts_anything_within_the_commit_window_but_cleanups() {
    let mut plans = 0;
    for (number, minutes) in [(2, 1), (3, 4), (4, 50), (6, 2), (7, 5), (8, 3), (15, 2), (18, 1)] {
        for exit in [Exit::Code(0), Exit::Failed("a wheel is stuck".into())] {
            let fates = Fates::from([(number, ends_after(minutes, exit))]);
            let mut stage = Stage::of(setting(), state(), fates);
            stage.director = stage.director.clone().never_early();
            let end = stage.plan().end;
            stage.until(end);
            for pair in stage.plans.windows(2) {
                let [(_, before), (at, timed)] = pair else { continue };
                assert_eq!(put_in(stage.plan(), *at, before, timed), [0; 0], "{number}: {at}");
                plans += 1;
            }
        }
    }
    assert!(plans > 100, "{plans}");
}

/// The next plan is over before the cutoff of what runs.
#[test]
fn what_runs_at_handover_ends_with_the_plan_that_took_over() {
    let late = cut_off_at(clock(23, 0), mandatory(activity(1, 20, clock(10, 10))));
    let handover = clock(10, 20);
    let next_plan = Some("next".into());
    let today = Plan { handover, next_plan, end: clock(20, 0), ..plan(vec![late]) };
    let mut stage = Stage::of(setting_of(today), morning(), for_ever());
    stage.until(handover);
    assert!(stage.director.wants_next(handover).is_some());
    let end = clock(12, 0);
    let next = Plan { handover: end, end, ..plan(vec![activity(7, 20, clock(11, 0))]) };
    stage.director.take_over(handover, Ok(Arc::new(next))).expect("it can take over");
    stage.until(clock(13, 0));
    assert_eq!(stage.refused(), [""; 0]);
    assert_eq!(outcome(&stage, 7), Some(Outcome::Succeeded));
    assert_eq!((end_of(&stage, 1), outcome(&stage, 1)), (Some(end), Some(Outcome::Aborted)));
}

/// It is told at the very instant of the start.
#[test]
fn a_condition_that_stops_holding_at_the_instant_of_the_start_is_in_time() {
    let condition = faregate_planner::plan::Condition {
        kind: Variable::Acm,
        name: "drive_permitted".into(),
        min: 1,
        max: 1,
    };
    let one = Activity { conditions: vec![condition], ..activity(1, 8, clock(10, 10)) };
    let up = Activity { kind: Kind::StayAwake, ..activity(3, 60, clock(10, 0)) };
    let mut stage = small(vec![one, up], Fates::new());
    stage.until(clock(10, 10).before(Span::new(1)));
    stage.director.variable("drive_permitted", None);
    stage.until(clock(10, 20));
    assert_eq!(stage.start_of(1), None, "nobody knows it");
    stage.director.variable("drive_permitted", Some(1));
    stage.until(clock(10, 21));
    assert_eq!(stage.start_of(1), Some(clock(10, 20)));
}
