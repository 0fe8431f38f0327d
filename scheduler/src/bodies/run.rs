//! All bodies of a manager, behind one descriptor.

use core::fmt;
use std::collections::VecDeque;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::path::Path;

use crate::bodies::functions::Calls;
use crate::bodies::gauge::Users;
use crate::bodies::holds::Holds;
use crate::bodies::output::Output;
use crate::bodies::processes::Processes;
use crate::bodies::sequences::Sequences;
use crate::bodies::settings::{Settings, Surroundings};
use crate::bodies::sweep::{Run, Swept};
use crate::bodies::workers::{Report, Workers};
use crate::executive::{Bodies, StartBody, Waker, Watched};
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
    calls: Calls,
    sequences: Sequences,
    holds: Holds,
    workers: Workers,
    waker: Waker,
    pending: Vec<Event>,
    outputs: Outputs,
    /// Whose memory is measured.
    users: Users,
}

impl RealBodies {
    /// Bodies that ring this bell.
    ///
    /// If the settings say where runs are written down, what the last one has
    /// left behind is killed first; see [`RealBodies::swept`].
    ///
    /// Makes this program the one that adopts orphans among its descendants
    /// (`PR_SET_CHILD_SUBREAPER`), and listens to SIGCHLD beside whoever else
    /// does.
    ///
    /// # Errors
    /// When the host has no descriptor or thread left, and as
    /// [`sweep`](crate::bodies::sweep).
    pub fn new(settings: Settings, waker: Waker, around: Surroundings) -> io::Result<Self> {
        let Surroundings { ports, commands, functions } = around;
        let run = Run::begin(&settings)?;
        Ok(Self {
            workers: Workers::new(&settings, commands, waker.clone())?,
            calls: Calls::new(functions),
            sequences: Sequences::default(),
            holds: Holds::default(),
            waker,
            pending: Vec::new(),
            outputs: Outputs::new(settings.outputs_kept),
            users: Users::default(),
            processes: Processes::new(settings, run, ports)?,
        })
    }

    /// Those whose use of memory is to be measured.
    pub(crate) fn users(&self) -> Users {
        self.users.clone()
    }

    /// These were swept before, too.
    pub(crate) fn also_swept(&mut self, swept: Vec<Swept>) {
        self.processes.also_swept(swept);
    }

    /// What the last manager with this state had left, and what was killed when
    /// these bodies were made.
    #[must_use]
    pub fn swept(&self) -> &[Swept] {
        self.processes.swept()
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
        self.processes.output(attempt).or_else(|| self.outputs.get(attempt))
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
        let StartBody { attempt, task, now } = body;
        match &task.body {
            Body::Process { program, arguments } => {
                self.processes.start(attempt, program, arguments)?;
                let whereabouts = self.processes.whereabouts(attempt);
                if let Some(whereabouts) = whereabouts.filter(|_| task.memory > 0) {
                    self.users.add(attempt, whereabouts);
                }
            }
            Body::Function { number, arguments } => {
                self.calls.start(attempt, *number, arguments, &mut self.workers)?;
            }
            Body::Sequence(steps) => self.sequences.start(attempt, steps, now.elapsed),
            Body::Hold => self.holds.start(attempt, task.duration, now.elapsed),
            Body::BuiltIn(_) => return Err("the manager itself runs its own functions".into()),
        }
        Ok(())
    }

    /// What sequences do at once, and that there is something to tell.
    fn follow_up(&mut self, now: Instant) {
        self.sequences.poll(now, &mut self.workers, &mut self.pending);
        if !self.pending.is_empty() {
            self.waker.wake();
        }
    }

    fn hear(&mut self, now: Instant, events: &mut Vec<Event>) {
        while let Some(report) = self.workers.next_report() {
            match report {
                Report::Returned(attempt, _, exit) => self.calls.returned(attempt, exit, events),
                Report::Answered(attempt, worker, answer) => {
                    self.sequences.answered(attempt, worker, answer, now, events);
                }
            }
        }
    }
}

impl Bodies for RealBodies {
    fn start(&mut self, body: StartBody<'_>) {
        if let Err(why) = self.begin(body) {
            let exit = Exit::NotStarted(why);
            self.pending.push(Event::Exited { attempt: body.attempt, exit });
        }
        self.follow_up(body.now.elapsed);
    }

    fn stop(&mut self, attempt: Attempt, how: Stop, _: &StopWhy, now: Now) {
        self.processes.stop(attempt, how, now.elapsed);
        self.calls.stop(attempt, how, now.elapsed);
        self.sequences.stop(attempt, how, now.elapsed);
        self.holds.stop(attempt, how, now.elapsed, &mut self.pending);
        self.follow_up(now.elapsed);
    }

    fn resume(&mut self, attempt: Attempt, now: Now) {
        self.processes.resume(attempt);
        self.sequences.resume(attempt, now.elapsed);
        self.holds.resume(attempt, now.elapsed);
        self.follow_up(now.elapsed);
    }

    fn poll(&mut self, now: Now, events: &mut Vec<Event>) {
        let now = now.elapsed;
        events.append(&mut self.pending);
        self.hear(now, events);
        self.calls.poll(now, &mut self.workers, events);
        self.sequences.give_up(now, events);
        self.sequences.poll(now, &mut self.workers, events);
        self.holds.poll(now, events);
        let (outputs, users) = (&mut self.outputs, &self.users);
        self.processes.poll(now, events, |attempt, output| {
            outputs.keep(attempt, output);
            users.remove(attempt);
        });
    }

    fn next_due(&self) -> Option<Instant> {
        let told = (!self.pending.is_empty()).then_some(Instant::START);
        let parts = [
            told,
            self.processes.next_due(),
            self.calls.next_due(),
            self.sequences.next_due(),
            self.holds.next_due(),
        ];
        parts.into_iter().flatten().min()
    }
}

impl Watched for RealBodies {
    fn fds<'a>(&'a self, fds: &mut Vec<BorrowedFd<'a>>) {
        fds.push(self.as_fd());
    }
}

/// The outputs of attempts that are over, the last ones'.
struct Outputs {
    kept: VecDeque<(Attempt, Output)>,
    limit: usize,
}

impl Outputs {
    fn new(limit: usize) -> Self {
        Self { kept: VecDeque::new(), limit }
    }

    fn keep(&mut self, attempt: Attempt, output: Output) {
        self.kept.push_back((attempt, output));
        let excess = self.kept.len().saturating_sub(self.limit);
        self.kept.drain(..excess);
    }

    fn get(&self, attempt: Attempt) -> Option<Output> {
        let found = self.kept.iter().rev().find(|(of, _)| *of == attempt);
        found.map(|(_, output)| output.clone())
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
