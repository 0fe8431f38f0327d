//! A manager with bodies and tickets on a clock that the test moves, and all
//! that it says.

use std::collections::BTreeMap;
use std::io;

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::executive::{
    Conduct, Driver, JournalSink, LoadedFile, Outside, Ports, TicketPort, VirtualBodies,
    VirtualTickets, expected,
};
use faregate_scheduler::manager::{
    Addition, Attempt, Event, Exit, Manager, Note, Record, Reply, Restored, Telecommand,
    TelecommandId,
};
use faregate_scheduler::task::{Body, Task, TaskId, TaskPriority, When};
use faregate_scheduler::time::{Duration, Instant, Now, UnixTime};

/// The time of day at which every test begins, in seconds since 1970.
pub(crate) const BEGAN: i64 = 1_700_000_000;

/// What was said, in order.
#[derive(Debug, Default)]
pub(crate) struct Log {
    pub(crate) lines: Vec<String>,
    pub(crate) replies: BTreeMap<TelecommandId, Reply>,
    pub(crate) files: BTreeMap<String, LoadedFile>,
    /// Who waits for the file that takes its time.
    pub(crate) reads_slowly: Option<Attempt>,
}

/// The file that is read later: when the test says so.
pub(crate) const SLOW: &str = "slow.csv";

impl Log {
    fn say(&mut self, now: Now, text: &str) {
        let ms = now.elapsed.as_micros() / 1_000;
        self.lines.push(format!("{}.{:03} {text}", ms / 1_000, ms % 1_000));
    }
}

/// What was written.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    pub(crate) records: Vec<Record>,
    /// Indexes into `records`: everything before was synced then.
    pub(crate) syncs: Vec<usize>,
}

impl JournalSink for Kept {
    fn append(&mut self, record: &Record) -> io::Result<()> {
        self.records.push(record.clone());
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        self.syncs.push(self.records.len());
        Ok(())
    }
}

struct People<'a>(&'a mut Log);

impl Outside for People<'_> {
    fn note(&mut self, now: Now, note: &Note) {
        if !matches!(note, Note::Accepted(_)) {
            self.0.say(now, &note.to_string());
        }
    }

    fn answer(&mut self, _: Now, id: TelecommandId, reply: Reply) {
        self.0.replies.insert(id, reply);
    }

    fn load(&mut self, attempt: Attempt, path: &str) -> Option<LoadedFile> {
        if path == SLOW {
            self.0.reads_slowly = Some(attempt);
            return None;
        }
        Some(self.0.files.remove(path).unwrap_or_else(|| Err(format!("no file {path}"))))
    }
}

pub(crate) struct World {
    driver: Driver,
    pub(crate) bodies: VirtualBodies,
    pub(crate) tickets: Box<dyn TicketPort>,
    pub(crate) log: Log,
    pub(crate) journal: Kept,
    pub(crate) elapsed_us: u64,
    /// How far the time of day is ahead of where it would be, had it not been
    /// set.
    pub(crate) ahead_us: i64,
    asked: u64,
}

impl World {
    pub(crate) fn new(mission: Mission) -> Self {
        Self::with_bodies(mission, VirtualBodies::as_expected())
    }

    pub(crate) fn with_bodies(mission: Mission, bodies: VirtualBodies) -> Self {
        Self {
            driver: Driver::new(mission),
            bodies,
            tickets: Box::new(VirtualTickets::default()),
            log: Log::default(),
            journal: Kept::default(),
            elapsed_us: 0,
            ahead_us: 0,
            asked: 0,
        }
    }

    /// A world without devices, in which these tasks are loaded at once.
    pub(crate) fn of(tasks: impl IntoIterator<Item = Task>) -> Self {
        let mut world = Self::new(Mission::default());
        world.add(tasks);
        world
    }

    /// The same, where the tasks of these ids end with these exits.
    pub(crate) fn ending(tasks: impl IntoIterator<Item = Task>, exits: &[(u32, Exit)]) -> Self {
        let exits = exits.to_vec();
        let mut world = Self::with_bodies(Mission::default(), bodies_ending(exits));
        world.add(tasks);
        world
    }

    /// Goes on from what a journal gave back, `down_s` seconds later.
    pub(crate) fn restored(mission: Mission, restored: Restored, down_s: u64) -> Self {
        let mut world = Self::new(mission.clone());
        world.ahead_us = i64::try_from(down_s * 1_000_000).unwrap();
        let now = world.now();
        let mut ports = Ports {
            bodies: &mut world.bodies,
            tickets: &mut *world.tickets,
            journal: &mut world.journal,
            outside: &mut People(&mut world.log),
        };
        world.driver = Driver::restore(mission, restored, now, &mut ports).unwrap();
        world
    }

    pub(crate) fn now(&self) -> Now {
        let wall = BEGAN * 1_000_000 + i64::try_from(self.elapsed_us).unwrap() + self.ahead_us;
        Now { elapsed: Instant::from_micros(self.elapsed_us), wall: UnixTime::from_micros(wall) }
    }

    pub(crate) fn manager(&self) -> &Manager {
        self.driver.manager()
    }

    pub(crate) fn add(&mut self, tasks: impl IntoIterator<Item = Task>) {
        assert_eq!(self.try_add(tasks), Reply::Done);
    }

