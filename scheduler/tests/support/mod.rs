//! What several tests of the schedule manager want: tasks in few words, cases,
//! generated schedules.

#![expect(dead_code, reason = "each test uses a part of it")]

pub(crate) mod generate;
pub(crate) mod week;

use faregate_agents::Categories;
use faregate_scheduler::analyze::{Analysis, Options, Run, TaskReport, analyze};
use faregate_scheduler::executive::{LoadedFile, Outside};
use faregate_scheduler::manager::{Attempt, Note, Reply, TelecommandId};
use faregate_scheduler::mission::Mission;
use faregate_scheduler::task::{Body, Task, TaskId, TaskPriority, When, Window};
use faregate_scheduler::time::{Duration, Instant, Now};

pub(crate) fn id(number: u32) -> TaskId {
    TaskId::new(number).unwrap()
}

pub(crate) const fn s(seconds: u64) -> Duration {
    Duration::from_secs(seconds)
}

/// A program that is due at the load, of this duration, conflict mask and
/// priority.
pub(crate) fn task(number: u32, duration: u64, mask: u128, priority: u8) -> Task {
    let program = "sleep".to_owned();
    let body = Body::Process { program, arguments: vec![duration.to_string()] };
    let mut task = Task::new(id(number), body);
    task.duration = s(duration);
    task.categories = Categories::from_mask(mask);
    task.priority = TaskPriority::new(priority).unwrap();
    task
}

/// Due so long after the load.
pub(crate) fn due(mut task: Task, after: u64) -> Task {
    task.windows = vec![Window { opens: When::AfterLoad(s(after)), closes: When::Unrestricted }];
    task
}

/// Not to be started later than so long after the load.
pub(crate) fn until(mut task: Task, after: u64) -> Task {
    for window in &mut task.windows {
        window.closes = When::AfterLoad(s(after));
    }
    task
}

pub(crate) fn every(mut task: Task, interval: u64) -> Task {
    task.interval = Some(s(interval));
    task
}

/// What becomes of these tasks until then.
pub(crate) fn analysis(tasks: &[Task], mission: &Mission, horizon: u64) -> Analysis {
    let options = Options { horizon: Some(s(horizon)), ..Options::default() };
    analyze(tasks, mission, &options).unwrap()
}

/// The segments of each of the task's runs, in whole seconds.
pub(crate) fn segments(analysis: &Analysis, number: u32) -> Vec<Vec<(u64, u64)>> {
    let whole = |(from, until): &(Duration, Duration)| (seconds(*from), seconds(*until));
    let runs = report(analysis, number).runs.iter();
    runs.map(|run| run.segments.iter().map(whole).collect()).collect()
}

pub(crate) fn report(analysis: &Analysis, number: u32) -> &TaskReport {
    analysis.tasks.iter().find(|task| task.id == id(number)).unwrap()
}

pub(crate) fn seconds(duration: Duration) -> u64 {
    assert_eq!(duration.as_micros() % 1_000_000, 0, "{duration}");
    duration.as_micros() / 1_000_000
}

/// Each run of each task, by its start.
pub(crate) fn starts(analysis: &Analysis) -> Vec<(u64, u32)> {
    let of = |task: &TaskReport, run: &Run| (seconds(run.start), task.id.get());
    let tasks = analysis.tasks.iter();
    let mut starts: Vec<_> =
        tasks.flat_map(|task| task.runs.iter().map(move |run| of(task, run))).collect();
    starts.sort_unstable();
    starts
}

/// Remembers what it is told. A telecommand that is refused fails the test.
#[derive(Debug, Default)]
pub(crate) struct Told {
    pub(crate) notes: Vec<(Instant, Note)>,
}

impl Outside for Told {
    fn note(&mut self, now: Now, note: &Note) {
        self.notes.push((now.elapsed, note.clone()));
    }

    fn answer(&mut self, _: Now, id: TelecommandId, reply: Reply) {
        assert_eq!(reply, Reply::Done, "{id:?}");
    }

    fn load(&mut self, _: Attempt, path: &str) -> Option<LoadedFile> {
        Some(Err(format!("{path}: there are no files")))
    }
}
