//! What every executive shares: what happened at one instant goes to the
//! manager, and what the manager says is carried out, in its order.
//!
//! An executive is a loop around [`Driver::turn`]. It owns the ports and the
//! clock; whether that clock is real or virtual is its own affair. So two
//! executives of one schedule can differ only in their ports.

use std::io;

use crate::executive::{Bodies, StartBody, TicketPort};
use crate::manager::{
    Action, Addition, Attempt, Event, Exit, Manager, Note, Record, Reply, Restored, Telecommand,
    TelecommandId,
};
use crate::mission::{Mission, ModeSpec};
use crate::task::Task;
use crate::time::{Due, Instant, Now};

/// Where records go.
///
/// # Errors
/// After an error nothing more is carried out: what is not in the journal must
/// not happen.
pub trait JournalSink {
    /// Writes a record, perhaps together with those that follow.
    fn append(&mut self, record: &Record) -> io::Result<()>;

    /// What was written survives the end of this program when this returns.
    /// Called before anything is carried out that could be noticed.
    fn commit(&mut self) -> io::Result<()> {
        // For a sink whose `append` sees to it at once.
        Ok(())
    }

    /// What was written survives the loss of power, too, when this returns.
    fn sync(&mut self) -> io::Result<()>;
}

/// What a schedule file holds, or why it cannot be loaded, for people.
pub type LoadedFile = Result<Vec<Task>, String>;

/// Who is told, who is answered, and where files come from.
pub trait Outside {
    /// Something changed.
    fn note(&mut self, now: Now, note: &Note);

    /// Answers a telecommand.
    fn answer(&mut self, now: Now, id: TelecommandId, reply: Reply);

    /// Reads a schedule file. `None`: later, by [`Driver::loaded`].
    fn load(&mut self, attempt: Attempt, path: &str) -> Option<LoadedFile>;
}

/// Everything that actions are carried out on.
#[expect(missing_debug_implementations, reason = "four borrowed ports: there is nothing to show")]
pub struct Ports<'a> {
    /// Runs the bodies.
    pub bodies: &'a mut dyn Bodies,
    /// Asks for tickets.
    pub tickets: &'a mut dyn TicketPort,
    /// Keeps records.
    pub journal: &'a mut dyn JournalSink,
    /// Everybody else.
    pub outside: &'a mut dyn Outside,
}

/// The first of the telecommands that a driver gives itself, for files that
/// were loaded. Those from outside count from 0 and never come here.
const FIRST_OWN: u64 = 1 << 63;

/// The manager, and what was told it and not yet decided.
#[derive(Debug)]
pub struct Driver {
    manager: Manager,
    modes: Vec<ModeSpec>,
    told: Vec<Event>,
    /// Whose files are being read.
    reading: Vec<Attempt>,
    loads: Vec<(TelecommandId, Attempt)>,
    asked: Vec<(TelecommandId, Option<Reply>)>,
    next_own: u64,
    actions: Vec<Action>,
}

impl Driver {
    /// Drives a manager without tasks.
    #[must_use]
    pub fn new(mission: Mission) -> Self {
        let modes = mission.modes.clone();
        Self::of(Manager::new(mission), modes)
    }

    /// Drives a manager that goes on where a journal ends, and carries out what
    /// that needs before anything else.
    ///
    /// # Errors
    /// The journal's.
    pub fn restore(
        mission: Mission,
        restored: Restored,
        now: Now,
        ports: &mut Ports<'_>,
    ) -> io::Result<Self> {
        let modes = mission.modes.clone();
        let mut actions = Vec::new();
        let manager = Manager::restore(mission, restored, now, &mut actions);
        let mut driver = Self::of(manager, modes);
        driver.actions = actions;
        driver.carry_out(now, ports)?;
        Ok(driver)
    }

    fn of(manager: Manager, modes: Vec<ModeSpec>) -> Self {
        Self {
            manager,
            modes,
            told: Vec::new(),
            reading: Vec::new(),
            loads: Vec::new(),
            asked: Vec::new(),
            next_own: FIRST_OWN,
            actions: Vec::new(),
        }
    }

    /// The manager, for questions.
    #[must_use]
    pub fn manager(&self) -> &Manager {
        &self.manager
    }

    /// Something happened that no port tells of: a telecommand, a reading. The
    /// next turn decides.
    pub fn tell(&mut self, event: Event) {
        self.told.push(event);
    }

    /// A file was read for the body of this attempt. The next turn adds its
    /// tasks, all or none; none of them if the attempt was stopped meanwhile.
    pub fn loaded(&mut self, attempt: Attempt, file: LoadedFile) {
        if self.was_reading(attempt) {
            self.take(attempt, file);
        }
    }

    fn was_reading(&mut self, attempt: Attempt) -> bool {
        self.reading.extract_if(.., |reading| *reading == attempt).next().is_some()
    }

    fn take(&mut self, attempt: Attempt, file: LoadedFile) {
        let tasks = match file {
            Ok(tasks) => tasks,
            Err(why) => {
                return self.tell(Event::Exited { attempt, exit: Exit::Failed(why) });
            }
        };
        let id = self.own();
        self.loads.push((id, attempt));
        let additions = tasks.into_iter().map(|task| Addition { task }).collect();
        self.tell(Event::Telecommand { id, telecommand: Telecommand::Add(additions) });
    }

    /// The program itself asks something of the manager. The next turn answers,
    /// by [`Driver::answered`].
    pub fn ask(&mut self, telecommand: Telecommand) -> TelecommandId {
        let id = self.own();
        self.asked.push((id, None));
        self.tell(Event::Telecommand { id, telecommand });
        id
    }

