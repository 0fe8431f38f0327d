//! The control port, from an operator's side.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use crate::wire::control::{
    Answer, Ask, MAX_LINE, MAX_ROWS, Said, Status, StatusQuery, TaskRow, Window,
};
use crate::wire::{Asked, Id, line};
use crate::{Error, PROTOCOL, Refused, Watch};

/// How long a manager has for an answer, at first.
const TIMEOUT: Duration = Duration::from_secs(30);

/// A connection to a manager's control port.
#[derive(Debug)]
pub struct Control {
    stream: BufReader<UnixStream>,
    /// The beginning of a line whose end did not come in time.
    begun: Vec<u8>,
    program: String,
    last: Id,
    timeout: Option<Duration>,
}

impl Control {
    /// Connects to the manager that listens at this path.
    ///
    /// # Errors
    /// [`Error::NoPort`] if nobody listens there. [`Error::Refused`] if the port
    /// is another user's, or has no place. [`Error::Version`].
    pub fn connect(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let stream = UnixStream::connect(path).map_err(|error| nobody(path, error))?;
        let mut control = Self {
            stream: BufReader::new(stream),
            begun: Vec::new(),
            program: String::new(),
            last: 0,
            timeout: None,
        };
        control.set_timeout(Some(TIMEOUT))?;
        match control.hear()? {
            Said::Hello { protocol: PROTOCOL, program } => control.program = program,
            Said::Hello { protocol, .. } => return Err(Error::Version { theirs: protocol }),
            Said::Answer { what: Answer::Refused(why), .. } => return Err(why.into()),
            other => return Err(Error::NotUnderstood(format!("{other:?} comes before a hello"))),
        }
        Ok(control)
    }

    /// The program that listens, with its version.
    #[must_use]
    pub fn program(&self) -> &str {
        &self.program
    }

    /// How long to wait for an answer; none: as long as it takes.
    ///
    /// # Errors
    /// What the operating system says; a timeout of zero is an error.
    pub fn set_timeout(&mut self, timeout: Option<Duration>) -> Result<(), Error> {
        self.stream.get_ref().set_read_timeout(timeout)?;
        self.stream.get_ref().set_write_timeout(timeout)?;
        self.timeout = timeout;
        Ok(())
    }

    /// Adds the tasks of a schedule, all or none. The name's ending tells the
    /// format.
    ///
    /// # Errors
    /// [`Error::Refused`] with every mistake in it.
    pub fn add(&mut self, name: &str, text: &str) -> Result<(), Error> {
        self.done(Ask::Add { name: name.into(), text: text.into() })
    }

    /// Removes tasks; one that runs is aborted.
    ///
    /// # Errors
    /// [`Error::Refused`], and nothing was removed.
    pub fn remove(&mut self, tasks: &[u32]) -> Result<(), Error> {
        self.done(Ask::Remove { tasks: tasks.into() })
    }

