//! What a decision costs: counted, not timed.

use std::collections::BTreeSet;

use faregate_scheduler::Mission;
use faregate_scheduler::manager::{
    Action, Addition, Attempt, Event, Exit, Manager, Occurrence, Telecommand, TelecommandId,
};
use faregate_scheduler::task::Task;
use faregate_scheduler::time::{Instant, Now, UnixTime};

use crate::world::{With, id, task};

/// A manager whose requests are granted at once.
struct Busy {
    manager: Manager,
    running: BTreeSet<Attempt>,
    elapsed_us: u64,
    telecommands: u64,
    actions: Vec<Action>,
    /// What the last step looked at.
    looked_at: u64,
}

impl Busy {
    /// So many tasks. Eight of them have a category each for ever. Every tenth
    /// waits for the first of these, and every other tenth runs one after the
    /// other; the rest become due in groups of a hundredth, one group each
    /// second from the hundredth on, and wait for the other seven.
    fn new(tasks: u32) -> Self {
        let mut busy = Self {
            manager: Manager::new(Mission::default()),
            running: BTreeSet::new(),
            elapsed_us: 0,
            telecommands: 0,
            actions: Vec::new(),
            looked_at: 0,
        };
        let holders = (0..8).map(|n| task(u32::MAX - n, 1e6).categories(1 << n).priority(200));
        let group = (tasks / 100).max(1);
        let rest = (1..tasks).map(|n| {
            let priority = u8::try_from(n % 97).unwrap();
            let task = task(n, 10.0).priority(priority);
            match n % 10 {
                0 => task.categories(1),
                1 => task.categories(RUNNING),
                _ => task.categories(2 << (n % 7)).at(100.0 + f64::from(n / group)),
            }
        });
        busy.add(holders.chain(rest));
        busy
    }

    fn add(&mut self, tasks: impl IntoIterator<Item = Task>) {
        self.command(Telecommand::Add(tasks.into_iter().map(|task| Addition { task }).collect()));
    }

    fn command(&mut self, telecommand: Telecommand) {
        self.telecommands += 1;
        let id = TelecommandId(self.telecommands);
        self.step(vec![Event::Telecommand { id, telecommand }]);
    }

    fn step(&mut self, mut events: Vec<Event>) {
        let before = self.manager.looked_at();
        loop {
            let elapsed = Instant::from_micros(self.elapsed_us);
            let wall = UnixTime::from_micros(1_700_000_000_000_000);
            let now = Now { elapsed, wall };
            self.manager.step(now, std::mem::take(&mut events), &mut self.actions);
            for action in self.actions.drain(..) {
                match action {
                    Action::Request { occurrence, victims } => {
                        let taken = |occurrence| Event::Taken { occurrence, by: "another".into() };
                        events.extend(victims.into_iter().map(taken));
                        events.push(Event::Granted { occurrence });
                    }
                    Action::Start { attempt } => drop(self.running.insert(attempt)),
                    Action::Stop { attempt, .. } => events.push(Event::Stopped { attempt }),
                    _ => {}
                }
            }
            if events.is_empty() {
                break;
            }
        }
        self.looked_at = self.manager.looked_at() - before;
    }

    fn end(&mut self, occurrence: Occurrence) {
        let attempt = Attempt { occurrence, number: 1 };
        self.running.remove(&attempt);
        self.step(vec![Event::Exited { attempt, exit: Exit::Code(0) }]);
    }
}

/// Tasks of this category run one after the other.
const RUNNING: u128 = 1 << 64;

/// What happens: becoming due, an end, an addition, a removal, tickets that are
/// taken.
const KINDS: usize = 5;

/// What each event of each kind looked at.
fn costs(tasks: u32) -> [Vec<u64>; KINDS] {
    let mut busy = Busy::new(tasks);
    let mut costs = [const { Vec::new() }; KINDS];
    for round in 0..90_u32 {
        let mut note = |kind: usize, busy: &Busy| costs[kind].push(busy.looked_at);
        busy.elapsed_us = u64::from(100 + round) * 1_000_000;
        busy.step(Vec::new());
        note(0, &busy);
        let short = busy.running.iter().find(|attempt| attempt.occurrence.task < id(u32::MAX - 8));
        if let Some(attempt) = short.copied() {
            busy.end(attempt.occurrence);
            note(1, &busy);
        }
        let new = 1_000_000 + round;
        busy.add([task(new, 10.0).categories(1).priority(50)]);
        note(2, &busy);
        busy.command(Telecommand::Remove(vec![id(new)]));
        note(3, &busy);
        if let Some(attempt) = busy.running.first().copied() {
            let occurrence = attempt.occurrence;
            busy.step(vec![Event::Taken { occurrence, by: "safe mode".into() }]);
            note(4, &busy);
            busy.step(vec![Event::Granted { occurrence }]);
        }
    }
    costs
}

#[test]
fn an_event_looks_at_hardly_more_among_100_000_tasks_than_among_100() {
    let most = |tasks| {
        let costs = costs(tasks);
        costs.into_iter().flatten().max().unwrap()
    };
    let (few, many) = (most(100), most(100_000));
    assert!(many <= 3 * few, "{few} of 100, {many} of 100 000");
}
