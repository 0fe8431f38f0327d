//! What a decision costs: counted, not timed.

use std::collections::BTreeSet;

use faregate_scheduler::Mission;
use faregate_scheduler::manager::{
    Action, Addition, Attempt, Event, Exit, Manager, Occurrence, Telecommand, TelecommandId,
};
use faregate_scheduler::task::Task;
use faregate_scheduler::time::{Instant, Now, UnixTime};

use crate::world::{With, id, seconds, task};

/// A manager whose requests are granted at once.
struct Busy {
    manager: Manager,
    running: BTreeSet<Attempt>,
    elapsed_us: u64,
    telecommands: u64,
    actions: Vec<Action>,
    /// What the last step looked at, and how long all of its decisions took.
    looked_at: u64,
    took: std::time::Duration,
}

impl Busy {
    /// So many tasks: every tenth waits for one category, which the first one
    /// has; the others become due in groups of a hundredth, one group each
    /// second from the hundredth on, in 16 categories.
    fn new(tasks: u32) -> Self {
        let mut busy = Self {
            manager: Manager::new(Mission::default()),
            running: BTreeSet::new(),
            elapsed_us: 0,
            telecommands: 0,
            actions: Vec::new(),
            looked_at: 0,
            took: std::time::Duration::ZERO,
        };
        let holder = task(u32::MAX, 1e6).categories(1).priority(200);
        let group = (tasks / 100).max(1);
        let all = (1..tasks).map(|n| {
            if n % 10 == 0 {
                return task(n, 10.0).categories(1).priority((n % 100) as u8);
            }
            let at = 100.0 + f64::from(n / group);
            let categories = 2 << (n % 16);
            task(n, 10.0).categories(categories).priority((n % 97) as u8).at(at)
        });
        busy.add(std::iter::once(holder).chain(all));
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
        self.took = std::time::Duration::ZERO;
        loop {
            let elapsed = Instant::from_micros(self.elapsed_us);
            let wall = UnixTime::from_micros(1_700_000_000_000_000);
            let now = Now { elapsed, wall };
            let began = std::time::Instant::now();
            self.manager.step(now, std::mem::take(&mut events), &mut self.actions);
            self.took += began.elapsed();
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

/// The most that an event of each kind looked at: becoming due, an end, an
/// addition, a removal, tickets that were taken.
fn costs(tasks: u32) -> [(u64, std::time::Duration); 5] {
    let mut busy = Busy::new(tasks);
    let mut costs = [const { Vec::new() }; 5];
    for round in 0..90_u32 {
        busy.elapsed_us = u64::from(100 + round) * 1_000_000;
        busy.step(Vec::new());
        costs[0].push((busy.looked_at, busy.took));
        let holder = id(u32::MAX);
        let ends = busy.running.iter().find(|attempt| attempt.occurrence.task != holder).copied();
        if let Some(attempt) = ends {
            busy.end(attempt.occurrence);
            costs[1].push((busy.looked_at, busy.took));
        }
        let new = 1_000_000 + round;
        busy.add([task(new, 10.0).categories(1).priority(50)]);
        costs[2].push((busy.looked_at, busy.took));
        busy.command(Telecommand::Remove(vec![id(new)]));
        costs[3].push((busy.looked_at, busy.took));
        if let Some(attempt) = busy.running.last().copied() {
            let occurrence = attempt.occurrence;
            busy.step(vec![Event::Taken { occurrence, by: "safe mode".into() }]);
            costs[4].push((busy.looked_at, busy.took));
            busy.step(vec![Event::Granted { occurrence }]);
        }
    }
    costs.map(|mut costs| {
        costs.sort_unstable();
        let most = costs.last().map_or(0, |cost| cost.0);
        let mut times: Vec<_> = costs.iter().map(|cost| cost.1).collect();
        times.sort_unstable();
        (most, times[times.len() * 99 / 100])
    })
}

#[test]
fn an_event_looks_at_hardly_more_among_100_000_tasks_than_among_100() {
    let few = costs(100);
    let many = costs(100_000);
    println!("{few:?}\n{many:?}");
    let most = |costs: &[(u64, _); 5]| costs.iter().map(|cost| cost.0).max().unwrap();
    assert!(most(&many) <= 3 * most(&few), "{few:?} {many:?}");
}
