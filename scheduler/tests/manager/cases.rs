//! The demonstrations of SMAARTE's papers.

use crate::world::{With, World, seconds, task};

#[test]
fn tasks_of_one_category_run_one_after_the_other_most_important_first() {
    let tasks = [(11, 1, 1), (12, 1, 2), (13, 1, 3), (14, 2, 1), (15, 2, 2), (16, 2, 3)];
    let mut world = World::of(
        tasks.map(|(id, category, priority)| task(id, 3.0).categories(category).priority(priority)),
    );
    world.until(100.0);
    assert_eq!(
        world.lines(&["started"]),
        [
            "0.000 task 13 attempt 1 started",
            "0.000 task 16 attempt 1 started",
            "3.000 task 12 attempt 1 started",
            "3.000 task 15 attempt 1 started",
            "6.000 task 11 attempt 1 started",
            "6.000 task 14 attempt 1 started",
        ]
    );
    assert!(world.lines(&["task 14 succeeded"])[0].starts_with("9.000"));
    assert!(world.manager().is_over());
}

#[test]
fn nine_tasks_on_three_resources_take_a_third_and_55_seconds_with_gaps() {
    for (gap, end) in [(0.0, "45.000"), (5.0, "55.000")] {
        let nine = [(1, 1, 3), (2, 1, 2), (3, 1, 1), (4, 2, 3), (5, 2, 2), (6, 2, 1), (7, 4, 3)];
        let nine = nine.into_iter().chain([(8, 4, 2), (9, 4, 1)]);
        let mut world = World::of(nine.map(|(id, category, priority)| {
            let task = task(id, 15.0).categories(category).priority(priority);
            task.with(|task| task.gap = seconds(gap))
        }));
        world.until(1_000.0);
        let last = world.log.lines.last().unwrap();
        assert!(last.starts_with(end), "{last}");
    }
}

#[test]
fn a_more_important_task_pauses_a_routine_one_which_goes_on_and_keeps_its_phase() {
    let routine = task(31, 20.0).categories(1).priority(1).every(60.0);
    let urgent = task(32, 6.0).categories(1).priority(5).at(5.0);
    let mut world = World::of([routine, urgent]);
    world.until(90.0);
    assert_eq!(
        world.lines(&["started", "paused", "resumed", "succeeded ("]),
        [
            "0.000 task 31 attempt 1 started",
            "5.000 task 31 attempt 1 paused",
            "5.000 task 32 attempt 1 started",
            "11.000 task 32 attempt 1 succeeded (exit code 0)",
            "11.000 task 31 attempt 1 resumed",
            "26.000 task 31 attempt 1 succeeded (exit code 0)",
            "60.000 task 31 occurrence 1 attempt 1 started",
            "80.000 task 31 occurrence 1 attempt 1 succeeded (exit code 0)",
        ]
    );
}

#[test]
fn three_conflicting_tasks_due_at_once_start_in_order_and_none_is_pre_empted() {
    let tasks = [(21, 1), (22, 2), (23, 3)];
    let mut world =
        World::of(tasks.map(|(id, priority)| task(id, 3.0).categories(1).priority(priority)));
    world.until(100.0);
    let order = ["task 23", "task 22", "task 21"];
    let started = world.lines(&["started"]);
    assert!(started.iter().zip(order).all(|(line, task)| line.contains(task)), "{started:?}");
    assert!(world.lines(&["paused", "stopped"]).is_empty());
}
