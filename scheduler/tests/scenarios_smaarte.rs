//! What SMAARTE's papers show, on the virtual executive: the files of `cases/`.

mod support;

use faregate_scheduler::analyze::{Analysis, Options, analyze};
use faregate_scheduler::format::{self, Kind};
use faregate_scheduler::mission::Mission;
use faregate_scheduler::task::Task;

use support::{analysis, every, report, s, seconds, segments, starts, task};

fn case(name: &str) -> Vec<Task> {
    let path = format!("{}/tests/cases/{name}", env!("CARGO_MANIFEST_DIR"));
    let bytes = std::fs::read(path).unwrap();
    assert!(Kind::of(name).is_some());
    format::read(name, &bytes).unwrap().tasks
}

fn analyzed(name: &str, options: &Options) -> Analysis {
    analyze(&case(name), &Mission::default(), options).unwrap()
}

fn makespan(name: &str, serial: bool) -> Option<u64> {
    analyzed(name, &Options { serial, ..Options::default() }).makespan.map(seconds)
}

#[test]
fn nine_tasks_on_three_resources_take_a_third_of_the_time() {
    assert_eq!(makespan("smaarte_nine_tasks.csv", false), Some(45));
    assert_eq!(makespan("smaarte_nine_tasks.csv", true), Some(135));
}

#[test]
fn buffers_between_tasks_of_one_resource_cost_ten_seconds() {
    assert_eq!(makespan("smaarte_nine_tasks_gap.csv", false), Some(55));
    // One at a time, another resource's task always lies in the buffer.
    assert_eq!(makespan("smaarte_nine_tasks_gap.csv", true), Some(135));
}

#[test]
fn two_resources_work_off_their_tasks_side_by_side_by_priority() {
    for name in ["smaarte_fig4.csv", "smaarte_fig4.txt"] {
        let analysis = analyzed(name, &Options::default());
        assert_eq!(
            starts(&analysis),
            [(0, 13), (0, 16), (3, 12), (3, 15), (6, 11), (6, 14)],
            "{name}"
        );
        assert_eq!(analysis.makespan, Some(s(9)), "{name}");
        assert_eq!(analysis.problems, [], "{name}");
        let waited = [11, 12, 13].map(|number| seconds(report(&analysis, number).waited));
        assert_eq!(waited, [6, 3, 0], "{name}");
        let reason = report(&analysis, 12).reason.as_deref();
        assert_eq!(reason, Some("waited for categories 0x1, which task 13 has"), "{name}");
    }
}

#[test]
fn the_more_important_one_goes_first_whatever_the_order_of_the_file() {
    let analysis = analyzed("smaarte_2018_priority.txt", &Options::default());
    assert_eq!(starts(&analysis), [(0, 23), (3, 22), (6, 21)]);
}

#[test]
fn routine_tasks_go_by_priority_in_each_of_their_rounds() {
    let tasks: Vec<_> =
        case("smaarte_2018_priority.txt").into_iter().map(|task| every(task, 20)).collect();
    let analysis = analysis(&tasks, &Mission::default(), 60);
    let round = |begins| [(begins, 23), (begins + 3, 22), (begins + 6, 21)];
    assert_eq!(starts(&analysis), [round(0), round(20), round(40)].concat());
}

/// What the authors of 2018 say does not work in their schedule manager: a
/// priority against a task that runs already.
#[test]
fn a_more_important_task_stops_one_that_runs() {
    let analysis =
        analyzed("smaarte_preempt.csv", &Options { horizon: Some(s(70)), ..Options::default() });
    assert_eq!(segments(&analysis, 31), [vec![(0, 5), (11, 26)], vec![(60, 70)]]);
    assert_eq!(segments(&analysis, 32), [[(5, 11)]]);
    assert_eq!(seconds(report(&analysis, 31).waited), 6);
    assert_eq!(
        report(&analysis, 31).reason.as_deref(),
        Some("waited for categories 0x1, which task 32 has")
    );
    assert_eq!(analysis.makespan, Some(s(11)));
}

#[test]
fn a_routine_task_is_looked_at_for_a_day() {
    let analysis = analyzed("smaarte_preempt.csv", &Options::default());
    assert_eq!(analysis.horizon, s(86_400));
    assert_eq!(report(&analysis, 31).runs.len(), 1_440);
}

/// The demonstration of 2018 with tasks that arrive one after the other.
#[test]
fn each_more_important_arrival_takes_over_and_gives_back() {
    let tasks = [
        task(21, 30, 1, 1),
        support::due(task(22, 10, 1, 2), 5),
        support::due(task(23, 3, 1, 3), 8),
    ];
    let analysis = analysis(&tasks, &Mission::default(), 100);
    assert_eq!(segments(&analysis, 21), [[(0, 5), (18, 43)]]);
    assert_eq!(segments(&analysis, 22), [[(5, 8), (11, 18)]]);
    assert_eq!(segments(&analysis, 23), [[(8, 11)]]);
}
