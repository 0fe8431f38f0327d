//! A manager's thread over a control port, with a schedule that is a list.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use faregate_client::wire::control::MAX_ROWS;
use faregate_client::{Control, Problem, RefusalKind, Refused};
use faregate_scheduler::control::{ControlCounts, Links, SocketLink, StatusSource};
use faregate_scheduler::executive::{Outside, Waker};
use faregate_scheduler::manager::{
    Event, HeldBy, Note, Occurrence, Reply, State, TaskStatus, Telecommand, WaitsFor,
};
use faregate_scheduler::task::Body;
use faregate_scheduler::time::{Instant, Now, UnixTime};
use faregate_scheduler::{Task, TaskId};

/// Longer than anything here takes on any machine: who waits so long hangs.
pub(crate) const LONG: Duration = Duration::from_secs(60);

pub(crate) fn id(number: u32) -> TaskId {
    TaskId::new(number).unwrap()
}

pub(crate) fn now() -> Now {
    Now { elapsed: Instant::from_micros(7), wall: UnixTime::from_micros(-9) }
}

/// A schedule in a file is a list of numbers here.
pub(crate) fn read(name: &str, text: &str) -> Result<Vec<Task>, Refused> {
    let tasks = text.split_whitespace().enumerate().map(|(line, word)| {
        let number = word.parse().ok().and_then(TaskId::new);
        number.map(|id| Task::new(id, Body::Hold)).ok_or(Problem {
            line: Some(u64::try_from(line).unwrap() + 1),
            message: format!("{word:?} is no task"),
            ..Problem::default()
        })
    });
    let (good, bad): (Vec<_>, Vec<_>) = tasks.partition(Result::is_ok);
    if bad.is_empty() {
        return Ok(good.into_iter().flatten().collect());
    }
    let problems = bad.into_iter().filter_map(Result::err).collect();
    Err(Refused::new(RefusalKind::Invalid, format!("{name} is not loaded")).with_problems(problems))
}

/// A task that the manager does not let go.
pub(crate) const KEPT: TaskId = TaskId::new(7).unwrap();

/// How many tasks are there from the beginning.
pub(crate) const THERE: usize = 9;

/// What stands where a manager will.
#[derive(Debug)]
pub(crate) struct Schedule {
    pub(crate) tasks: Vec<Task>,
    pub(crate) heard: Vec<Telecommand>,
    /// How often it was asked where a task stands.
    pub(crate) looked_at: Mutex<u32>,
}

impl Default for Schedule {
    fn default() -> Self {
        Self {
            tasks: holds(u32::try_from(THERE).unwrap()),
            heard: Vec::new(),
            looked_at: Mutex::default(),
        }
    }
}

fn holds(many: u32) -> Vec<Task> {
    (1..=many).map(|number| Task::new(id(number), Body::Hold)).collect()
}

impl StatusSource for Schedule {
    fn each(&self) -> impl Iterator<Item = TaskId> {
        self.tasks.iter().map(|task| task.id)
    }

    fn status(&self, task: TaskId) -> Option<TaskStatus> {
        *self.looked_at.lock().unwrap() += 1;
        Some(TaskStatus {
            occurrence: Occurrence { task: self.task(task)?.id, load: 0, number: 2 },
            state: State::Waiting(WaitsFor::Gate {
                gate: "camera".into(),
                by: HeldBy::Task(id(99)),
            }),
        })
    }

    fn task(&self, id: TaskId) -> Option<&Task> {
        self.tasks.iter().find(|task| task.id == id)
    }

    fn has_mode(&self, name: &str) -> bool {
        name == "recovery"
    }
}

impl Schedule {
    fn obey(&mut self, telecommand: Telecommand) -> Reply {
        self.heard.push(telecommand.clone());
        match telecommand {
            Telecommand::Add(additions) => {
                self.tasks.extend(additions.into_iter().map(|addition| addition.task));
                Reply::Done
            }
            Telecommand::Remove(ids) if ids.contains(&KEPT) => {
                Reply::Refused(format!("{KEPT} cannot be spared"))
            }
            _ => Reply::Done,
        }
    }
}