    /// Changes a task's priority.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn set_priority(&mut self, task: u32, priority: u8) -> Result<(), Error> {
        self.done(Ask::SetPriority { task, priority })
    }

    /// Changes when a task may start.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn set_windows(&mut self, task: u32, windows: &[Window]) -> Result<(), Error> {
        self.done(Ask::SetWindows { task, windows: windows.into() })
    }

    /// Drops what is pending; with `all` ends what runs, too.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn clear(&mut self, all: bool) -> Result<(), Error> {
        self.done(Ask::Clear { all })
    }

    /// Keeps a task from starting; one that runs is pre-empted.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn hold(&mut self, task: u32) -> Result<(), Error> {
        self.done(Ask::Hold { task })
    }

    /// Lets a held task go on.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn resume(&mut self, task: u32) -> Result<(), Error> {
        self.done(Ask::Resume { task })
    }

    /// Enters a mode of the mission.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn enter_mode(&mut self, mode: &str) -> Result<(), Error> {
        self.done(Ask::EnterMode { mode: mode.into() })
    }

    /// Leaves a mode of the mission.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn leave_mode(&mut self, mode: &str) -> Result<(), Error> {
        self.done(Ask::LeaveMode { mode: mode.into() })
    }

    /// Ends everything that runs, in order: the manager stops.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn shut_down(&mut self) -> Result<(), Error> {
        self.done(Ask::ShutDown)
    }

    /// Where every task stands. Long schedules come in several answers, and
    /// each is true for its own instant: the one in `at_us` is the last's.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn status(&mut self) -> Result<Status, Error> {
        let mut tasks: Vec<TaskRow> = Vec::new();
        loop {
            let skip = u32::try_from(tasks.len()).unwrap_or(u32::MAX);
            let query = StatusQuery { tasks: Vec::new(), skip, limit: Some(MAX_ROWS) };
            let mut status = self.status_of(query)?;
            let none_left = status.tasks.is_empty() || !status.more;
            tasks.append(&mut status.tasks);
            if none_left {
                return Ok(Status { tasks, more: false, ..status });
            }
        }
    }

    /// Where these tasks stand, as far as they are in the schedule. Many are
    /// asked of in several questions, and the instant is the last one's.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn status_of_tasks(&mut self, tasks: &[u32]) -> Result<Status, Error> {
        let mut all = Status::default();
        for some in tasks.chunks(usize::try_from(MAX_ROWS).unwrap_or(usize::MAX)) {
            let query = StatusQuery { tasks: some.into(), ..StatusQuery::default() };
            let status = self.status_of(query)?;
            all.tasks.extend(status.tasks);
            (all.at_us, all.unix_us) = (status.at_us, status.unix_us);
        }
        Ok(all)
    }

    /// Where some tasks stand, in one answer.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn status_of(&mut self, query: StatusQuery) -> Result<Status, Error> {
        match self.ask(Ask::Status(query))? {
            Answer::Status(status) => Ok(status),
            other => Err(unexpected(other)),
        }
    }

    /// Every change from now on.
    ///
    /// # Errors
    /// [`Error::Refused`].
    pub fn watch(mut self) -> Result<Watch, Error> {
        self.done(Ask::Watch)?;
        self.set_timeout(None)?;
        Ok(Watch::over(self))
    }

    fn done(&mut self, ask: Ask) -> Result<(), Error> {
        match self.ask(ask)? {
            Answer::Done => Ok(()),
            other => Err(unexpected(other)),
        }
    }

    fn ask(&mut self, ask: Ask) -> Result<Answer, Error> {
        self.last += 1;
        let message = line(&Asked { id: Some(self.last), ask }).map_err(std::io::Error::from)?;
        if message.len() > MAX_LINE {
            return Err(Error::TooLong { length: message.len(), limit: MAX_LINE });
        }
        // A manager that refuses the connection says why before it closes it.
        let sent = self.stream.get_mut().write_all(&message);
        loop {
            match self.hear() {
                Ok(Said::Answer { id, what }) if id.is_none_or(|id| id == self.last) => {
                    return Ok(what);
                }
                // An answer that came after its timeout, or a note.
                Ok(_) => {}
                Err(error) => return Err(self.failed(sent.err(), error)),
            }
        }
    }

    /// What could not be sent explains why nothing was heard.
    fn failed(&self, sent: Option<std::io::Error>, heard: Error) -> Error {
        match (sent.map(|error| error.kind()), heard) {
            (Some(ErrorKind::BrokenPipe | ErrorKind::ConnectionReset), Error::Io(_)) => {
                Error::Closed
            }
            (Some(ErrorKind::WouldBlock), Error::Io(_)) => {
                Error::NoAnswer { within: self.timeout.unwrap_or_default() }
            }
            (_, heard) => heard,
        }
    }

    pub(crate) fn hear(&mut self) -> Result<Said, Error> {
        let room = u64::try_from(MAX_LINE - self.begun.len()).unwrap_or(u64::MAX);
        match self.stream.by_ref().take(room).read_until(b'\n', &mut self.begun) {
            Ok(_) => {}
            Err(error) => return Err(self.unheard(error)),
        }
        let bytes = std::mem::take(&mut self.begun);
        if bytes.last() != Some(&b'\n') {
            return Err(if bytes.len() == MAX_LINE {
                Error::NotUnderstood(format!("longer than {MAX_LINE} bytes"))
            } else {
                Error::Closed
            });
        }
        serde_json::from_slice(&bytes).map_err(|error| Error::NotUnderstood(error.to_string()))
    }

    fn unheard(&self, error: std::io::Error) -> Error {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                Error::NoAnswer { within: self.timeout.unwrap_or_default() }
            }
            ErrorKind::ConnectionReset | ErrorKind::BrokenPipe => Error::Closed,
            _ => Error::Io(error),
        }
    }
}

fn unexpected(answer: Answer) -> Error {
    match answer {
        Answer::Refused(why) => why.into(),
        other => Error::NotUnderstood(format!("another answer than the one to this: {other:?}")),
    }
}

fn nobody(path: &Path, error: std::io::Error) -> Error {
    let path = path.display();
    match error.kind() {
        ErrorKind::NotFound => Error::NoPort(format!(
            "nobody listens at {path}: is the schedule manager running, and is this its socket?"
        )),
        ErrorKind::ConnectionRefused => Error::NoPort(format!(
            "nobody listens at {path} any more: the schedule manager has ended"
        )),
        ErrorKind::PermissionDenied => Error::Refused(Refused::new(
            crate::RefusalKind::NotPermitted,
            format!("the schedule manager at {path} belongs to another user"),
        )),
        _ => Error::NoPort(format!("no connection to {path}: {error}")),
    }
}