    pub(crate) fn try_add(&mut self, tasks: impl IntoIterator<Item = Task>) -> Reply {
        let additions = tasks.into_iter().map(|task| Addition { task }).collect();
        self.ask(Telecommand::Add(additions))
    }

    /// Commands the manager, and lets it decide.
    pub(crate) fn ask(&mut self, telecommand: Telecommand) -> Reply {
        self.asked += 1;
        let id = TelecommandId(self.asked);
        self.tell(Event::Telecommand { id, telecommand });
        self.log.replies.remove(&id).expect("every telecommand is answered")
    }

    /// Something happens now.
    pub(crate) fn tell(&mut self, event: Event) {
        self.driver.tell(event);
        self.settle();
    }

    /// The file that takes its time was read now.
    pub(crate) fn read_slowly(&mut self, file: LoadedFile) {
        self.driver.loaded(self.log.reads_slowly.expect("nobody reads it"), file);
        self.settle();
    }

    /// Something will be told with whatever happens next.
    pub(crate) fn tell_later(&mut self, event: Event) {
        self.driver.tell(event);
    }

    pub(crate) fn settle(&mut self) {
        for _ in 0..10_000 {
            let now = self.now();
            let mut ports = Ports {
                bodies: &mut self.bodies,
                tickets: &mut *self.tickets,
                journal: &mut self.journal,
                outside: &mut People(&mut self.log),
            };
            let went_on = self.driver.turn(now, &mut ports).unwrap();
            if !went_on {
                return;
            }
        }
        panic!("the manager never comes to rest: {:#?}", self.log.lines);
    }

    /// Lets everything happen until this second.
    pub(crate) fn until(&mut self, seconds: f64) {
        let end = us(seconds);
        self.settle();
        while let Some(due) = self.next_due_us().filter(|due| *due <= end) {
            assert!(due > self.elapsed_us, "due now, and nothing happens");
            self.elapsed_us = due;
            self.settle();
        }
        self.elapsed_us = self.elapsed_us.max(end);
    }

    fn next_due_us(&self) -> Option<u64> {
        let due = self.driver.next_due(&self.bodies, &*self.tickets);
        let began = BEGAN * 1_000_000 + self.ahead_us;
        let wall = due.wall.map(|at| u64::try_from(at.as_micros() - began).unwrap_or(0));
        due.elapsed.map(Instant::as_micros).into_iter().chain(wall).min()
    }

    /// The time of day is set.
    pub(crate) fn jump(&mut self, seconds: i64) {
        self.ahead_us += seconds * 1_000_000;
        self.settle();
    }

    /// The lines that contain one of these words, all of them without any.
    pub(crate) fn lines(&self, words: &[&str]) -> Vec<&str> {
        let lines = self.log.lines.iter().map(String::as_str);
        lines.filter(|line| words.iter().any(|word| line.contains(word))).collect()
    }

    /// What was said since the last call.
    pub(crate) fn news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.log.lines)
    }
}

fn bodies_ending(exits: Vec<(u32, Exit)>) -> VirtualBodies {
    VirtualBodies::new(move |attempt, task| {
        let id = attempt.occurrence.task.get();
        let exit = exits.iter().find(|(task, _)| *task == id).map(|(_, exit)| exit.clone());
        Conduct { takes: expected(task), exit: exit.unwrap_or(Exit::Code(0)) }
    })
}

pub(crate) fn us(seconds: f64) -> u64 {
    let span = std::time::Duration::from_secs_f64(seconds);
    u64::try_from(span.as_micros()).unwrap()
}

pub(crate) fn id(number: u32) -> TaskId {
    TaskId::new(number).unwrap()
}

pub(crate) fn seconds(seconds: f64) -> Duration {
    Duration::from_micros(us(seconds))
}

/// A process that takes so many seconds.
pub(crate) fn task(number: u32, takes: f64) -> Task {
    let body = Body::Process { program: "true".into(), arguments: vec![] };
    let mut task = Task::new(id(number), body);
    task.duration = seconds(takes);
    task
}

/// What tests want of a task, in the order in which they say it.
pub(crate) trait With: Sized {
    fn with(self, change: impl FnOnce(&mut Task)) -> Self;

    fn priority(self, level: u8) -> Self {
        self.with(|task| task.priority = TaskPriority::new(level).unwrap())
    }

    fn categories(self, mask: u128) -> Self {
        self.with(|task| task.categories = Categories::from_mask(mask))
    }

    /// Starts so many seconds after it was loaded.
    fn at(self, after: f64) -> Self {
        self.with(|task| task.windows[0].opens = When::AfterLoad(seconds(after)))
    }

    /// Starts so many seconds after it was loaded at the latest.
    fn closes(self, after: f64) -> Self {
        self.with(|task| task.windows[0].closes = When::AfterLoad(seconds(after)))
    }

    fn every(self, interval: f64) -> Self {
        self.with(|task| task.interval = Some(seconds(interval)))
    }
}

impl With for Task {
    fn with(mut self, change: impl FnOnce(&mut Task)) -> Self {
        change(&mut self);
        self
    }
}

/// A time of day, in seconds from the beginning of the test.
pub(crate) fn wall(after: i64) -> When {
    When::At(UnixTime::from_secs(BEGAN + after))
}
