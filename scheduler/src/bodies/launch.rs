//! How a process is started: its program, its environment, its descriptors.

use std::env;
use std::ffi::{CString, OsString};
use std::fs::{self, File};
use std::io;
use std::os::fd::{AsFd, AsRawFd, OwnedFd};
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};

use rustix::event::{PollFd, PollFlags, poll};
use rustix::fs::{Access, OFlags, access, fcntl_setfl};
use rustix::io::{Errno, fcntl_dupfd_cloexec};
use rustix::pipe::{PipeFlags, pipe_with};
use rustix::process::Pid;

use crate::bodies::cgroup::Group;
use crate::bodies::children;
use crate::bodies::family::MARK;
use crate::bodies::sys::{Failure, PORT, Plan, Step};
use crate::manager::Attempt;

/// A process is told through these which attempt it is, and where its command
/// port is.
const TASK: &str = "FAREGATE_TASK";
const OCCURRENCE: &str = "FAREGATE_OCCURRENCE";
const ATTEMPT: &str = "FAREGATE_ATTEMPT";
const PORT_VARIABLE: &str = "FAREGATE_PORT";

/// Where programs are looked for when nothing says where.
const DEFAULT_PATH: &str = "/usr/local/bin:/usr/bin:/bin";

/// What is to be started.
pub(super) struct Order<'a> {
    pub(super) program: &'a str,
    pub(super) arguments: &'a [String],
    pub(super) attempt: Attempt,
    pub(super) mark: String,
    pub(super) port: Option<OwnedFd>,
    pub(super) open_files: Option<u64>,
    pub(super) group: Option<&'a Group>,
}

/// Everything that a fork needs.
pub(super) struct Prepared<'a> {
    program: CString,
    arguments: Vec<CString>,
    environment: Vec<CString>,
    pipes: Pipes,
    mark: String,
    open_files: Option<u64>,
    group: Option<&'a Group>,
}

/// What was started.
#[derive(Debug)]
pub(super) struct Started {
    pub(super) pid: Pid,
    pub(super) pidfd: OwnedFd,
    /// What [`why_not_executed`] reads.
    pub(super) failure: OwnedFd,
}

impl<'a> Prepared<'a> {
    /// # Errors
    /// Why it cannot be started, for people.
    pub(super) fn new(order: Order<'a>) -> Result<Self, String> {
        let program = find(order.program)?;
        let words = [order.program].into_iter().chain(order.arguments.iter().map(String::as_str));
        Ok(Self {
            program: text(program.into_os_string().into_vec())?,
            arguments: words.map(|word| text(word.into())).collect::<Result<_, _>>()?,
            environment: environment(&order).into_iter().map(text).collect::<Result<_, _>>()?,
            pipes: Pipes::open(order.port).map_err(|error| format!("no descriptors: {error}"))?,
            mark: order.mark,
            open_files: order.open_files,
            group: order.group,
        })
    }

    /// Where what it prints can be read: standard output and standard error.
    pub(super) fn outputs(&mut self) -> Option<(OwnedFd, OwnedFd)> {
        self.pipes.output.0.take().zip(self.pipes.errors.0.take())
    }

    /// Forks. Whether the program could be executed is known from
    /// [`why_not_executed`] when the process has ended.
    ///
    /// # Errors
    /// The kernel's, for people.
    pub(super) fn fork(self) -> Result<Started, String> {
        let pipes = self.pipes;
        let plan = Plan {
            program: &self.program,
            arguments: &self.arguments,
            environment: &self.environment,
            input: pipes.input.as_fd(),
            output: pipes.output.1.as_fd(),
            errors: pipes.errors.1.as_fd(),
            port: pipes.port.as_ref().map(AsFd::as_fd),
            failure: pipes.failure.1.as_fd(),
            open_files: self.open_files,
            group: self.group.map(Group::directory),
        };
        let (pid, pidfd) = children::start(&plan, self.mark, self.group.map(Group::name))
            .map_err(|error| format!("the host forks no process: {error}"))?;
        Ok(Started { pid, pidfd, failure: pipes.failure.0 })
    }
}

fn text(text: Vec<u8>) -> Result<CString, String> {
    CString::new(text).map_err(|_| "there is a zero byte in its arguments".to_owned())
}

/// Whether who is forked into the group lives. A host may kill it at birth: one
/// that has killed the group of this program before, and then had this program
/// started in it.
pub(super) fn lives_in(group: &Group) -> Result<(), String> {
    let failed = |error: io::Error| format!("{}: {error}", group.name());
    let pipes = Pipes::open(None).map_err(failed)?;
    let plan = Plan {
        // What nobody can execute: the child says so, and ends.
        program: c"/",
        arguments: &[],
        environment: &[],
        input: pipes.input.as_fd(),
        output: pipes.output.1.as_fd(),
        errors: pipes.errors.1.as_fd(),
        port: None,
        failure: pipes.failure.1.as_fd(),
        open_files: None,
        group: Some(group.directory()),
    };
    let (pid, pidfd) = children::start(&plan, String::new(), Some(group.name())).map_err(failed)?;
    let _ = poll(&mut [PollFd::new(&pidfd, PollFlags::IN)], None);
    children::reap(pid, &pidfd);
    match why_not_executed(&pipes.failure.0, "/") {
        Some(_) => Ok(()),
        None => Err("the host kills what is forked into a control group below its own".into()),
    }
}