/// A manager's thread, as far as the control port sees it.
pub(crate) struct Stage {
    _directory: tempfile::TempDir,
    pub(crate) path: PathBuf,
    pub(crate) schedule: Arc<Mutex<Schedule>>,
    pub(crate) waker: Waker,
    stop: Arc<AtomicBool>,
    /// Set: the manager hears nothing for now.
    pub(crate) is_deaf: Arc<AtomicBool>,
    notes: std::sync::mpsc::Sender<Note>,
    counts: Arc<Mutex<ControlCounts>>,
    thread: Option<JoinHandle<()>>,
}

/// A link that two threads of a test look at.
struct Counted(SocketLink, Arc<Mutex<ControlCounts>>);

impl faregate_scheduler::control::Link for Counted {
    fn poll(&mut self, now: Now, asked: &mut Vec<faregate_scheduler::control::Asked>) {
        *self.1.lock().unwrap() = self.0.counts();
        self.0.poll(now, asked);
    }

    fn answer(
        &mut self,
        now: Now,
        to: faregate_scheduler::control::AskId,
        answer: faregate_client::wire::control::Answer,
    ) {
        self.0.answer(now, to, answer);
    }

    fn note(&mut self, now: Now, note: &Note) {
        self.0.note(now, note);
    }
}

impl Stage {
    pub(crate) fn new() -> Self {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("faregate.sock");
        let waker = Waker::new().unwrap();
        let link = SocketLink::listen(&path, Arc::new(read), waker.clone()).unwrap();
        let (notes, to_tell) = std::sync::mpsc::channel();
        let counts = Arc::<Mutex<ControlCounts>>::default();
        let mut stage = Self {
            _directory: directory,
            path,
            schedule: Arc::default(),
            waker: waker.clone(),
            stop: Arc::default(),
            is_deaf: Arc::default(),
            notes,
            counts: Arc::clone(&counts),
            thread: None,
        };
        let mut links = Links::new(Arc::new(read), waker.clone());
        links.add(Counted(link, counts));
        let (schedule, stop) = (Arc::clone(&stage.schedule), Arc::clone(&stage.stop));
        let is_deaf = Arc::clone(&stage.is_deaf);
        stage.thread = Some(std::thread::spawn(move || {
            while !stop.load(Ordering::Acquire) {
                wait(&waker);
                if is_deaf.load(Ordering::Acquire) {
                    continue;
                }
                let mut schedule = schedule.lock().unwrap();
                let mut events = Vec::new();
                links.collect(now(), &*schedule, &mut events);
                for event in events {
                    let Event::Telecommand { id, telecommand } = event else { continue };
                    let reply = schedule.obey(telecommand);
                    links.answer(now(), id, reply);
                }
                to_tell.try_iter().for_each(|note| links.note(now(), &note));
            }
        }));
        stage
    }

    pub(crate) fn client(&self) -> Control {
        let mut control = Control::connect(&self.path).unwrap();
        control.set_timeout(Some(LONG)).unwrap();
        control
    }

    pub(crate) fn note(&self, note: Note) {
        self.notes.send(note).unwrap();
        self.waker.wake();
    }

    pub(crate) fn counts(&self) -> ControlCounts {
        self.waker.wake();
        *self.counts.lock().unwrap()
    }

    pub(crate) fn heard(&self) -> Vec<Telecommand> {
        self.schedule.lock().unwrap().heard.clone()
    }

    /// As many tasks as two answers and a bit hold.
    pub(crate) fn fill(&self) -> u32 {
        let many = 2 * MAX_ROWS + 3;
        self.schedule.lock().unwrap().tasks = holds(many);
        many
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        self.waker.wake();
        let ended = self.thread.take().unwrap().join();
        assert!(ended.is_ok() || std::thread::panicking(), "the manager's thread panicked");
    }
}

fn wait(waker: &Waker) {
    use rustix::event::{PollFd, PollFlags, poll};
    poll(&mut [PollFd::new(waker, PollFlags::IN)], None).unwrap();
    let _ = waker.take();
}

/// Waits for something that is sure to come.
#[expect(clippy::disallowed_methods, reason = "what is waited for is another thread's")]
pub(crate) fn until(mut over: impl FnMut() -> bool) {
    let start = std::time::Instant::now();
    while !over() {
        assert!(start.elapsed() < LONG, "it does not come");
        std::thread::sleep(Duration::from_millis(1));
    }
}
