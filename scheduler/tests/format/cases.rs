//! The files in `tests/cases`.

use faregate_scheduler::Task;
use faregate_scheduler::format::{self, Rule};
use faregate_scheduler::task::{Body, Preemption, When, Window};
use faregate_scheduler::time::Duration;

use crate::support::{good, told};

fn case(name: &str) -> Vec<Task> {
    let path = format!("{}/tests/cases/{name}", env!("CARGO_MANIFEST_DIR"));
    good(name, &std::fs::read_to_string(path).unwrap()).tasks
}

#[test]
fn commas_and_spaces_say_the_same() {
    let tasks = case("smaarte_fig4.csv");
    assert_eq!(tasks, case("smaarte_fig4.txt"));
    let rows: Vec<_> = (tasks.iter())
        .map(|task| (task.id.get(), task.categories.mask(), task.priority.level()))
        .collect();
    assert_eq!(rows, [(11, 1, 1), (12, 1, 2), (13, 1, 3), (14, 2, 1), (15, 2, 2), (16, 2, 3)]);
    for task in tasks {
        assert_eq!(task.duration, Duration::from_secs(3));
        let sleep = Body::Process { program: "sleep".into(), arguments: vec!["3".into()] };
        assert_eq!((task.body, task.preemption), (sleep, Preemption::Pause));
    }
}

#[test]
fn a_known_extra_column_is_read() {
    let gaps: Vec<_> = case("smaarte_nine_tasks_gap.csv").iter().map(|task| task.gap).collect();
    assert_eq!(gaps, [Duration::from_secs(5); 9]);
    assert_eq!(case("smaarte_nine_tasks.csv").len(), 9);
}

#[test]
fn a_start_can_be_relative_and_a_task_can_come_back() {
    let tasks = case("smaarte_preempt.csv");
    let opens = When::AfterLoad(Duration::from_secs(5));
    assert_eq!(tasks[1].windows, [Window { opens, closes: When::Unrestricted }]);
    assert_eq!(tasks[0].interval, Some(Duration::from_secs(60)));
    assert_eq!(case("smaarte_2018_priority.txt").len(), 3);
}

#[test]
fn every_mistake_of_a_bad_schedule_is_told_and_nothing_is_loaded() {
    let text = include_bytes!("../cases/bad_schedule.csv");
    let found = format::read("bad_schedule.csv", text).unwrap_err();
    let expected = [
        (3, 1, Rule::Duplicate),
        (4, 8, Rule::Window),
        (5, 8, Rule::Range),
        (6, 10, Rule::Range),
        (7, 18, Rule::Missing),
        (8, 1, Rule::Value),
        (9, 11, Rule::Missing),
    ];
    assert_eq!(told(&found), expected);
    assert!(found.iter().all(|wrong| wrong.expected.is_some()));
    let fields: Vec<_> = found.iter().map(|wrong| wrong.field.as_deref()).collect();
    let names = [Some("id"), Some("et"), Some("dur"), Some("con"), Some("args"), Some("id"), None];
    assert_eq!(fields, names);
}