    /// What the manager answered, once.
    pub fn answered(&mut self, id: TelecommandId) -> Option<Reply> {
        let index = self.asked.iter().position(|(asked, reply)| *asked == id && reply.is_some())?;
        self.asked.swap_remove(index).1
    }

    fn own(&mut self) -> TelecommandId {
        let id = TelecommandId(self.next_own);
        self.next_own = self.next_own.wrapping_add(1).max(FIRST_OWN);
        id
    }

    /// When to take the next turn, if nothing happens before.
    #[must_use]
    pub fn next_due(&self, bodies: &dyn Bodies, tickets: &dyn TicketPort) -> Due {
        let Due { elapsed, wall } = self.manager.next_due();
        let told = (!self.told.is_empty()).then_some(Instant::START);
        let ports = [bodies.next_due(), tickets.next_due(), told];
        Due { elapsed: ports.into_iter().flatten().chain(elapsed).min(), wall }
    }

    /// Takes everything that has happened by now to the manager, and carries
    /// out what it says. Answers whether there was anything: if so, another
    /// turn at the same instant may find what came of it.
    ///
    /// # Errors
    /// The journal's. The rest of the decision is not carried out then: the
    /// program must end, and another one go on from the journal.
    pub fn turn(&mut self, now: Now, ports: &mut Ports<'_>) -> io::Result<bool> {
        let events = self.collect(now, ports);
        let is_due = is_due(self.manager.next_due(), now);
        if events.is_empty() && !is_due && !self.manager.has_news_of_the_clock(now) {
            return Ok(false);
        }
        self.manager.step(now, events, &mut self.actions);
        self.carry_out(now, ports)?;
        Ok(true)
    }

    /// Bodies before tickets: what a stopped body drew is credited before its
    /// taker is looked for.
    fn collect(&mut self, now: Now, ports: &mut Ports<'_>) -> Vec<Event> {
        let mut events = Vec::new();
        ports.bodies.poll(now, &mut events);
        events.append(&mut self.told);
        for event in &events {
            if let Event::Exited { attempt, .. } | Event::Stopped { attempt } = event {
                ports.tickets.stopped(attempt.occurrence, now);
            }
        }
        ports.tickets.poll(now, &mut events);
        events
    }

    fn carry_out(&mut self, now: Now, ports: &mut Ports<'_>) -> io::Result<()> {
        let mut actions = core::mem::take(&mut self.actions);
        for action in actions.drain(..) {
            self.act(action, now, ports)?;
        }
        self.actions = actions;
        ports.journal.commit()
    }

    fn act(&mut self, action: Action, now: Now, ports: &mut Ports<'_>) -> io::Result<()> {
        if !matches!(action, Action::Journal(_) | Action::Sync | Action::Note(_)) {
            ports.journal.commit()?;
        }
        match action {
            Action::Journal(record) => ports.journal.append(&record)?,
            Action::Sync => ports.journal.sync()?,
            Action::Request { occurrence, victims } => {
                if let Some(needs) = self.manager.needs(occurrence) {
                    ports.tickets.request(occurrence, &needs, &victims, now);
                }
            }
            Action::Relinquish { occurrence } => ports.tickets.relinquish(occurrence, now),
            Action::Start { attempt } => {
                if let Some(task) = self.manager.task(attempt.occurrence.task) {
                    ports.tickets.started(attempt, now);
                    ports.bodies.start(StartBody { attempt, task, now });
                }
            }
            // Who reads goes on, and nobody hears of it any more.
            Action::Stop { attempt, .. } if self.was_reading(attempt) => {
                let exit = Exit::Failed("stopped before its file was read".to_owned());
                self.tell(Event::Exited { attempt, exit });
            }
            Action::Stop { attempt, how, why } => ports.bodies.stop(attempt, how, &why, now),
            Action::Continue { attempt } => {
                ports.tickets.started(attempt, now);
                ports.bodies.resume(attempt, now);
            }
            Action::Load { attempt, path } => match ports.outside.load(attempt, &path) {
                Some(file) => self.take(attempt, file),
                None => self.reading.push(attempt),
            },
            Action::Reserve { mode } => {
                let gates = self.modes.iter().find(|spec| spec.name == mode);
                let gates = gates.map_or(&[][..], |spec| &spec.reserves);
                ports.tickets.reserve(&mode, gates, now);
            }
            Action::Unreserve { mode } => ports.tickets.unreserve(&mode, now),
            Action::Answer { id, reply } => self.answer(now, id, reply, ports),
            Action::Note(note) => ports.outside.note(now, &note),
        }
        Ok(())
    }

    /// The answer to a telecommand of our own ends the body that loaded a file.
    fn answer(&mut self, now: Now, id: TelecommandId, reply: Reply, ports: &mut Ports<'_>) {
        if let Some((_, answer)) = self.asked.iter_mut().find(|(asked, _)| *asked == id) {
            *answer = Some(reply);
            return;
        }
        let Some(index) = self.loads.iter().position(|(own, _)| *own == id) else {
            return ports.outside.answer(now, id, reply);
        };
        let (_, attempt) = self.loads.swap_remove(index);
        let exit = match reply {
            Reply::Done => Exit::Code(0),
            Reply::Refused(why) => Exit::Failed(why),
        };
        self.tell(Event::Exited { attempt, exit });
    }
}

fn is_due(due: Due, now: Now) -> bool {
    due.elapsed.is_some_and(|at| at <= now.elapsed) || due.wall.is_some_and(|at| at <= now.wall)
}
