//! Everything together: a mission's schedule, run on this host.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use faregate_scheduler::{Mission, Onboard, format};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let text = std::fs::read("week.csv")?;
//! let schedule = format::read("week.csv", &text).map_err(|_| "see `faregate check week.csv`")?;
//! let mut onboard = Onboard::builder(Mission::default())?
//!     .journal(Path::new("journal"))?       // goes on where it ended
//!     .control(Path::new("faregate.sock"))  // `faregate status`, `faregate add`, ...
//!     .start()?;
//! onboard.load(schedule.tasks)?;
//! onboard.run(|manager, _| manager.is_over())?;
//! onboard.close()?;
//! # Ok(())
//! # }
//! ```

mod error;
mod kept;
mod opening;

use core::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use faregate_client::{Problem, RefusalKind, Refused};

use crate::bodies::{Functions, Gauge, RealBodies, Settings, Surroundings, Swept};
use crate::control::{Links, ReadSchedule, SocketLink};
use crate::executive::{Commands, Correspondent, HostClock, HostExecutive, Unwritten, Waker};
use crate::format::{self, Diagnostic};
use crate::journal::Opened;
use crate::manager::{Addition, Reply, Restored, Telecommand};
use crate::mission::Mission;
use crate::port::CommandServer;
use crate::task::Task;
use crate::tickets::{Driver, Installation, Tickets};

pub use error::NotOnboard;
pub use kept::Kept;

/// A mission's schedule that runs on this host: processes, threads, tickets, a
/// journal, and links.
///
/// Stays on the thread that makes it: the processes die with that thread.
pub type Onboard<O = Links> = HostExecutive<RealBodies, Tickets, Kept, O>;

/// Puts an [`Onboard`] together.
pub struct Builder {
    mission: Mission,
    waker: Waker,
    clock: HostClock,
    installation: Installation,
    settings: Settings,
    functions: Functions,
    kept: Kept,
    restored: Restored,
    opened: Option<Opened>,
    swept: Vec<Swept>,
    control: Option<PathBuf>,
    schedules: Arc<dyn ReadSchedule>,
}

impl Onboard {
    /// Begins to put a mission together.
    ///
    /// # Errors
    /// [`NotOnboard::Host`] and [`NotOnboard::Installation`].
    pub fn builder(mission: Mission) -> Result<Builder, NotOnboard> {
        let waker = Waker::new()?;
        let installation = Installation::new(&mission, &waker)?;
        Ok(Builder {
            schedules: reader(mission.clone()),
            mission,
            waker,
            clock: HostClock::start(),
            installation,
            settings: Settings::default(),
            functions: Functions::new(),
            kept: Kept::Nowhere(Unwritten),
            restored: Restored::default(),
            opened: None,
            swept: Vec::new(),
            control: None,
        })
    }
}

/// Reads schedules that come while others run: for the mission that they are
/// to run on.
fn reader(mission: Mission) -> Arc<dyn ReadSchedule> {
    Arc::new(move |name: &str, text: &str| {
        let against = format::Against::Mission(&mission);
        let options = format::Options { against, whole: false, ..format::Options::default() };
        let read = format::read_with(options, name, text.as_bytes());
        read.map(|loaded| loaded.tasks).map_err(|found| refused(&found))
    })
}

/// What a client is told of the mistakes in its schedule.
#[must_use]
pub fn refused(found: &[Diagnostic]) -> Refused {
    let problems = found.iter().filter(|one| one.is_error()).map(problem).collect();
    Refused::new(RefusalKind::Invalid, "it has mistakes").with_problems(problems)
}

fn problem(wrong: &Diagnostic) -> Problem {
    let number = |number: usize| u64::try_from(number).ok();
    let expected = wrong.expected.iter().map(|expected| format!("; expected {expected}"));
    Problem {
        line: number(wrong.place.line),
        column: number(wrong.place.column),
        field: wrong.field.clone(),
        message: wrong.message.clone() + &expected.collect::<String>(),
    }
}

impl Builder {
    /// Moves a driver behind the gate of this device.
    ///
    /// # Errors
    /// [`NotOnboard::UnknownDevice`] and [`NotOnboard::Installation`].
    pub fn device(mut self, name: &str, driver: Box<dyn Driver>) -> Result<Self, NotOnboard> {
        let spec = self.mission.devices.iter().find(|spec| spec.name == name);
        let spec = spec.ok_or_else(|| NotOnboard::UnknownDevice(name.to_owned()))?;
        self.installation.device(spec, driver)?;
        Ok(self)
    }

    /// The functions that tasks can be.
    #[must_use]
    pub fn functions(mut self, functions: Functions) -> Self {
        self.functions = functions;
        self
    }

    /// What can be set about bodies: limits of outputs and workers.
    #[must_use]
    pub fn bodies(mut self, settings: Settings) -> Self {
        self.settings =
            Settings { state: self.settings.state.take().or(settings.state), ..settings };
        self
    }

