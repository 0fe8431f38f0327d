//! Dependencies on what became of other tasks, and tasks that clean up.

use faregate_scheduler::Task;
use faregate_scheduler::journal::replay;
use faregate_scheduler::manager::{Exit, Reply, Telecommand};
use faregate_scheduler::task::{Dependency, Status};

use crate::world::{With, World, id, task};

fn after(task: Task, prior: u32, status: Status) -> Task {
    task.with(|task| task.after.push(Dependency { task: id(prior), status }))
}

#[test]
fn a_dependant_starts_when_its_prior_has_ended_as_it_asks() {
    let failing = [(1, Exit::Code(3))];
    for (status, runs) in [
        (Status::Succeeded, false),
        (Status::Failed, true),
        (Status::Completed, true),
        (Status::Finished, true),
        (Status::Aborted, false),
        (Status::Missed, false),
    ] {
        let dependant = after(task(2, 1.0), 1, status);
        let mut world = World::ending([dependant, task(1, 5.0)], &failing);
        world.until(60.0);
        let expected = if runs {
            "5.000 task 2 attempt 1 started"
        } else {
            "5.000 task 2 never runs: task 1 has ended otherwise"
        };
        assert_eq!(world.lines(&["task 2 attempt 1 started", "task 2 never"]), [expected]);
        assert!(world.manager().is_over());
    }
}

#[test]
fn who_waits_for_another_one_keeps_nothing_from_others() {
    let prior = task(1, 10.0);
    let dependant = after(task(2, 10.0).categories(1).priority(9), 1, Status::Succeeded);
    let other = task(3, 5.0).categories(1);
    let mut world = World::of([prior, dependant, other]);
    world.until(60.0);
    assert_eq!(
        world.lines(&["started"]),
        [
            "0.000 task 1 attempt 1 started",
            "0.000 task 3 attempt 1 started",
            "10.000 task 2 attempt 1 started",
        ]
    );
}

#[test]
fn each_outcome_of_a_routine_task_satisfies_a_dependant_once() {
    let prior = task(1, 1.0).every(10.0);
    let dependant = after(task(2, 1.0).every(3.0), 1, Status::Succeeded);
    let mut world = World::of([prior, dependant]);
    world.until(29.0);
    let starts = world.lines(&["task 2 occurrence", "task 2 attempt"]);
    let starts: Vec<_> = starts.iter().filter(|line| line.contains("started")).collect();
    assert_eq!(
        starts,
        [
            &"1.000 task 2 attempt 1 started",
            &"11.000 task 2 occurrence 3 attempt 1 started",
            &"21.000 task 2 occurrence 7 attempt 1 started",
        ]
    );
}

#[test]
fn a_chain_as_long_as_the_schedule_is_taken_out_when_it_can_never_run() {
    let length = 20_000;
    let chain = (2..=length).map(|n| after(task(n, 1.0), n - 1, Status::Succeeded));
    let mut world = World::ending([task(1, 1.0)], &[(1, Exit::Code(1))]);
    world.add(chain);
    world.until(5.0);
    assert_eq!(world.lines(&["never"]).len(), length as usize - 1);
    assert!(world.manager().is_over());
}

#[test]
fn a_removed_prior_takes_its_dependants_with_it() {
    let mut world = World::of([task(1, 5.0).at(10.0), after(task(2, 1.0), 1, Status::Finished)]);
    world.ask(Telecommand::Remove(vec![id(1)]));
    assert_eq!(
        world.lines(&["never"]),
        ["0.000 task 2 never runs: task 1 was taken out of the schedule"]
    );
}

#[test]
fn dependencies_on_nobody_and_on_oneself_are_refused() {
    let unknown = after(task(1, 1.0), 9, Status::Succeeded);
    let [a, b] = [(2, 3), (3, 2)].map(|(id, prior)| after(task(id, 1.0), prior, Status::Failed));
    let mut world = World::of([]);
    let Reply::Refused(why) = world.try_add([unknown, a, b]) else { panic!("accepted") };
    assert_eq!(
        why,
        "task 1: it depends on task 9, which is not in the schedule; task 2: it depends on itself, \
         by way of others"
    );
    assert_eq!(world.manager().status().count(), 0, "all or none");
}

#[test]
fn the_cleanup_runs_after_a_failure_and_an_abortion_and_never_else() {
    let cleaned = |id: u32| task(id, 5.0).with(|task| task.cleanup = Some(crate::world::id(9)));
    for (exit, cleans) in [(Exit::Code(0), false), (Exit::Signal(11), true)] {
        let mut world = World::ending([cleaned(1), task(9, 1.0)], &[(1, exit)]);
        world.until(60.0);
        assert_eq!(world.lines(&["task 9 attempt 1 started"]).len(), usize::from(cleans));
        assert!(world.manager().is_over());
    }
    let mut world = World::of([cleaned(1), task(9, 1.0)]);
    world.until(1.0);
    world.ask(Telecommand::Remove(vec![id(1)]));
    world.until(60.0);
    assert_eq!(
        world.lines(&["task 1 aborted", "task 9 attempt 1 started"]),
        ["1.000 task 1 aborted", "1.000 task 9 attempt 1 started"]
    );
}

