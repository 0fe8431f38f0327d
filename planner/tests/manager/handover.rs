//! The next plan takes over, or the present one goes on to its end.

use std::sync::Arc;

use faregate_planner::Plan;
use faregate_planner::plan::{Outcome, StartRange};
use faregate_planner::state::Window;
use faregate_planner::timed::Fate;
use faregate_planner::units::{Bytes, Span, Time};
use faregate_scheduler::manager::Note;

use crate::stage::{Fates, Stage, clock, id, setting, state};

/// In the middle of what the arm does.
const HANDOVER: Time = clock(12, 15);

fn with_a_next_plan() -> Stage {
    let mut setting = setting();
    let mut plan = Plan::clone(&setting.plan);
    plan.handover = HANDOVER;
    plan.next_plan = Some("tomorrow.xml".into());
    setting.plan = Arc::new(plan);
    Stage::of(setting, state(), Fates::new())
}

/// Weather twice, under other numbers, and the arm's images again.
fn next() -> Plan {
    let today = setting();
    let mut plan = Plan::clone(&today.plan);
    plan.name = "tomorrow".into();
    plan.handover = plan.end;
    let open = StartRange { from: clock(12, 0), to: clock(16, 0), cutoff: clock(17, 0) };
    plan.activities.retain(|one| [18, 19, 30].contains(&one.id.get()));
    for (one, number) in plan.activities.iter_mut().zip([101, 102, 103]) {
        one.id = id(number);
        one.starts = vec![open];
        one.data = Bytes::new(1);
    }
    plan
}

#[test]
fn the_next_plan_takes_over_at_handover_and_what_runs_goes_on() {
    let mut stage = with_a_next_plan();
    stage.until(HANDOVER.before(Span::new(1)));
    assert_eq!(stage.director.wants_next(HANDOVER.before(Span::new(1))), None, "not yet");
    stage.until(HANDOVER);
    let runs: Vec<_> = stage.director.state().running.iter().map(|one| one.id.get()).collect();
    assert_eq!(runs, [7, 15, 18]);
    let waited: Vec<_> = scheduled(&stage);
    assert_eq!(stage.director.wants_next(HANDOVER).as_deref(), Some("tomorrow.xml"));
    assert_eq!(stage.director.wants_next(HANDOVER), None, "once");
    let dropped = stage.director.take_over(HANDOVER, Ok(Arc::new(next()))).unwrap();
    assert!(waited.iter().all(|id| dropped.contains(id)), "what was planned is handed over");
    assert!(!dropped.iter().any(|id| [2, 3, 4, 7, 15, 18].contains(&id.get())), "and nothing else");
    let began = stage.story.len();
    stage.until(clock(17, 30));
    assert_eq!(stage.refused(), [""; 0]);
    let started = stage.story[began..].iter().filter_map(|(_, note)| match note {
        Note::Started(attempt) => Some(attempt.occurrence.task.get()),
        _ => None,
    });
    let mut activities: Vec<_> = started.filter(|number| *number < 1_000).collect();
    activities.sort_unstable();
    assert_eq!(activities, [101, 102, 103], "nothing of the plan before");
    let outcome = |number: u32| {
        let ended = stage.director.state().ended.iter().find(|one| one.id == id(number));
        ended.map(|one| one.outcome)
    };
    for number in [7, 15, 18, 101, 102, 103] {
        assert_eq!(outcome(number), Some(Outcome::Succeeded), "activity {number}");
    }
}

fn scheduled(stage: &Stage) -> Vec<faregate_planner::ActivityId> {
    let rows = stage.director.timed().rows.iter();
    rows.filter(|row| matches!(row.fate, Fate::Scheduled(_))).map(|row| row.id).collect()
}

#[test]
fn without_a_next_plan_that_can_take_over_the_present_one_goes_on_to_its_end() {
    let late = Plan { end: HANDOVER, handover: HANDOVER, ..next() };
    let mut taken = next();
    taken.activities[0].id = id(7);
    // The computer's phase is a task, too.
    let mut task = next();
    task.activities[0].id = id({
        let mut stage = with_a_next_plan();
        stage.until(HANDOVER);
        stage.number_of("awake")
    });
    let mut unheard_of = next();
    unheard_of.activities[0].sequence = Some("unheard_of".into());
    let answers = [
        (Err("there is no such file".to_owned()), "there is no such file"),
        (Ok(Arc::new(late)), "is over already"),
        (Ok(Arc::new(taken)), "uses the number of activity 7, which runs"),
        (Ok(Arc::new(task)), "uses the number of a task"),
        (Ok(Arc::new(unheard_of)), "no sequence `unheard_of` is known"),
    ];
    for (answer, why) in answers {
        let mut stage = with_a_next_plan();
        stage.until(HANDOVER);
        let before = stage.director.timed().clone();
        assert!(stage.director.wants_next(HANDOVER).is_some());
        let refused = stage.director.take_over(HANDOVER, answer).unwrap_err();
        assert!(refused.contains(why), "{refused}");
        assert_eq!(*stage.director.timed(), before, "nothing has changed");
        stage.until(clock(16, 0));
        assert_eq!(stage.refused(), [""; 0]);
        assert_eq!(stage.start_of(8), Some(clock(12, 25)), "what was planned runs: {why}");
    }
}

#[test]
fn nothing_is_dispatched_after_the_end_of_a_plan_that_nothing_follows() {
    let mut stage = with_a_next_plan();
    stage.until(HANDOVER);
    assert!(stage.director.wants_next(HANDOVER).is_some());
    stage.director.take_over(HANDOVER, Err("no file".into())).unwrap_err();
    let end = stage.plan().end;
    stage.until(end);
    let (count, plans) = (stage.story.len(), stage.plans.len());
    stage.until(end.after(Span::from_mins(300)));
    let started = |(_, note): &(Time, Note)| matches!(note, Note::Started(_));
    assert!(!stage.story[count..].iter().any(started), "{:?}", &stage.story[count..]);
    assert_eq!(stage.plans.len(), plans);
}

/// What was counted for the plan before is not counted for this one.
#[test]
fn data_counts_anew_from_the_handover() {
    let mut stage = with_a_next_plan();
    stage.until(HANDOVER);
    assert!(!stage.director.state().ended.is_empty());
    let mut windows = stage.director.state().windows.clone();
    let relay = windows.iter().find(|one| one.data.get() < 0).unwrap().clone();
    windows.push(Window { name: "gone".into(), start: clock(12, 0), end: clock(12, 10), ..relay });
    stage.director.windows(windows);
    assert!(stage.director.state().exchanged() < 0);
    stage.director.take_over(HANDOVER, Ok(Arc::new(next()))).unwrap();
    assert!(stage.director.state().ended.is_empty());
    assert_eq!(stage.director.state().exchanged(), 0);
}
