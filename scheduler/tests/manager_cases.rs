//! The demonstrations of SMAARTE's papers, decided by the manager on a virtual
//! clock.

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::executive::{LoadedFile, Outside, VirtualBodies, VirtualExecutive};
use faregate_scheduler::manager::{
    Addition, Attempt, Event, Note, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::task::{Body, Task, TaskId, TaskPriority, When};
use faregate_scheduler::time::{Duration, Instant, Now, UnixTime};

/// Writes down what happens, with its second.
#[derive(Debug, Default)]
struct Trace(Vec<(f64, String)>);

impl Outside for Trace {
    fn note(&mut self, now: Now, note: &Note) {
        let at = now.elapsed.as_micros() as f64 / 1e6;
        let line = match note {
            Note::Started(attempt) => format!("start {}", attempt.occurrence.task.get()),
            Note::Paused(attempt) => format!("pause {}", attempt.occurrence.task.get()),
            Note::Resumed(attempt) => format!("resume {}", attempt.occurrence.task.get()),
            Note::Ended { occurrence, outcome } => {
                format!("end {} {outcome:?}", occurrence.task.get())
            }
            Note::Missed { task, first, last, count, why } => {
                format!("missed {} {first}..={last} {count}: {why}", task.get())
            }
            _ => return,
        };
        self.0.push((at, line));
    }

    fn answer(&mut self, _: Now, _: TelecommandId, reply: Reply) {
        assert_eq!(reply, Reply::Done);
    }

    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        None
    }
}

fn task(id: u32, seconds: u64, categories: u128, priority: u8) -> Task {
    let body = Body::Process { program: "sleep".into(), arguments: vec![seconds.to_string()] };
    let mut task = Task::new(TaskId::new(id).unwrap(), body);
    task.duration = Duration::from_secs(seconds);
    task.categories = Categories::from_mask(categories);
    task.priority = TaskPriority::new(priority).unwrap();
    task
}

fn run(tasks: Vec<Task>, until: u64) -> Vec<(f64, String)> {
    let mut executive = VirtualExecutive::new(
        Mission::default(),
        UnixTime::from_secs(1_700_000_000),
        VirtualBodies::as_expected(),
        Trace::default(),
    );
    let additions = tasks.into_iter().map(|task| Addition { task }).collect();
    executive.tell(Event::Telecommand {
        id: TelecommandId(1),
        telecommand: Telecommand::Add(additions),
    });
    executive.advance_to(Instant::from_micros(until * 1_000_000)).unwrap();
    executive.into_outside().0
}

fn lines(trace: &[(f64, String)]) -> Vec<String> {
    trace.iter().map(|(at, line)| format!("{at} {line}")).collect()
}

#[test]
fn tasks_of_one_category_run_one_after_the_other_most_important_first() {
    let tasks = (1..=6).map(|n| task(10 + n, 3, u128::from(n > 3) + 1, [1, 2, 3][(n as usize - 1) % 3]));
    let trace = run(tasks.collect(), 100);
    let starts: Vec<_> = lines(&trace).into_iter().filter(|line| line.contains("start")).collect();
    assert_eq!(
        starts,
        ["0 start 13", "0 start 16", "3 start 12", "3 start 15", "6 start 11", "6 start 14"]
    );
    assert_eq!(trace.last().unwrap().0, 9.0);
}

#[test]
fn nine_tasks_on_three_resources_take_a_third_and_55_seconds_with_gaps() {
    let tasks = |gap| -> Vec<Task> {
        let nine = (0..9_u32).map(|n| {
            let mut task = task(n + 1, 15, 1 << (n / 3), [3, 2, 1][n as usize % 3]);
            task.gap = Duration::from_secs(gap);
            task
        });
        nine.collect()
    };
    assert_eq!(run(tasks(0), 1_000).last().unwrap().0, 45.0);
    assert_eq!(run(tasks(5), 1_000).last().unwrap().0, 55.0);
}

#[test]
fn a_more_important_task_pauses_a_routine_one_which_goes_on_and_keeps_its_phase() {
    let mut routine = task(31, 20, 1, 1);
    routine.interval = Some(Duration::from_secs(60));
    let mut urgent = task(32, 6, 1, 5);
    urgent.windows[0].opens = When::AfterLoad(Duration::from_secs(5));
    let trace = run(vec![routine, urgent], 90);
    assert_eq!(
        lines(&trace),
        [
            "0 start 31",
            "5 pause 31",
            "5 start 32",
            "11 end 32 Succeeded",
            "11 resume 31",
            "26 end 31 Succeeded",
            "60 start 31",
            "80 end 31 Succeeded",
        ]
    );
}
