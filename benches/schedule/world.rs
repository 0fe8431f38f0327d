//! Schedules of every size, alike in all but size, for the manager and for its
//! peer.
//!
//! One task runs on the category that everybody wants. A tenth of the others
//! are due and wait for it. The rest become due in time, a hundredth of the
//! schedule at each second.

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::manager::{
    Action, Addition, Attempt, Event, Exit, Manager, Occurrence, Telecommand, TelecommandId,
};
use faregate_scheduler::task::{Body, Task, TaskId, TaskPriority, When, Window};
use faregate_scheduler::time::{Duration, Instant, Now, UnixTime};

use crate::smaarte::{Entry, Schedule};

/// The category that everybody wants.
const WANTED: u128 = 1;
/// More important than any other.
const HOLDER: u8 = 200;

/// When each task is due, in seconds, and its priority: the same for both.
fn tasks(size: u32) -> impl Iterator<Item = (u32, u64, u8)> {
    let mut random = fastrand::Rng::with_seed(u64::from(size));
    (2..=size).map(move |id| {
        let hundredth = u64::from(id) * 100 / u64::from(size);
        let due = hundredth.saturating_sub(9);
        (id, due, random.u8(0..HOLDER))
    })
}

pub(crate) fn id(number: u32) -> TaskId {
    TaskId::new(number).expect("tasks count from 1")
}

pub(crate) fn task(number: u32, due: u64, priority: u8) -> Task {
    let mut task = Task::new(id(number), Body::Hold);
    task.priority = TaskPriority::new(priority).expect("below the fault responses");
    task.categories = Categories::from_mask(WANTED);
    task.duration = Duration::from_secs(1_000_000);
    if due > 0 {
        let opens = When::AfterLoad(Duration::from_secs(due));
        task.windows = vec![Window { opens, closes: When::Unrestricted }];
    }
    task
}

/// The manager in its schedule, with tickets that are granted at once.
#[derive(Clone, Debug)]
pub(crate) struct World {
    manager: Manager,
    seconds: u64,
    pub(crate) runs: Option<Attempt>,
    asks: Vec<Occurrence>,
    actions: Vec<Action>,
}

impl World {
    pub(crate) fn new(size: u32) -> Self {
        let mut world = Self {
            manager: Manager::new(Mission::default()),
            seconds: 0,
            runs: None,
            asks: Vec::new(),
            actions: Vec::new(),
        };
        let mut all = vec![task(1, 0, HOLDER)];
        all.extend(tasks(size).map(|(id, due, priority)| task(id, due, priority)));
        world
            .telecommand(Telecommand::Add(all.into_iter().map(|task| Addition { task }).collect()));
        world.grant();
        world
    }

    fn now(&self) -> Now {
        let elapsed = Duration::from_secs(self.seconds);
        Now { elapsed: Instant::START.after(elapsed), wall: UnixTime::from_secs(0).after(elapsed) }
    }

    /// One event, one decision.
    pub(crate) fn step(&mut self, events: Vec<Event>) {
        let now = self.now();
        self.actions.clear();
        self.manager.step(now, events, &mut self.actions);
    }

    /// What the executive would do about the latest decision: tickets are
    /// granted at once, once victims have stopped.
    pub(crate) fn follow(&mut self) {
        for action in &self.actions {
            match action {
                Action::Request { occurrence, .. } => self.asks.push(*occurrence),
                Action::Start { attempt } => self.runs = Some(*attempt),
                _ => {}
            }
        }
    }

    pub(crate) fn grants(&mut self) -> Vec<Event> {
        self.asks.drain(..).map(|occurrence| Event::Granted { occurrence }).collect()
    }

    fn grant(&mut self) {
        loop {
            self.follow();
            let grants = self.grants();
            if grants.is_empty() {
                return;
            }
            self.step(grants);
        }
    }

    pub(crate) fn telecommand(&mut self, telecommand: Telecommand) {
        self.step(vec![Event::Telecommand { id: TelecommandId(0), telecommand }]);
    }

    /// The next hundredth becomes due.
    pub(crate) fn become_due(&mut self) {
        self.seconds += 1;
        self.step(Vec::new());
    }

    /// The running task ends.
    pub(crate) fn end(&mut self) {
        let Some(attempt) = self.runs.take() else { return };
        self.step(vec![Event::Exited { attempt, exit: Exit::Code(0) }]);
    }

    /// Its tickets are taken by somebody outside.
    pub(crate) fn revoke(&mut self) {
        let Some(attempt) = self.runs else { return };
        let by = String::from("a fault response");
        self.step(vec![Event::Taken { occurrence: attempt.occurrence, by }]);
    }

    /// It stands still, and has its tickets again.
    pub(crate) fn restore(&mut self) {
        let Some(attempt) = self.runs else { return };
        self.step(vec![Event::Stopped { attempt }]);
        self.step(vec![Event::Granted { occurrence: attempt.occurrence }]);
    }
}

/// The same schedule for the peer.
pub(crate) fn peer(size: u32) -> Schedule {
    let entry = |id, start, priority: u8, active| Entry {
        id,
        start,
        end: 0,
        conflict: 1,
        priority: priority.into(),
        active,
    };
    let mut entries = vec![entry(1, 0, HOLDER, true)];
    entries.extend(tasks(size).map(|(id, due, priority)| entry(id, due, priority, false)));
    Schedule { entries }
}
