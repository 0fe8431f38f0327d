//! What commands the manager, and who is told what becomes of it.

use std::collections::HashMap;
use std::sync::Arc;

use faregate_client::wire::control::{Answer, StatusQuery};
use faregate_client::{RefusalKind, Refused};

use crate::bodies::Gauge;
use crate::control::files::Files;
use crate::control::{ReadSchedule, StatusSource, status};
use crate::executive::{Correspondent, LoadedFile, Outside, Waker, Watched};
use crate::manager::{Attempt, Event, Manager, Note, Reply, Telecommand, TelecommandId};
use crate::port::CommandServer;
use crate::time::Now;

/// One way in from outside. All calls are made by the manager's thread and
/// return at once; when something was asked, the link rings the manager's bell.
pub trait Link: Send {
    /// What was asked since.
    fn poll(&mut self, now: Now, asked: &mut Vec<Asked>);

    /// Answers what was asked. Each ask is answered once.
    fn answer(&mut self, now: Now, to: AskId, answer: Answer);

    /// Tells a change.
    fn note(&mut self, now: Now, note: &Note);
}

/// Tells apart what was asked over one link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AskId(pub u64);

/// What was asked over a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asked {
    /// To answer by.
    pub id: AskId,
    /// What.
    pub what: What,
}

/// What can be asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum What {
    /// The manager is to do something.
    Telecommand(Telecommand),
    /// Where the tasks stand.
    Status(StatusQuery),
}

/// All links of a manager, and what else comes from outside: schedule files,
/// the heartbeats of tasks, and what was measured.
#[expect(missing_debug_implementations, reason = "links and a reader of files: nothing to show")]
pub struct Links {
    links: Vec<Box<dyn Link>>,
    files: Files,
    ports: Option<CommandServer>,
    gauge: Option<Gauge>,
    next: u64,
    open: HashMap<TelecommandId, (usize, AskId)>,
}

impl Links {
    /// No links yet. Schedule files that a task loads are read by `schedules`,
    /// on a thread of their own, which rings the manager's bell.
    #[must_use]
    pub fn new(schedules: Arc<dyn ReadSchedule>, manager: Waker) -> Self {
        let files = Files::new(schedules, manager);
        Self { links: Vec::new(), files, ports: None, gauge: None, next: 0, open: HashMap::new() }
    }

    /// Adds a link.
    pub fn add(&mut self, link: impl Link + 'static) {
        self.links.push(Box::new(link));
    }

    /// Hears the heartbeats that come to these ports.
    pub fn hear(&mut self, ports: CommandServer) {
        self.ports = Some(ports);
    }

    /// Tells what this has measured.
    pub(crate) fn read(&mut self, gauge: Gauge) {
        self.gauge = Some(gauge);
    }

    /// What was asked since, as events. Questions are answered here.
    pub fn collect(&mut self, now: Now, source: &impl StatusSource, events: &mut Vec<Event>) {
        let mut asked = Vec::new();
        for (index, link) in self.links.iter_mut().enumerate() {
            link.poll(now, &mut asked);
            for Asked { id: ask, what } in asked.drain(..) {
                match what {
                    What::Status(query) => {
                        link.answer(now, ask, status::answer(query, source, now));
                    }
                    What::Telecommand(telecommand) => match unknown(&telecommand, source) {
                        Some(why) => link.answer(now, ask, Answer::Refused(why)),
                        None => {
                            let id = TelecommandId(self.next);
                            self.next += 1;
                            self.open.insert(id, (index, ask));
                            events.push(Event::Telecommand { id, telecommand });
                        }
                    },
                }
            }
        }
        if let Some(ports) = &self.ports {
            ports.poll(events);
        }
        let readings = self.gauge.as_ref().map(Gauge::take).unwrap_or_default();
        events.extend(readings.into_iter().map(Event::Reading));
    }
}

/// Why a telecommand is about nothing that is there, if it is. The manager would
/// refuse it, too, but only in words: programs know this refusal by its kind.
fn unknown(telecommand: &Telecommand, source: &impl StatusSource) -> Option<Refused> {
    let tasks = match telecommand {
        Telecommand::Remove(tasks) => tasks.as_slice(),
        Telecommand::SetPriority(task, _)
        | Telecommand::SetWindows(task, _)
        | Telecommand::Hold(task)
        | Telecommand::Resume(task) => core::slice::from_ref(task),
        Telecommand::EnterMode(mode) | Telecommand::LeaveMode(mode) => {
            let why = || format!("the mission has no mode {mode}");
            return (!source.has_mode(mode)).then(|| Refused::new(RefusalKind::Invalid, why()));
        }
        Telecommand::Add(_) | Telecommand::Clear { .. } | Telecommand::ShutDown => &[],
    };
    let missing = tasks.iter().find(|task| source.task(**task).is_none())?;
    Some(Refused::new(RefusalKind::UnknownTask, format!("{missing} is not in the schedule")))
}

impl Outside for Links {
    fn note(&mut self, now: Now, note: &Note) {
        self.links.iter_mut().for_each(|link| link.note(now, note));
    }

    fn answer(&mut self, now: Now, id: TelecommandId, reply: Reply) {
        let Some((link, ask)) = self.open.remove(&id) else { return };
        let answer = match reply {
            Reply::Done => Answer::Done,
            Reply::Refused(why) => Answer::Refused(Refused::new(RefusalKind::NotDone, why)),
        };
        if let Some(link) = self.links.get_mut(link) {
            link.answer(now, ask, answer);
        }
    }

    fn load(&mut self, attempt: Attempt, path: &str) -> Option<LoadedFile> {
        self.files.ask(attempt, path).err().map(Err)
    }
}

impl Watched for Links {}

impl Correspondent for Links {
    fn poll(&mut self, now: Now, manager: &Manager, events: &mut Vec<Event>) {
        self.collect(now, manager, events);
    }

    fn loaded(&mut self) -> Option<(Attempt, LoadedFile)> {
        self.files.answer()
    }
}
