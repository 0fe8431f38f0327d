//! The manager, real bodies and a real broker together: who is more important
//! takes the tickets of a task that runs, and gives them back.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

use std::sync::{Arc, Mutex};

use faregate_agents::Categories;
use faregate_scheduler::executive::{Correspondent, LoadedFile, Outside, Watched};
use faregate_scheduler::manager::{
    Addition, Attempt, Event, Manager, Note, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::task::{Body, Outcome, Task, TaskId, TaskPriority};
use faregate_scheduler::time::Now;
use faregate_scheduler::{Mission, Onboard};

/// Keeps what is told, and adds tasks as soon as an attempt has started.
#[derive(Clone, Default)]
struct Recorder {
    told: Arc<Mutex<Vec<Note>>>,
    then: Arc<Mutex<Vec<Task>>>,
}

impl Outside for Recorder {
    fn note(&mut self, _: Now, note: &Note) {
        self.told.lock().unwrap().push(note.clone());
    }
    fn answer(&mut self, _: Now, _: TelecommandId, reply: Reply) {
        assert_eq!(reply, Reply::Done);
    }
    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        None
    }
}

impl Watched for Recorder {}

impl Correspondent for Recorder {
    fn poll(&mut self, _: Now, _: &Manager, events: &mut Vec<Event>) {
        let started = |note: &Note| matches!(note, Note::Started(_));
        if self.told.lock().unwrap().iter().any(started) {
            let then = std::mem::take(&mut *self.then.lock().unwrap());
            let additions: Vec<_> = then.into_iter().map(|task| Addition { task }).collect();
            if !additions.is_empty() {
                let telecommand = Telecommand::Add(additions);
                events.push(Event::Telecommand { id: TelecommandId(1), telecommand });
            }
        }
    }
}

fn shell(number: u32, script: &str, priority: u8) -> Task {
    let arguments = vec!["-c".into(), script.into()];
    let body = Body::Process { program: "/bin/sh".into(), arguments };
    Task {
        categories: Categories::from_mask(1),
        priority: TaskPriority::new(priority).unwrap(),
        ..Task::new(TaskId::new(number).unwrap(), body)
    }
}

/// A task that ends when the other one has done its work.
fn pair(directory: &std::path::Path) -> [Task; 2] {
    let file = directory.join("done").display().to_string();
    let waits = shell(1, &format!("until [ -e '{file}' ]; do sleep 0.01; done"), 1);
    [waits, shell(2, &format!("touch '{file}'"), 9)]
}

/// Runs the first tasks, and adds the others when one of them has started.
fn trace(first: Vec<Task>, then: Vec<Task>) -> Vec<String> {
    let recorder = Recorder::default();
    recorder.then.lock().unwrap().extend(then);
    let told = recorder.clone();
    let builder = Onboard::builder(Mission::default()).unwrap();
    let mut onboard = builder.start_with(|_, _, _| Ok(recorder)).unwrap();
    onboard.load(first).unwrap();
    onboard.run(|manager, _| manager.is_over()).unwrap();
    let notes = told.told.lock().unwrap();
    notes.iter().filter_map(words).collect()
}

/// What happened to bodies, in a few words.
fn words(note: &Note) -> Option<String> {
    let of = |attempt: &Attempt| attempt.occurrence.task.get();
    Some(match note {
        Note::Started(attempt) => format!("{} starts", of(attempt)),
        Note::Stopping { attempt, why } => format!("{} stops: {why}", of(attempt)),
        Note::Paused(attempt) => format!("{} stands still", of(attempt)),
        Note::Resumed(attempt) => format!("{} goes on", of(attempt)),
        Note::Ended { occurrence, outcome: Outcome::Succeeded } => {
            format!("{} succeeded", occurrence.task.get())
        }
        Note::Ended { occurrence, outcome } => format!("{} {outcome:?}", occurrence.task.get()),
        _ => return None,
    })
}

#[test]
fn a_running_process_is_paused_for_a_more_important_one_and_goes_on() {
    let directory = tempfile::tempdir().unwrap();
    let [waits, urgent] = pair(directory.path());
    let expected = [
        "1 starts",
        "1 stops: task 2",
        "1 stands still",
        "2 starts",
        "2 succeeded",
        "1 goes on",
        "1 succeeded",
    ];
    assert_eq!(trace(vec![waits], vec![urgent]), expected);
}

/// The control: without a category in common nobody is disturbed.
#[test]
fn processes_that_share_nothing_run_side_by_side() {
    let directory = tempfile::tempdir().unwrap();
    let [waits, urgent] = pair(directory.path());
    let other = Task { categories: Categories::from_mask(2), ..urgent };
    let told = trace(vec![waits], vec![other]);
    assert_eq!(told[..2], ["1 starts", "2 starts"]);
    assert_eq!(told.len(), 4);
}

#[test]
fn three_that_conflict_run_one_after_the_other_by_importance() {
    let tasks = [(1, 3), (2, 5), (3, 4)].map(|(number, priority)| shell(number, "", priority));
    let order = [2, 3, 1];
    let expected: Vec<String> =
        order.iter().flat_map(|n| [format!("{n} starts"), format!("{n} succeeded")]).collect();
    assert_eq!(trace(tasks.to_vec(), Vec::new()), expected);
}
