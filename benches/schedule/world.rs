//! The manager in a stream of events, with tickets that are granted as soon as
//! somebody asks the stream for them.

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::manager::{
    Action, Addition, Attempt, Event, Exit, Manager, Occurrence, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::task::{Body, Task, TaskId, TaskPriority, When, Window};
use faregate_scheduler::time::{Duration, Instant, Now, UnixTime};

use crate::stream::{Happening, Kind, Row, Schedule};

/// The category that everybody wants.
const WANTED: u128 = 1;

pub(crate) fn id(number: u32) -> TaskId {
    TaskId::new(number).expect("tasks count from 1")
}

/// A task that is due so many seconds after it is accepted.
fn task(number: u32, due: u64, priority: u8) -> Task {
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

/// The manager, and what an executive would know.
#[derive(Debug)]
pub(crate) struct World {
    pub(crate) manager: Manager,
    seconds: u64,
    runs: Option<Attempt>,
    asks: Option<Occurrence>,
    actions: Vec<Action>,
}

impl World {
    fn now(&self) -> Now {
        let elapsed = Duration::from_secs(self.seconds);
        Now { elapsed: Instant::START.after(elapsed), wall: UnixTime::from_secs(0).after(elapsed) }
    }

    fn add(&self, rows: &[Row]) -> Event {
        let task = |row: &Row| task(row.id, row.due.saturating_sub(self.seconds), row.priority);
        command(Telecommand::Add(rows.iter().map(|row| Addition { task: task(row) }).collect()))
    }

    fn running(&self) -> Attempt {
        self.runs.expect("a task runs between the events")
    }

    fn granted(&mut self) -> Event {
        let occurrence = self.asks.take().expect("somebody has asked");
        Event::Granted { occurrence }
    }

    /// What the actions say: who asks, who runs. The tasks of this bench are
    /// such that no telecommand is refused.
    fn look(&mut self) {
        for action in &self.actions {
            match action {
                Action::Request { occurrence, .. } => self.asks = Some(*occurrence),
                Action::Start { attempt } | Action::Continue { attempt } => {
                    self.runs = Some(*attempt);
                }
                Action::Answer { reply: Reply::Refused(why), .. } => panic!("{why}"),
                _ => {}
            }
        }
    }

    /// Lets who asks have its tickets.
    fn grant(&mut self) {
        let granted = self.granted();
        self.happen(vec![granted]);
        self.look();
    }
}

impl Schedule for World {
    type Event = Vec<Event>;

    fn of(rows: &[Row]) -> Self {
        let manager = Manager::new(Mission::default());
        let (runs, asks, actions) = (None, None, Vec::new());
        let mut world = Self { manager, seconds: 0, runs, asks, actions };
        world.happen(vec![world.add(rows)]);
        world.look();
        world.grant();
        world
    }

    fn make(&mut self, now: u64, happening: Happening) -> Vec<Event> {
        self.seconds = now;
        match happening {
            Happening::Due => Vec::new(),
            Happening::Revoke => {
                let occurrence = self.running().occurrence;
                vec![Event::Taken { occurrence, by: String::from("a fault response") }]
            }
            Happening::Add(row) => vec![self.add(&[row])],
            Happening::Remove(number) => vec![command(Telecommand::Remove(vec![id(number)]))],
            Happening::End => vec![Event::Exited { attempt: self.running(), exit: Exit::Code(0) }],
            Happening::Start => vec![self.granted()],
        }
    }

    fn happen(&mut self, events: Vec<Event>) {
        let now = self.now();
        self.actions.clear();
        self.manager.step(now, events, &mut self.actions);
    }

    fn follow(&mut self, kind: Kind) {
        self.look();
        if kind == Kind::Revoke {
            let attempt = self.running();
            self.happen(vec![Event::Stopped { attempt }]);
            self.happen(vec![Event::Granted { occurrence: attempt.occurrence }]);
            self.runs = None;
            self.look();
            assert_eq!(self.runs, Some(attempt), "with its tickets it goes on");
        }
    }

    fn runs(&self) -> u32 {
        self.running().occurrence.task.get()
    }

    fn replace(&mut self, out: &[u32], rows: &[Row]) {
        let out = Telecommand::Remove(out.iter().map(|&number| id(number)).collect());
        let over = Event::Exited { attempt: self.running(), exit: Exit::Code(0) };
        self.happen(vec![over, command(out), self.add(rows)]);
        self.look();
        self.grant();
    }
}

fn command(telecommand: Telecommand) -> Event {
    Event::Telecommand { id: TelecommandId(0), telecommand }
}