    /// Keeps a journal in this directory, and goes on where it ended.
    ///
    /// # Errors
    /// [`NotOnboard::Journal`].
    pub fn journal(mut self, directory: &Path) -> Result<Self, NotOnboard> {
        let state = directory.join("run");
        let (journal, restored, opened, swept) = opening::open(&directory.join("journal"), &state)?;
        self.kept = Kept::Journal(Box::new(journal));
        self.restored = restored;
        self.opened = Some(opened);
        self.swept = swept;
        self.settings.state = Some(state);
        Ok(self)
    }

    /// Takes telecommands at this socket, from the same user alone.
    #[must_use]
    pub fn control(mut self, path: &Path) -> Self {
        self.control = Some(path.to_owned());
        self
    }

    /// How schedules are read that come while others run, where it is not as
    /// [`format::read_with`] does for this mission.
    #[must_use]
    pub fn reading(mut self, schedules: Arc<dyn ReadSchedule>) -> Self {
        self.schedules = schedules;
        self
    }

    /// Runs the agents' service with SCHED_FIFO at this priority. The manager's
    /// own thread is the caller's to set.
    #[must_use]
    pub fn real_time(mut self, priority: u8) -> Self {
        self.installation = self.installation.real_time(priority);
        self
    }

    /// The agents and gates, before they are closed.
    pub fn installation(&mut self) -> &mut Installation {
        &mut self.installation
    }

    /// The clock that the manager will go by. It runs already.
    #[must_use]
    pub fn clock(&self) -> HostClock {
        self.clock
    }

    /// How the journal was found, if there is one.
    #[must_use]
    pub fn opened(&self) -> Option<&Opened> {
        self.opened.as_ref()
    }

    /// Whether the journal has tasks to go on with.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        !self.restored.tasks.is_empty()
    }

    /// Starts, with links alone outside.
    ///
    /// # Errors
    /// [`NotOnboard`].
    pub fn start(self) -> Result<Onboard, NotOnboard> {
        self.start_with(|links, _, _| Ok(links))
    }

    /// Starts, with something around the links that is told and asked, too. It
    /// is given the tickets, for the estimates of sensors, and the manager's
    /// bell.
    ///
    /// # Errors
    /// [`NotOnboard`].
    pub fn start_with<O: Correspondent>(
        self,
        outside: impl FnOnce(Links, &Tickets, &Waker) -> Result<O, NotOnboard>,
    ) -> Result<Onboard<O>, NotOnboard> {
        self.drivers()?;
        let tickets = self.installation.start()?;
        let commands: Arc<dyn Commands> = Arc::new(tickets.commander());
        let ports = CommandServer::start(Arc::clone(&commands), self.waker.clone())?;
        let mut links = Links::new(Arc::clone(&self.schedules), self.waker.clone());
        links.hear(ports.clone());
        if let Some(path) = self.control {
            let link = SocketLink::listen(&path, self.schedules, self.waker.clone());
            links.add(link.map_err(|error| NotOnboard::Control(path, error))?);
        }
        let around = Surroundings { ports: Box::new(ports), commands, functions: self.functions };
        // What an earlier manager left ends here, before anything starts.
        let mut bodies = RealBodies::new(self.settings, self.waker.clone(), around)?;
        bodies.also_swept(self.swept);
        links.read(Gauge::start(&self.mission, bodies.users(), self.waker.clone())?);
        let outside = outside(links, &tickets, &self.waker)?;
        let ports = (bodies, tickets, self.kept, outside);
        Ok(HostExecutive::new(self.mission, self.restored, self.waker, self.clock, ports)?)
    }

    fn drivers(&self) -> Result<(), NotOnboard> {
        let there = |name: &str| self.installation.has(name);
        let names = self.mission.devices.iter().map(|spec| &spec.name);
        let missing: Vec<_> = names.filter(|name| !there(name)).cloned().collect();
        if missing.is_empty() { Ok(()) } else { Err(NotOnboard::NoDriver(missing)) }
    }
}

impl fmt::Debug for Builder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Builder").field("mission", &self.mission).finish_non_exhaustive()
    }
}

impl<O: Correspondent> Onboard<O> {
    /// Adds tasks to the schedule, all or none.
    ///
    /// # Errors
    /// [`NotOnboard::Refused`], and nothing is added; [`NotOnboard::Host`] if
    /// the journal cannot be written.
    pub fn load(&mut self, tasks: Vec<Task>) -> Result<(), NotOnboard> {
        let additions = tasks.into_iter().map(|task| Addition { task }).collect();
        match self.command(Telecommand::Add(additions))? {
            Reply::Done => Ok(()),
            Reply::Refused(why) => Err(NotOnboard::Refused(why)),
        }
    }

    /// Ends in order: what runs is ended, the journal closed. A later run goes
    /// on with what is pending.
    ///
    /// # Errors
    /// The journal's.
    pub fn close(mut self) -> io::Result<()> {
        if !self.manager().is_over() {
            self.command(Telecommand::ShutDown)?;
            self.run(|manager, _| manager.is_over())?;
        }
        let (_, _, kept, _) = self.into_ports();
        match kept {
            Kept::Journal(journal) => journal.close().map_err(io::Error::other),
            Kept::Nowhere(_) => Ok(()),
        }
    }
}
