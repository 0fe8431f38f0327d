//! Routine tasks keep their phase, and never run in bursts.

use faregate_scheduler::task::When;
use faregate_scheduler::time::UnixTime;

use crate::world::{BEGAN, With, World, task, wall};

fn starts(world: &World) -> Vec<&str> {
    world.lines(&["started"])
}

#[test]
fn a_late_start_and_the_time_that_it_takes_do_not_shift_the_phase() {
    let blocker = task(1, 4.0).categories(1).priority(9).at(10.0);
    let routine = task(2, 3.0).categories(1).every(10.0);
    let mut world = World::of([blocker, routine]);
    world.until(35.0);
    assert_eq!(
        starts(&world),
        [
            "0.000 task 2 attempt 1 started",
            "10.000 task 1 attempt 1 started",
            "14.000 task 2 occurrence 1 attempt 1 started",
            "20.000 task 2 occurrence 2 attempt 1 started",
            "30.000 task 2 occurrence 3 attempt 1 started",
        ]
    );
}

#[test]
fn one_that_still_waits_is_superseded_and_told_of_once_for_the_whole_run() {
    let blocker = task(1, 35.0).categories(1).priority(9);
    let routine = task(2, 1.0).categories(1).every(10.0);
    let mut world = World::of([blocker, routine]);
    world.until(45.0);
    assert_eq!(
        world.lines(&["missed", "task 2 occurrence 3 attempt 1 started", "task 2 attempt"]),
        [
            "35.000 task 2 missed 3 occurrences, 0 to 2: superseded: still waiting when the next \
             one was due",
            "35.000 task 2 occurrence 3 attempt 1 started",
        ]
    );
}

#[test]
fn one_that_still_runs_lets_the_next_ones_be_missed() {
    let mut world = World::of([task(2, 25.0).every(10.0)]);
    world.until(35.0);
    assert_eq!(
        world.lines(&["missed", "started"]),
        [
            "0.000 task 2 attempt 1 started",
            "30.000 task 2 missed 2 occurrences, 1 to 2: the one before was still running",
            "30.000 task 2 occurrence 3 attempt 1 started",
        ]
    );
}

#[test]
fn a_paused_one_lets_the_next_ones_be_missed_and_goes_on() {
    let routine = task(1, 20.0).categories(1).every(60.0);
    let downlink = task(2, 1_200.0).categories(1).priority(9).at(5.0);
    let mut world = World::of([routine, downlink]);
    world.until(1_300.0);
    let runs = world.lines(&["task 1"]);
    assert!(runs.contains(&"1205.000 task 1 attempt 1 resumed"), "{runs:#?}");
    assert!(
        runs.contains(
            &"1260.000 task 1 missed 20 occurrences, 1 to 20: the one before was still running"
        ),
        "{runs:#?}"
    );
    assert!(runs.contains(&"1260.000 task 1 occurrence 21 attempt 1 started"), "{runs:#?}");
}

#[test]
fn a_closed_window_loses_the_occurrence_and_not_the_task() {
    let blocker = task(1, 15.0).categories(1).priority(9);
    let routine = task(2, 1.0).categories(1).closes(5.0).every(10.0);
    let mut world = World::of([blocker, routine]);
    world.until(25.0);
    assert_eq!(
        world.lines(&["task 2 missed", "task 2 occurrence 1 attempt 1 started"]),
        [
            "15.000 task 2 missed occurrence 0: its window closed",
            "15.000 task 2 occurrence 1 attempt 1 started",
        ]
    );
}

#[test]
fn a_jump_of_a_year_is_counted_and_not_run_through() {
    let year = 366 * 86_400;
    let mut world = World::of([
        task(1, 1.0).every(1.0).with(|task| task.windows[0].opens = wall(10)),
        task(2, 1.0).every(50.0),
    ]);
    world.until(5.0);
    let before = world.manager().looked_at();
    world.jump(year);
    assert!(world.manager().looked_at() - before < 100);
    world.until(5.5);
    let last = year - 5;
    assert_eq!(
        world.lines(&["task 1 missed", "task 1 occurrence"]),
        [
            format!(
                "5.000 task 1 missed {last} occurrences, 0 to {}: superseded: still waiting when \
                 the next one was due",
                last - 1
            ),
            format!("5.000 task 1 occurrence {last} attempt 1 started"),
        ]
    );
    assert_eq!(world.lines(&["task 2 occurrence 1"]), Vec::<&str>::new(), "it is relative");
}

