//! A schedule file that a task loads, from a disk that takes its time: nobody
//! else waits for it.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::time;

use faregate_client::{RefusalKind, Refused};
use faregate_scheduler::control::Links;
use faregate_scheduler::executive::{Correspondent, LoadedFile, Outside, Watched};
use faregate_scheduler::manager::{Attempt, Event, Manager, Note, Reply, TelecommandId};
use faregate_scheduler::task::{Body, BuiltIn, Outcome, Task, TaskId};
use faregate_scheduler::time::{Duration, Now};
use faregate_scheduler::{Mission, Onboard};
use parking_lot::Mutex;

/// How long the disk waits for what it is to wait for. It is as long as this
/// only where the manager waits for the disk.
const LONG: time::Duration = time::Duration::from_secs(60);

/// Keeps what ended, and has the disk answer when the given task has.
struct Recorder {
    links: Links,
    ended: Arc<Mutex<Vec<(u32, Outcome)>>>,
    answers_after: u32,
    disk: Sender<()>,
}

impl Outside for Recorder {
    fn note(&mut self, _: Now, note: &Note) {
        if let Note::Ended { occurrence, outcome } = note {
            let task = occurrence.task.get();
            self.ended.lock().push((task, *outcome));
            if task == self.answers_after {
                let _ = self.disk.send(());
            }
        }
    }

    fn answer(&mut self, now: Now, id: TelecommandId, reply: Reply) {
        self.links.answer(now, id, reply);
    }

    fn load(&mut self, attempt: Attempt, path: &str) -> Option<LoadedFile> {
        self.links.load(attempt, path)
    }
}

impl Watched for Recorder {}

impl Correspondent for Recorder {
    fn poll(&mut self, now: Now, manager: &Manager, events: &mut Vec<Event>) {
        self.links.poll(now, manager, events);
    }

    fn loaded(&mut self) -> Option<(Attempt, LoadedFile)> {
        self.links.loaded()
    }
}

fn task(number: u32, body: Body) -> Task {
    Task::new(TaskId::new(number).unwrap(), body)
}

fn hold(number: u32) -> Task {
    Task { duration: Duration::from_millis(10), ..task(number, Body::Hold) }
}

#[test]
fn a_slow_disk_delays_no_task_and_its_file_is_loaded_in_the_end() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("more.csv");
    std::fs::write(&file, "").unwrap();
    let (disk, answer) = channel();
    let answer = Mutex::new(answer);
    let read = move |_: &str, _: &str| {
        let came = answer.lock().recv_timeout(LONG);
        came.map(|()| vec![hold(7)])
            .map_err(|_| Refused::new(RefusalKind::NotDone, "the disk waited in vain"))
    };
    let ended = Arc::<Mutex<_>>::default();
    let told = Arc::clone(&ended);
    let builder = Onboard::builder(Mission::default()).unwrap().reading(Arc::new(read));
    let recorder = |links, _: &_, _: &_| Ok(Recorder { links, ended, answers_after: 2, disk });
    let mut onboard = builder.start_with(recorder).unwrap();
    let load = Body::BuiltIn(BuiltIn::Load(file.display().to_string()));
    onboard.load(vec![task(1, load), hold(2)]).unwrap();
    onboard.run(|manager, _| manager.is_over()).unwrap();
    let succeeded = |task| (task, Outcome::Succeeded);
    assert_eq!(*told.lock(), [2, 1, 7].map(succeeded));
}
