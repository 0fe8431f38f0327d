//! All bodies of a manager, behind one descriptor.

use core::fmt;
use std::collections::VecDeque;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::path::Path;

use crate::bodies::cgroup::Groups;
use crate::bodies::output::Output;
use crate::bodies::processes::Processes;
use crate::bodies::settings::Settings;
use crate::executive::{Bodies, PortFactory, StartBody, Waker, Watched};
use crate::manager::{Attempt, Event, Exit, Stop, StopWhy};
use crate::task::Body;
use crate::time::{Instant, Now};

/// Runs the bodies of tasks.
///
/// Used by one thread, which lives as long as it: the processes die with the
/// *thread* that has started them. Its descriptor is readable when something
/// has happened to a process; the [`Waker`] is rung for everything else.
pub struct RealBodies {
    processes: Processes,
    waker: Waker,
    pending: Vec<Event>,
    outputs: VecDeque<(Attempt, Output)>,
    outputs_kept: usize,
}

impl RealBodies {
    /// Bodies whose processes reach devices through `ports`.
    ///
    /// Makes this program the one that adopts orphans among its descendants
    /// (`PR_SET_CHILD_SUBREAPER`), and listens to SIGCHLD beside whoever else
    /// does.
    ///
    /// # Errors
    /// When the host has no descriptor or thread left, or shows no processes.
    pub fn new(settings: Settings, waker: Waker, ports: Box<dyn PortFactory>) -> io::Result<Self> {
        let run = std::fs::read_to_string("/proc/sys/kernel/random/uuid")?.trim().to_owned();
        let groups = if settings.control_groups {
            Groups::make(&run)
        } else {
            Err("they are not to be used".to_owned())
        };
        let outputs_kept = settings.outputs_kept;
        let processes = Processes::new(settings, run, groups, ports)?;
        let (pending, outputs) = (Vec::new(), VecDeque::new());
        Ok(Self { processes, waker, pending, outputs, outputs_kept })
    }

    /// The control group that the processes' own are made in, or why there is
    /// none: then they are found by looking at all processes of the host.
    ///
    /// # Errors
    /// Why there is none, for people.
    pub fn control_group(&self) -> Result<&Path, &str> {
        self.processes.groups()
    }

    /// What the attempt has printed. Of those that are over, the last ones'
    /// outputs are kept.
    #[must_use]
    pub fn output(&self, attempt: Attempt) -> Option<Output> {
        let over = || self.outputs.iter().find(|(of, _)| *of == attempt);
        self.processes.output(attempt).or_else(|| over().map(|(_, output)| output.clone()))
    }

    /// Bytes of memory that the processes of an attempt have in use, all
    /// together. Pages that two of them share count twice.
    ///
    /// # Timing
    /// Looks at every process of the host.
    #[must_use]
    pub fn memory(&self, attempt: Attempt) -> Option<u64> {
        self.processes.memory(attempt)
    }

    /// The number of the attempt's main process, while it is not over.
    #[must_use]
    pub fn pid(&self, attempt: Attempt) -> Option<i32> {
        self.processes.pid(attempt).map(|pid| pid.as_raw_nonzero().get())
    }

    fn begin(&mut self, body: StartBody<'_>) -> Result<(), String> {
        match &body.task.body {
            Body::Process { program, arguments } => {
                self.processes.start(body.attempt, program, arguments)
            }
            Body::Function { .. } | Body::Sequence(_) | Body::Hold | Body::BuiltIn(_) => {
                Err("not yet".into())
            }
        }
    }
}

impl Bodies for RealBodies {
    fn start(&mut self, body: StartBody<'_>) {
        if let Err(why) = self.begin(body) {
            let exit = Exit::NotStarted(why);
            self.pending.push(Event::Exited { attempt: body.attempt, exit });
            self.waker.wake();
        }
    }

    fn stop(&mut self, attempt: Attempt, how: Stop, _: &StopWhy, now: Now) {
        self.processes.stop(attempt, how, now.elapsed);
    }

    fn resume(&mut self, attempt: Attempt, _: Now) {
        self.processes.resume(attempt);
    }

    fn poll(&mut self, now: Now, events: &mut Vec<Event>) {
        events.append(&mut self.pending);
        let (outputs, kept) = (&mut self.outputs, self.outputs_kept);
        self.processes.poll(now.elapsed, events, |attempt, output| {
            outputs.push_back((attempt, output));
            let excess = outputs.len().saturating_sub(kept);
            outputs.drain(..excess);
        });
    }

    fn next_due(&self) -> Option<Instant> {
        self.processes.next_due()
    }
}

impl Watched for RealBodies {
    fn fds<'a>(&'a self, fds: &mut Vec<BorrowedFd<'a>>) {
        fds.push(self.as_fd());
    }
}

/// Readable when something has happened to a process.
impl AsFd for RealBodies {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.processes.as_fd()
    }
}

impl fmt::Debug for RealBodies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RealBodies").finish_non_exhaustive()
    }
}
