//! Threads that may wait: for functions, and for devices.
//!
//! A worker has one call at a time and reports when it is done. Which workers
//! are idle is known to the manager's thread alone, which gives a call to an
//! idle one or to a new one: none waits behind another. Nothing is shared but
//! channels and, with a function, whether it was asked to stop and has beaten.

use std::any::Any;
use std::collections::BTreeMap;
use std::io;
use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crossbeam::channel::{Receiver, Sender, unbounded};

use crate::bodies::functions::{Function, Invocation};
use crate::bodies::settings::{Moment, Probe, Settings};
use crate::executive::{CommandRefused, Commands, RefusedKind, Waker};
use crate::manager::{Attempt, Exit};
use crate::task::Step;

/// Tells workers apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct WorkerId(u64);

/// What a worker is given to do.
pub(super) enum Call {
    Function(Arc<Function>, Invocation),
    Command(Attempt, Step),
}

/// What workers say.
pub(super) enum Report {
    /// A function is over, and its worker is idle.
    Returned(Attempt, WorkerId, Exit),
    /// A command is over, and its worker is idle.
    Answered(Attempt, WorkerId, Result<String, CommandRefused>),
}

/// How a worker speaks to the manager's thread.
#[derive(Clone, Debug)]
struct Desk {
    reports: Sender<Report>,
    waker: Waker,
}

impl Desk {
    fn report(&self, report: Report) {
        // Nobody listens any more when the bodies are gone.
        if self.reports.send(report).is_ok() {
            self.waker.wake();
        }
    }
}

/// The workers of a manager.
pub(super) struct Workers {
    calls: BTreeMap<WorkerId, Sender<Call>>,
    idle: Vec<WorkerId>,
    next: u64,
    limit: usize,
    probe: Probe,
    commands: Arc<dyn Commands>,
    desk: Desk,
    reports: Receiver<Report>,
}

impl Workers {
    /// # Errors
    /// When the host has no thread left for those that are to be ready.
    pub(super) fn new(
        settings: &Settings,
        commands: Arc<dyn Commands>,
        waker: Waker,
    ) -> io::Result<Self> {
        let (sender, reports) = unbounded();
        let mut workers = Self {
            calls: BTreeMap::new(),
            idle: Vec::new(),
            next: 0,
            limit: settings.workers,
            probe: settings.probe.clone(),
            commands,
            desk: Desk { reports: sender, waker },
            reports,
        };
        for _ in 0..settings.workers_ready.min(settings.workers) {
            let worker = workers.hire()?;
            workers.idle.push(worker);
        }
        Ok(workers)
    }

    /// The bell of the manager's thread.
    pub(super) fn manager(&self) -> &Waker {
        &self.desk.waker
    }

    pub(super) fn commands(&self) -> &Arc<dyn Commands> {
        &self.commands
    }

    /// Has a worker do this.
    ///
    /// # Errors
    /// When there is none, for people.
    pub(super) fn give(&mut self, call: Call) -> Result<WorkerId, String> {
        let worker = match self.idle.pop() {
            Some(worker) => worker,
            None if self.calls.len() >= self.limit => {
                return Err(format!("all {} workers are busy", self.limit));
            }
            None => self.hire().map_err(|error| format!("no thread for it: {error}"))?,
        };
        match self.calls.get(&worker).map(|calls| calls.send(call)) {
            Some(Ok(())) => Ok(worker),
            None | Some(Err(_)) => Err("its worker is gone".into()),
        }
    }

    /// Never to be used again: it ends when its function returns.
    pub(super) fn dismiss(&mut self, worker: WorkerId) {
        self.calls.remove(&worker);
    }

    /// What was reported next, if anything was.
    pub(super) fn next_report(&mut self) -> Option<Report> {
        let report = self.reports.try_recv().ok()?;
        let (Report::Returned(_, worker, _) | Report::Answered(_, worker, _)) = &report;
        if self.calls.contains_key(worker) {
            self.idle.push(*worker);
        }
        Some(report)
    }

    fn hire(&mut self) -> io::Result<WorkerId> {
        let id = WorkerId(self.next);
        self.next += 1;
        let (sender, calls) = unbounded();
        let hands = Hands {
            id,
            calls,
            probe: self.probe.clone(),
            commands: Arc::clone(&self.commands),
            desk: self.desk.clone(),
        };
        let thread = std::thread::Builder::new().name(format!("task-worker-{}", id.0));
        // Not joined: a function that does not return must not keep the
        // manager from ending.
        thread.spawn(move || hands.serve())?;
        self.calls.insert(id, sender);
        Ok(id)
    }
}

/// What a worker's own thread has.
struct Hands {
    id: WorkerId,
    calls: Receiver<Call>,
    probe: Probe,
    commands: Arc<dyn Commands>,
    desk: Desk,
}

impl Hands {
    /// Until the sender is gone.
    fn serve(self) {
        while let Ok(call) = self.calls.recv() {
            let report = match call {
                Call::Function(function, invocation) => self.call(&*function, &invocation),
                Call::Command(attempt, step) => {
                    Report::Answered(attempt, self.id, self.command(attempt, &step))
                }
            };
            self.desk.report(report);
        }
    }

    /// A panic is the task's failure, and ends here.
    fn call(&self, function: &Function, invocation: &Invocation) -> Report {
        let attempt = invocation.attempt();
        self.probe.passes(Moment::Enter, attempt);
        let returned = catch_unwind(AssertUnwindSafe(|| function(invocation)));
        let exit = match returned {
            Ok(Ok(())) => Exit::Code(0),
            Ok(Err(why)) => Exit::Failed(why),
            Err(thrown) => Exit::Panicked(text(thrown)),
        };
        Report::Returned(attempt, self.id, exit)
    }

    fn command(&self, attempt: Attempt, step: &Step) -> Result<String, CommandRefused> {
        let command = || self.commands.command(attempt, &step.gate, &step.command, &step.arguments);
        catch_unwind(AssertUnwindSafe(command))
            .unwrap_or_else(|thrown| Err(CommandRefused::new(RefusedKind::Fault, text(thrown))))
    }
}

/// What was thrown, in words. Its `Drop` is somebody else's code and may panic
/// too; what that throws is leaked, or there would be no end to it.
fn text(thrown: Box<dyn Any + Send>) -> String {
    let text = thrown.downcast_ref::<String>().cloned();
    let text = text.or_else(|| thrown.downcast_ref::<&str>().map(ToString::to_string));
    if let Err(thrown_by_drop) = catch_unwind(AssertUnwindSafe(|| drop(thrown))) {
        let _ = ManuallyDrop::new(thrown_by_drop);
    }
    text.unwrap_or_else(|| "it panicked without words".into())
}
