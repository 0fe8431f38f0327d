//! What records add up to, rule by rule.

use faregate_scheduler::journal::{replay, replay_bytes};
use faregate_scheduler::manager::{Attempt, Record, RestoredTask};
use faregate_scheduler::task::{Dependency, Outcome, Status, Task, TaskPriority};
use faregate_scheduler::time::UnixTime;

use crate::records::{
    accepted, accepted_as, armed, attempt, ended, id, occurrence, over, routine, starting, task,
};

fn removed(task: u32) -> Record {
    Record::Removed { task: id(task), load: 0 }
}

fn only(records: impl IntoIterator<Item = Record>) -> RestoredTask {
    let mut tasks = replay(records).tasks;
    assert_eq!(tasks.len(), 1, "{tasks:?}");
    tasks.remove(0)
}

#[test]
fn tasks_come_back_in_the_order_of_the_schedule() {
    let records = [accepted_as(task(1), 0, 9), accepted_as(task(2), 0, 4)];
    let restored = replay(records);
    let order: Vec<_> = restored.tasks.iter().map(|kept| kept.task.id).collect();
    assert_eq!(order, [id(2), id(1)]);
    assert_eq!(restored.next_position, 10);
}

#[test]
fn a_task_that_was_removed_is_gone() {
    let restored = replay([accepted(task(1)), removed(1)]);
    assert!(restored.tasks.is_empty());
    assert_eq!(restored.next_position, 2, "its position is not given again");
}

#[test]
fn a_removal_of_an_earlier_task_of_the_id_does_not_count() {
    let records = [accepted_as(task(1), 1, 1), removed(1)];
    assert!(!only(records).over);
}

#[test]
fn what_became_of_a_task_is_kept_while_another_one_asks() {
    let after = vec![Dependency { task: id(1), status: Status::Succeeded }];
    let records = [
        accepted(task(1)),
        accepted(Task { after, ..task(2) }),
        ended(1, Outcome::Succeeded),
        removed(1),
    ];
    let restored = replay(records.clone());
    assert_eq!(restored.tasks[0].ended, Some((0, Outcome::Succeeded)));
    assert!(restored.tasks[0].over && !restored.tasks[1].over);
    let restored = replay(records.into_iter().chain([removed(2)]));
    assert!(restored.tasks.is_empty(), "nobody asks any more");
}

#[test]
fn a_removed_task_with_an_open_attempt_is_kept_until_that_is_over() {
    let records = [accepted(task(1)), starting(1), removed(1)];
    assert_eq!(only(records.clone()).interrupted, Some(attempt(1, 1)));
    assert!(replay(records.into_iter().chain([over(1)])).tasks.is_empty());
}

#[test]
fn a_one_shot_that_ended_is_over_and_a_routine_task_is_not() {
    assert!(only([accepted(task(1)), ended(1, Outcome::Missed)]).over);
    assert!(!only([accepted(routine(1)), ended(1, Outcome::Missed)]).over);
}

/// It has no times of its own: it runs whenever the other one failed.
#[test]
fn a_cleanup_task_is_not_over_when_it_ran() {
    let cleaned = Task { cleanup: Some(id(2)), ..routine(1) };
    let cleans_up = Record::CleansUp { task: id(2), load: 0 };
    let records = [accepted(cleaned), accepted(task(2)), cleans_up, ended(2, Outcome::Succeeded)];
    let restored = replay(records);
    assert!(!restored.tasks[1].over && restored.tasks[1].cleans_up);
    assert!(!restored.tasks[0].cleans_up);
}

/// From the failure until the cleanup begins; a success asks for none.
#[test]
fn a_cleanup_that_was_not_begun_is_remembered() {
    let cleaned = Task { cleanup: Some(id(2)), ..task(1) };
    let records = [accepted(cleaned), accepted(task(2)), ended(1, Outcome::Aborted)];
    let has_to = |records: Vec<Record>| replay(records).tasks[1].has_to_clean;
    assert!(has_to(records.to_vec()));
    assert!(!has_to(records.iter().cloned().chain([starting(2)]).collect()));
    let [cleaned, cleanup, _] = records;
    assert!(!has_to(vec![cleaned, cleanup, ended(1, Outcome::Succeeded)]));
}

#[test]
fn attempts_count_until_the_occurrence_ends() {
    let second = Attempt { number: 2, ..attempt(1, 1) };
    let preempted = Record::Over { attempt: attempt(1, 1), outcome: None };
    let records =
        [accepted(routine(1)), starting(1), preempted, Record::Starting { attempt: second }];
    let kept = only(records.clone());
    assert_eq!((kept.attempts.1, kept.interrupted), (2, Some(second)));
    let kept = only(records.into_iter().chain([ended(1, Outcome::Failed)]));
    assert_eq!((kept.attempts.1, kept.interrupted), (0, None));
}