/// Times of day that have been come again; numbers do not.
#[test]
fn a_clock_that_is_set_back_by_a_year_leaves_nobody_idle_for_that_year() {
    let year = 366 * 86_400;
    let mut world = World::of([
        task(1, 1.0).every(5.0).with(|task| task.windows[0].opens = wall(10)),
        // It runs while the clock is set.
        task(2, 9.0).every(5.0).with(|task| task.windows[0].opens = wall(10)),
        task(3, 1.0).every(50.0),
    ]);
    world.until(3.0);
    world.jump(year);
    world.until(5.0);
    let last = |line: &str| line.split(' ').nth(4).and_then(|number| number.parse::<i64>().ok());
    let told = world.lines(&["task 1 occurrence"]);
    let number = told.into_iter().filter_map(last).max().unwrap();
    world.jump(-year);
    world.news();
    world.until(26.0);
    let starts = |id: u32| {
        let starts = world.lines(&[&format!("task {id} occurrence")]);
        starts.into_iter().filter(|line| line.ends_with("started")).collect::<Vec<_>>()
    };
    let times = |first: i64, at: &[u32]| {
        let numbers = first..;
        let lines = at.iter().zip(numbers);
        lines
            .map(|(at, of)| format!("{at}.000 task 1 occurrence {of} attempt 1 started"))
            .collect::<Vec<_>>()
    };
    // The anchor is the first time, and the phase is kept from it.
    assert_eq!(starts(1), times(number + 1, &[10, 15, 20, 25]));
    assert_eq!(starts(2).len(), 2, "{:?}", starts(2));
    assert!(world.lines(&["task 3"]).is_empty(), "it is relative");
}

/// The control: what is set back within an interval is only late.
#[test]
fn a_clock_that_is_set_back_a_little_shifts_nothing() {
    let mut world =
        World::of([task(1, 1.0).every(10.0).with(|task| task.windows[0].opens = wall(0))]);
    world.until(12.0);
    world.jump(-4);
    world.until(30.0);
    assert_eq!(
        starts(&world),
        [
            "0.000 task 1 attempt 1 started",
            "10.000 task 1 occurrence 1 attempt 1 started",
            "24.000 task 1 occurrence 2 attempt 1 started",
        ]
    );
}

#[test]
fn one_that_is_loaded_late_starts_with_the_present_occurrence_if_its_window_is_open() {
    let late = |id: u32| task(id, 1.0).every(10.0).with(|task| task.windows[0].opens = wall(-25));
    let closed = late(2).with(|task| task.windows[0].closes = wall(-22));
    let mut world = World::of([late(1), closed]);
    world.until(6.0);
    assert_eq!(
        starts(&world),
        [
            "0.000 task 1 occurrence 2 attempt 1 started",
            "5.000 task 1 occurrence 3 attempt 1 started",
            "5.000 task 2 occurrence 3 attempt 1 started",
        ]
    );
    assert!(world.lines(&["missed"]).is_empty(), "what was before the load is no miss");
}

#[test]
fn misses_that_go_on_can_be_asked_for() {
    let mut world = World::of([task(2, 25.0).every(10.0)]);
    world.until(15.0);
    let misses: Vec<_> = world.manager().untold().map(|note| note.to_string()).collect();
    assert_eq!(misses, ["task 2 missed occurrence 1: the one before was still running"]);
}

/// Who writes 5 for the latest start, and means +5, has occurrences that have
/// been over since 1970.
#[test]
fn occurrences_that_were_over_long_ago_are_counted_and_not_looked_at() {
    let closed = task(1, 1.0).every(1.0).with(|task| {
        task.windows[0].closes = When::At(UnixTime::from_secs(5));
    });
    let cut_off = task(2, 1.0).every(1.0).with(|task| {
        task.cutoff = When::At(UnixTime::from_secs(5));
    });
    let mut world = World::of([closed, cut_off]);
    world.until(3.5);
    assert!(starts(&world).is_empty());
    let untold: Vec<_> = world.manager().untold().map(|note| note.to_string()).collect();
    // What was before the load is no miss; of each the present one is.
    let last = BEGAN - 5 + 3;
    assert_eq!(
        untold,
        [
            format!("task 1 missed {last} occurrences, 1 to {last}: its window closed"),
            format!(
                "task 2 missed {} occurrences, 0 to {}: its cutoff came before it could start",
                last + 1,
                last
            ),
        ]
    );
    assert!(world.journal.records.len() < 30, "{}", world.journal.records.len());
}
