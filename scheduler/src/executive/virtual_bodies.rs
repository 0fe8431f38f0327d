//! Bodies that only take their time.

use core::fmt;
use std::collections::{BTreeMap, BTreeSet};

use crate::executive::{Bodies, StartBody};
use crate::manager::{Attempt, Event, Exit, Occurrence, Stop, StopWhy};
use crate::task::{Body, Task};
use crate::time::{Duration, Instant, Now};

/// What a body is going to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conduct {
    /// How long it runs, pauses not counted.
    pub takes: Duration,
    /// How it ends then.
    pub exit: Exit,
}

impl Conduct {
    /// Succeeds after this long.
    #[must_use]
    pub const fn succeeds_after(takes: Duration) -> Self {
        Self { takes, exit: Exit::Code(0) }
    }
}

/// How long a task is expected to run: its duration, and a sequence at least
/// until its last command. No time at all, where nothing is stated.
#[must_use]
pub fn expected(task: &Task) -> Duration {
    let Body::Sequence(steps) = &task.body else { return task.duration };
    steps.iter().map(|step| step.offset).fold(task.duration, Duration::max)
}

type Script = Box<dyn FnMut(Attempt, &Task) -> Conduct + Send>;

/// Processes, functions, sequences and holds on a virtual clock.
///
/// Starting, pausing and killing take no time. A checkpoint takes the whole of
/// its grace, in which no work is done, and the run after it does only what was
/// left. After a kill everything is done again.
pub struct VirtualBodies {
    script: Script,
    bodies: BTreeMap<Attempt, Running>,
    ends: BTreeSet<(Instant, Attempt)>,
    saved: BTreeMap<Occurrence, Conduct>,
    events: Vec<Event>,
}

/// A body between its start and its end.
#[derive(Clone, Debug)]
struct Running {
    conduct: Conduct,
    /// Since when it does its work; none: it stands still.
    since: Option<Instant>,
    ends: Option<Instant>,
}

impl VirtualBodies {
    /// Bodies that behave as the script says, which is asked at each start.
    pub fn new(script: impl FnMut(Attempt, &Task) -> Conduct + Send + 'static) -> Self {
        Self {
            script: Box::new(script),
            bodies: BTreeMap::new(),
            ends: BTreeSet::new(),
            saved: BTreeMap::new(),
            events: Vec::new(),
        }
    }

    /// Bodies that take as long as expected and succeed.
    #[must_use]
    pub fn as_expected() -> Self {
        Self::new(|_, task| Conduct::succeeds_after(expected(task)))
    }

    fn end_at(&mut self, attempt: Attempt, at: Instant) {
        if let Some(body) = self.bodies.get_mut(&attempt) {
            if let Some(before) = body.ends.replace(at) {
                self.ends.remove(&(before, attempt));
            }
            self.ends.insert((at, attempt));
        }
    }

    /// Stops the work, and answers how much of it is left.
    fn halt(&mut self, attempt: Attempt, now: Instant) -> Option<Conduct> {
        let body = self.bodies.get_mut(&attempt)?;
        if let Some(at) = body.ends.take() {
            self.ends.remove(&(at, attempt));
        }
        if let Some(since) = body.since.take() {
            body.conduct.takes = body.conduct.takes.saturating_sub(now.since(since));
        }
        Some(body.conduct.clone())
    }

    fn exit(&mut self, attempt: Attempt, exit: Exit) {
        self.bodies.remove(&attempt);
        self.events.push(Event::Exited { attempt, exit });
    }
}

/// What a process that does not handle SIGTERM ends with.
const TERMINATED: Exit = Exit::Signal(15);

impl Bodies for VirtualBodies {
    fn start(&mut self, StartBody { attempt, task, now }: StartBody<'_>) {
        let saved = self.saved.remove(&attempt.occurrence);
        let conduct = saved.unwrap_or_else(|| (self.script)(attempt, task));
        let end = now.elapsed.after(conduct.takes);
        let body = Running { conduct, since: Some(now.elapsed), ends: None };
        self.bodies.insert(attempt, body);
        self.end_at(attempt, end);
    }

    fn stop(&mut self, attempt: Attempt, how: Stop, why: &StopWhy, now: Now) {
        let Some(left) = self.halt(attempt, now.elapsed) else { return };
        match how {
            Stop::Pause => self.events.push(Event::Stopped { attempt }),
            Stop::Kill { .. } => self.exit(attempt, TERMINATED),
            Stop::Checkpoint { grace, .. } => {
                if matches!(why, StopWhy::Preempted { .. }) {
                    self.saved.insert(attempt.occurrence, left);
                }
                if let Some(body) = self.bodies.get_mut(&attempt) {
                    body.conduct.exit = TERMINATED;
                }
                self.end_at(attempt, now.elapsed.after(grace));
            }
        }
    }

    fn resume(&mut self, attempt: Attempt, now: Now) {
        let Some(body) = self.bodies.get_mut(&attempt) else { return };
        body.since = Some(now.elapsed);
        let end = now.elapsed.after(body.conduct.takes);
        self.end_at(attempt, end);
    }

    fn poll(&mut self, now: Now, events: &mut Vec<Event>) {
        while let Some(&(at, attempt)) = self.ends.first()
            && at <= now.elapsed
        {
            self.ends.pop_first();
            if let Some(body) = self.bodies.get(&attempt) {
                let exit = body.conduct.exit.clone();
                self.exit(attempt, exit);
            }
        }
        events.append(&mut self.events);
    }

    fn next_due(&self) -> Option<Instant> {
        let told = (!self.events.is_empty()).then_some(Instant::START);
        told.or_else(|| self.ends.first().map(|(at, _)| *at))
    }
}

impl fmt::Debug for VirtualBodies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("VirtualBodies").field("bodies", &self.bodies).finish_non_exhaustive()
    }
}