#[test]
fn being_pre_empted_is_no_outcome_and_triggers_no_cleanup() {
    let first = task(1, 20.0).categories(1).with(|task| task.cleanup = Some(id(9)));
    let waiting = after(task(3, 1.0), 1, Status::Finished);
    let second = task(2, 5.0).categories(1).priority(1).at(5.0);
    let mut world = World::of([first, task(9, 1.0), waiting, second]);
    world.until(100.0);
    assert_eq!(
        world.lines(&["task 9", "task 3 attempt 1 started"]),
        ["25.000 task 3 attempt 1 started"]
    );
}

#[test]
fn a_cleanup_that_is_at_work_when_it_is_wanted_works_once_more() {
    let cleaned =
        |id: u32, takes: f64| task(id, takes).with(|task| task.cleanup = Some(crate::world::id(9)));
    let exits = [(1, Exit::Code(1)), (2, Exit::Code(1))];
    let mut world = World::ending([cleaned(1, 1.0), cleaned(2, 2.0), task(9, 10.0)], &exits);
    world.until(60.0);
    assert_eq!(world.lines(&["task 9"]).iter().filter(|line| line.contains("started")).count(), 2);
    assert!(world.lines(&["task 9 occurrence 1 attempt 1 started"])[0].starts_with("11.000"));
}

/// It was running when its prior went: what it depends on was used already.
#[test]
fn a_routine_task_whose_prior_was_removed_while_it_ran_never_runs_again() {
    let dependant = after(task(2, 5.0).every(10.0), 1, Status::Succeeded);
    let mut world = World::of([task(1, 1.0).every(10.0), dependant]);
    world.until(3.0);
    world.ask(Telecommand::Remove(vec![id(1)]));
    world.until(60.0);
    assert_eq!(
        world.lines(&["task 2 attempt 1 s", "task 2 never", "task 2 missed"]),
        [
            "1.000 task 2 attempt 1 started",
            "6.000 task 2 attempt 1 succeeded (exit code 0)",
            "6.000 task 2 never runs: task 1 was taken out of the schedule",
        ]
    );
    assert!(world.manager().is_over());
}

/// The last outcome is good for one start, whoever is the manager then.
#[test]
fn an_outcome_of_a_routine_task_that_was_removed_is_used_once() {
    let dependant = after(task(2, 1.0).every(10.0).at(5.0), 1, Status::Succeeded);
    let mut world = World::of([task(1, 1.0).every(10.0), dependant]);
    world.until(2.0);
    world.ask(Telecommand::Remove(vec![id(1)]));
    let records = world.journal.records.clone();
    let again = World::restored(Default::default(), replay(records), 3);
    for (mut world, at) in [(world, 5), (again, 2)] {
        world.until(60.0);
        assert_eq!(
            world.lines(&["task 2 attempt 1 started", "task 2 occurrence", "task 2 never"]),
            [
                format!("{at}.000 task 2 attempt 1 started"),
                format!("{}.000 task 2 never runs: task 1 was taken out of the schedule", at + 1),
            ]
        );
    }
}

fn cleaned(number: u32, takes: f64) -> Task {
    task(number, takes).with(|task| task.cleanup = Some(id(9)))
}

fn shown(world: &World) -> Vec<u32> {
    world.manager().status().map(|status| status.occurrence.task.get()).collect()
}

#[test]
fn a_cleanup_stays_as_long_as_somebody_may_need_it() {
    let mut world = World::of([cleaned(1, 1.0), cleaned(2, 5.0), task(9, 1.0)]);
    world.until(2.0);
    assert_eq!(shown(&world), [1, 2, 9]);
    world.until(9.0);
    assert_eq!(shown(&world), [1, 2], "nobody can fail any more");
    world.add([cleaned(1, 1.0), task(9, 1.0)]);
    world.ask(Telecommand::Remove(vec![id(1)]));
    world.until(20.0);
    assert_eq!(world.lines(&["task 9 attempt 1 started"]), ["9.000 task 9 attempt 1 started"]);
    assert_eq!(shown(&world), [2, 9], "it ran, and how it ended is told");
    world.add([cleaned(1, 1.0), task(9, 1.0)]);
    assert_eq!(shown(&world), [2, 1, 9]);
}

#[test]
fn a_cleanup_that_comes_in_place_of_another_one_cleans_up() {
    let mut world = World::of([cleaned(1, 60.0), task(9, 1.0)]);
    world.until(1.0);
    world.ask(Telecommand::Remove(vec![id(9)]));
    world.add([task(9, 2.0)]);
    world.until(5.0);
    assert!(world.lines(&["task 9 attempt"]).is_empty(), "there is nothing to clean up");
    world.ask(Telecommand::Remove(vec![id(1)]));
    world.until(60.0);
    assert_eq!(world.lines(&["task 9 attempt 1 started"]), ["5.000 task 9 attempt 1 started"]);
}

#[test]
fn a_chain_of_cleanups_as_long_as_the_schedule_goes_when_nobody_needs_it() {
    let length = 20_000;
    let chain = (1..=length).map(|n| task(n, 1.0).with(|task| task.cleanup = Some(id(n + 1))));
    let mut world = World::of(chain.chain([task(length + 1, 1.0)]));
    world.until(5.0);
    assert_eq!(shown(&world).len(), 1);
}
