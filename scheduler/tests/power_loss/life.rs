//! One life of a manager, on a virtual clock, with a journal that may fail.

use std::io;
use std::sync::Arc;

use faregate_scheduler::executive::{
    Bodies, Driver, LoadedFile, Outside, Ports, StartBody, VirtualBodies, VirtualTickets,
};
use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::{Compaction, Damage, Journal, Options};
use faregate_scheduler::manager::{
    Addition, Attempt, Event, Note, Reply, Stop, StopWhy, Telecommand, TelecommandId,
};
use faregate_scheduler::task::TaskId;
use faregate_scheduler::time::{Due, Instant, Now, UnixTime};
use faregate_scheduler::{Mission, Task};

use crate::truth::Truth;

/// How a life ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// There is nothing left to do.
    Over,
    /// The journal failed: nothing more may be done.
    Dead,
}

/// A manager between its start and its death.
pub(crate) struct Life<'a> {
    driver: Driver,
    journal: Journal,
    bodies: VirtualBodies,
    tickets: VirtualTickets,
    truth: &'a mut Truth,
    began: UnixTime,
    asked: Vec<(TelecommandId, Vec<TaskId>)>,
}

impl<'a> Life<'a> {
    pub(crate) fn begin(
        disk: &Disk,
        truth: &'a mut Truth,
        random: &mut fastrand::Rng,
    ) -> io::Result<Self> {
        let options = Options {
            compact_above: 1_500,
            compaction: Compaction::Inline,
            damage: Damage::Refuse,
        };
        let (mut journal, restored, _) =
            Journal::open_on(Arc::new(disk.clone()), options).map_err(io::Error::other)?;
        truth.restored(&restored);
        let there: Vec<_> = restored.tasks.iter().map(|task| task.task.id).collect();
        let (mut bodies, mut tickets) = (VirtualBodies::as_expected(), VirtualTickets::default());
        let began = truth.wall;
        let now = Now { elapsed: Instant::START, wall: began };
        let mut witness = Witness { bodies: &mut bodies, truth };
        let mut outside = Answers::default();
        let mut ports = Ports {
            bodies: &mut witness,
            tickets: &mut tickets,
            journal: &mut journal,
            outside: &mut outside,
        };
        let driver = Driver::restore(Mission::default(), restored, now, &mut ports)?;
        let asked = Vec::new();
        let mut life = Self { driver, journal, bodies, tickets, truth, began, asked };
        life.add_who_is_missing(&there, random);
        Ok(life)
    }

    /// Whoever was not answered asks again, as an operator does.
    fn add_who_is_missing(&mut self, there: &[TaskId], random: &mut fastrand::Rng) {
        let missing = self.truth.tasks.values().filter(|task| !there.contains(&task.id));
        let missing: Vec<Task> = missing.cloned().collect();
        // Who is there was accepted, though the answer was lost.
        self.truth.accepted.extend(there);
        for load in missing.chunks(random.usize(1..5)) {
            let id = TelecommandId(self.asked.len() as u64);
            self.asked.push((id, load.iter().map(|task| task.id).collect()));
            let additions = load.iter().cloned().map(|task| Addition { task }).collect();
            self.driver.tell(Event::Telecommand { id, telecommand: Telecommand::Add(additions) });
        }
    }

    /// Lives until there is nothing to do, or the journal fails.
    pub(crate) fn go_on(mut self) -> io::Result<End> {
        loop {
            let answers = match self.settle() {
                Ok(answers) => answers,
                Err(_) => return Ok(End::Dead),
            };
            self.hear(&answers);
            let Due { elapsed, wall } = self.driver.next_due(&self.bodies, &self.tickets);
            let due = elapsed.map(|at| self.began.after(at.since(Instant::START)));
            let Some(due) = due.into_iter().chain(wall).min() else { return Ok(End::Over) };
            self.truth.wall = self.truth.wall.max(due);
        }
    }

    fn now(&self) -> Now {
        let elapsed = Instant::START.after(self.truth.wall.since(self.began));
        Now { elapsed, wall: self.truth.wall }
    }

    fn settle(&mut self) -> io::Result<Answers> {
        let now = self.now();
        let mut answers = Answers::default();
        loop {
            let mut witness = Witness { bodies: &mut self.bodies, truth: self.truth };
            let mut ports = Ports {
                bodies: &mut witness,
                tickets: &mut self.tickets,
                journal: &mut self.journal,
                outside: &mut answers,
            };
            if !self.driver.turn(now, &mut ports)? {
                return Ok(answers);
            }
        }
    }

    fn hear(&mut self, Answers(answers): &Answers) {
        for (id, reply) in answers {
            assert_eq!(*reply, Reply::Done, "a valid load was refused");
            let asked = self.asked.iter().find(|(asked, _)| asked == id).expect("it was asked");
            self.truth.accepted.extend(&asked.1);
        }
    }
}

/// Bodies whose starts and ends are witnessed.
struct Witness<'a> {
    bodies: &'a mut VirtualBodies,
    truth: &'a mut Truth,
}

impl Bodies for Witness<'_> {
    fn start(&mut self, body: StartBody<'_>) {
        self.truth.begins(body.attempt);
        self.bodies.start(body);
    }

    fn stop(&mut self, attempt: Attempt, how: Stop, why: &StopWhy, now: Now) {
        self.bodies.stop(attempt, how, why, now);
    }

    fn resume(&mut self, attempt: Attempt, now: Now) {
        self.bodies.resume(attempt, now);
    }

    fn poll(&mut self, now: Now, events: &mut Vec<Event>) {
        let before = events.len();
        self.bodies.poll(now, events);
        for event in &events[before..] {
            if let Event::Exited { attempt, exit } = event {
                self.truth.ends(*attempt, exit.clone());
            }
        }
    }

    fn next_due(&self) -> Option<Instant> {
        self.bodies.next_due()
    }
}

#[derive(Debug, Default)]
struct Answers(Vec<(TelecommandId, Reply)>);

impl Outside for Answers {
    fn note(&mut self, _: Now, _: &Note) {}

    fn answer(&mut self, _: Now, id: TelecommandId, reply: Reply) {
        self.0.push((id, reply));
    }

    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        Some(Err("there are no files".into()))
    }
}