/// It waits for its next attempt while later ones are due.
#[test]
fn attempts_are_those_of_their_occurrence_though_a_later_one_is_missed() {
    let missed = |number| Record::Ended {
        occurrence: occurrence(1, number),
        outcome: Outcome::Missed,
        wall: UnixTime::from_secs(0),
    };
    let records = [accepted(routine(1)), starting(1), over(1), missed(1), missed(2)];
    let kept = only(records.clone());
    assert_eq!((kept.attempts, kept.ended), ((0, 1), Some((2, Outcome::Missed))));
    let kept = only(records.into_iter().chain([ended(1, Outcome::Failed)]));
    assert_eq!((kept.attempts, kept.ended), ((0, 0), Some((2, Outcome::Missed))));
}

#[test]
fn an_occurrence_that_ended_does_not_end_a_later_one() {
    let later = occurrence(1, 5);
    let wall = UnixTime::from_secs(0);
    let end = Record::Ended { occurrence: later, outcome: Outcome::Missed, wall };
    let kept = only([accepted(routine(1)), end, ended(1, Outcome::Succeeded)]);
    assert_eq!(kept.ended, Some((5, Outcome::Missed)));
}

#[test]
fn a_changed_task_keeps_its_place_and_its_attempts() {
    let priority = TaskPriority::new(7).unwrap();
    let changed = Record::Changed { task: Box::new(Task { priority, ..task(1) }), held: true };
    let kept = only([accepted(task(1)), starting(1), changed]);
    assert_eq!((kept.task.priority, kept.held, kept.attempts.1), (priority, true, 1));
}

#[test]
fn the_same_id_again_is_another_task() {
    let kept = only([accepted(task(1)), starting(1), accepted_as(task(1), 1, 2), over(1)]);
    assert_eq!((kept.load, kept.attempts, kept.interrupted), (1, (0, 0), None));
}

#[test]
fn modes_come_back_in_the_order_in_which_they_were_entered() {
    let mode = |name: &str, entered| Record::Mode { name: name.into(), entered };
    let records = [mode("a", true), mode("b", true), mode("c", true), mode("b", false)];
    assert_eq!(replay(records).modes, ["a", "c"]);
}

#[test]
fn records_of_nobody_say_nothing() {
    assert!(replay([armed(1), starting(1), over(1), removed(1)]).tasks.is_empty());
}

/// Any bytes are some records, or none; never a panic. What is encoded is read.
#[test]
fn any_bytes_are_replayed() {
    let mut random = fastrand::Rng::with_seed(5);
    let mut read = 0;
    for _ in 0..3_000 {
        let records: Vec<_> = (0..5).map(|_| crate::records::any(&mut random)).collect();
        let mut bytes: Vec<u8> =
            records.iter().flat_map(|record| postcard::to_stdvec(record).unwrap()).collect();
        assert_eq!(replay_bytes(&bytes), replay(records));
        for _ in 0..random.u8(1..8) {
            let at = random.usize(..bytes.len());
            bytes[at] = random.u8(..);
        }
        read += replay_bytes(&bytes).tasks.len();
    }
    assert!(read > 100, "only {read} tasks were read");
}

#[test]
fn one_that_leaves_is_there_until_its_body_has_ended_and_does_not_come_again() {
    let leaving = Record::Leaving { task: id(1), load: 0 };
    let records = [accepted(routine(1)), starting(1), leaving];
    let kept = only(records.clone());
    assert!(kept.leaving && !kept.over);
    let gone = [over(1), ended(1, Outcome::Aborted), removed(1)];
    assert!(replay(records.into_iter().chain(gone)).tasks.is_empty());
}

#[test]
fn what_was_said_of_a_task_is_not_true_of_the_next_one_of_its_id() {
    let said = |load| {
        let (task, marks) = (id(1), accepted_as(task(1), 1, 2));
        let marked = [Record::Leaving { task, load }, Record::CleansUp { task, load }];
        let kept = only([accepted(crate::records::task(1)), marks].into_iter().chain(marked));
        (kept.leaving, kept.cleans_up)
    };
    assert_eq!((said(0), said(1)), ((false, false), (true, true)));
    let task = id(1);
    let marks = [Record::Leaving { task, load: 0 }, Record::CleansUp { task, load: 0 }];
    let next = accepted_as(crate::records::task(1), 1, 2);
    let records = core::iter::once(accepted(crate::records::task(1))).chain(marks).chain([next]);
    let kept = only(records);
    assert!(!kept.leaving && !kept.cleans_up);
}