/// Why the child never became its program; `None`: it did.
pub(super) fn why_not_executed(failure: &OwnedFd, program: &str) -> Option<String> {
    let mut bytes = [0; 16];
    let length = rustix::io::read(failure, &mut bytes).ok()?;
    let failure = Failure::from_bytes(bytes.get(..length)?)?;
    let error = io::Error::from_raw_os_error(failure.errno);
    if failure.step == Step::Prepare {
        return Some(format!("{program}: the process could not be prepared: {error}"));
    }
    let hint = match Errno::from_raw_os_error(failure.errno) {
        Errno::NOENT => "; it is there, so the interpreter or loader that it names is not",
        Errno::NOEXEC => {
            "; it is neither a program for this machine nor a script that begins with #!"
        }
        Errno::ACCESS => "; its file system may forbid execution",
        Errno::TOOBIG => "; its arguments and environment are too long",
        Errno::TXTBSY => "; somebody is writing to it",
        _ => "",
    };
    Some(format!("{program}: {error}{hint}"))
}

/// The file to execute. Looked up before the fork, so that the answer can say
/// where it was looked for.
fn find(program: &str) -> Result<PathBuf, String> {
    if program.contains('/') {
        return check(Path::new(program)).map(|()| program.into());
    }
    if program.is_empty() {
        return Err("the task names no program".into());
    }
    let path = env::var_os("PATH").unwrap_or_else(|| DEFAULT_PATH.into());
    let mut found = env::split_paths(&path).map(|directory| directory.join(program));
    found.find(|candidate| check(candidate).is_ok()).ok_or_else(|| {
        let places = path.display();
        format!("no program {program:?} in PATH ({places}); a path with a / in it needs no PATH")
    })
}

fn check(program: &Path) -> Result<(), String> {
    let shown = program.display();
    let kind =
        fs::metadata(program).map_err(|error| format!("{shown}: {error}{}", seen(program)))?;
    if !kind.is_file() {
        return Err(format!("{shown} is not a file that can be executed"));
    }
    access(program, Access::EXEC_OK).map_err(|error| {
        format!("{shown}: {}; chmod +x makes it executable", io::Error::from(error))
    })
}

/// From where a path that does not begin with `/` leads to nothing.
fn seen(program: &Path) -> String {
    let from = env::current_dir().ok().filter(|_| program.is_relative());
    from.map_or_else(String::new, |from| format!("; seen from {}", from.display()))
}

/// This program's own environment, with what tells the process who it is.
fn environment(order: &Order<'_>) -> Vec<Vec<u8>> {
    let occurrence = order.attempt.occurrence;
    let mut own = vec![
        (TASK, occurrence.task.get().to_string()),
        (OCCURRENCE, occurrence.number.to_string()),
        (ATTEMPT, order.attempt.number.to_string()),
        (MARK, order.mark.clone()),
    ];
    if order.port.is_some() {
        own.push((PORT_VARIABLE, PORT.to_string()));
    }
    let ours = |name: &OsString| {
        [TASK, OCCURRENCE, ATTEMPT, MARK, PORT_VARIABLE].iter().any(|own| name == own)
    };
    let inherited = env::vars_os().filter(|(name, _)| !ours(name));
    let own = own.into_iter().map(|(name, value)| (name.into(), value.into()));
    inherited
        .chain(own)
        .map(|(name, value)| [name.into_vec(), value.into_vec()].join(&b'='))
        .collect()
}

/// The descriptors of a process. The child's ends are above the numbers that
/// they get in the child: putting one there cannot close another.
struct Pipes {
    input: OwnedFd,
    output: (Option<OwnedFd>, OwnedFd),
    errors: (Option<OwnedFd>, OwnedFd),
    failure: (OwnedFd, OwnedFd),
    port: Option<OwnedFd>,
}

impl Pipes {
    fn open(port: Option<OwnedFd>) -> io::Result<Self> {
        let failure = pipe()?;
        fcntl_setfl(&failure.0, OFlags::NONBLOCK)?;
        Ok(Self {
            input: above(File::open("/dev/null")?.into())?,
            output: pipe().map(|(read, write)| (Some(read), write))?,
            errors: pipe().map(|(read, write)| (Some(read), write))?,
            failure,
            port: port.map(above).transpose()?,
        })
    }
}

fn pipe() -> io::Result<(OwnedFd, OwnedFd)> {
    let (read, write) = pipe_with(PipeFlags::CLOEXEC)?;
    Ok((read, above(write)?))
}

/// Only a program that was started without its standard descriptors has to
/// move any: a start that is due does not wait for what is right already.
fn above(descriptor: OwnedFd) -> io::Result<OwnedFd> {
    if descriptor.as_raw_fd() > PORT {
        return Ok(descriptor);
    }
    Ok(fcntl_dupfd_cloexec(descriptor, PORT + 1)?)
}
