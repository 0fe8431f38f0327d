//! One process and everything that it has started.
//!
//! | phase | what is awaited | then |
//! |---|---|---|
//! | running | its end | clearing |
//! | stopping | that nothing of it runs | still |
//! | still | its end, or that it is let go on | clearing, running |
//! | ending | its end, until the grace is over | clearing, killing |
//! | killing | its end | clearing |
//! | clearing | that nothing of it lives | over |
//!
//! Its end is the end of its main process. What it leaves behind is killed, and
//! seen dead, before anybody hears of the end: nothing outlives its attempt.

mod tree;

use std::os::fd::{BorrowedFd, OwnedFd};

use rustix::process::{Pid, Signal, pidfd_send_signal};

use crate::bodies::cgroup::Group;
use crate::bodies::children;
use crate::bodies::gauge::Whereabouts;
use crate::bodies::launch::{self, Started};
use crate::bodies::output::{Capture, Output};
use crate::manager::{Exit, Stop};
use crate::task::CheckpointSignal;
use crate::time::{Duration, Instant};

/// How soon it is looked again whether signals have had their effect. Most of
/// what is awaited rings a bell; the state of a process that is not our child
/// rings none.
const FIRST_LOOK: Duration = Duration::from_micros(200);
const LAST_LOOK: Duration = Duration::from_millis(20);

/// A running process, with its kin.
#[derive(Debug)]
pub(super) struct Process {
    program: String,
    pid: Pid,
    pidfd: OwnedFd,
    failure: OwnedFd,
    group: Option<Group>,
    capture: Option<Capture>,
    phase: Phase,
    /// How the main process has ended.
    exit: Option<Exit>,
    /// Its group is frozen, or about to be.
    freezes: bool,
    /// When to look again, in the phases that wait for signals' effect.
    look: Instant,
    pause: Duration,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Running,
    Stopping { seen_still: bool },
    Still,
    Ending { deadline: Instant },
    Killing,
    Clearing { seen_empty: bool },
}

/// What became of a process.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Became {
    /// Nothing new.
    Same,
    /// Everything of it stands still.
    Still,
    /// Nothing of it lives.
    Over(Exit),
}

impl Process {
    pub(super) fn new(
        program: &str,
        started: Started,
        group: Option<Group>,
        capture: Option<Capture>,
    ) -> Self {
        let Started { pid, pidfd, failure, .. } = started;
        Self {
            program: program.to_owned(),
            pid,
            pidfd,
            failure,
            group,
            capture,
            phase: Phase::Running,
            exit: None,
            freezes: false,
            look: Instant::default(),
            pause: FIRST_LOOK,
        }
    }

    /// Readable when the main process has ended.
    pub(super) fn pidfd(&self) -> &OwnedFd {
        &self.pidfd
    }

    /// Tells of the group, where there is one.
    pub(super) fn group_events(&self) -> Option<BorrowedFd<'_>> {
        self.group.as_ref().map(Group::events)
    }

    pub(super) fn pid(&self) -> Pid {
        self.pid
    }

    /// Where it and its kin are found.
    pub(super) fn whereabouts(&self) -> Whereabouts {
        let group = self.group.as_ref().map(|group| group.path().to_owned());
        Whereabouts { main: self.main(), group }
    }

    /// What it has printed up to now.
    pub(super) fn printed(&self) -> Output {
        self.capture.as_ref().map(Capture::so_far).unwrap_or_default()
    }

    /// Bytes of memory of everything that lives of it. Pages that two of them
    /// share count twice.
    pub(super) fn memory(&self) -> u64 {
        let page = u64::try_from(rustix::param::page_size()).unwrap_or(4096);
        let living = self.living(&self.census());
        living.iter().map(|stat| stat.resident_pages.saturating_mul(page)).sum()
    }

    pub(super) fn stop(&mut self, how: Stop, now: Instant) {
        match how {
            Stop::Pause if self.phase == Phase::Running => {
                self.enter(Phase::Stopping { seen_still: false }, now);
                self.stop_everything();
            }
            // It is stopped already, or ends: then its end is the answer.
            Stop::Pause => {}
            Stop::Checkpoint { grace, signal } => {
                let _ = pidfd_send_signal(&self.pidfd, number(signal));
                self.end_within(grace, now);
            }
            // Nobody has time to heed a warning.
            Stop::Kill { grace } if grace.is_zero() => self.end_now(now),
            Stop::Kill { grace } => {
                self.signal_all(Signal::TERM);
                self.end_within(grace, now);
            }
        }
    }

    /// Lets everything of it go on.
    pub(super) fn resume(&mut self) {
        if matches!(self.phase, Phase::Stopping { .. } | Phase::Still) {
            self.phase = Phase::Running;
            self.let_go_on();
        }
    }

    fn end_now(&mut self, now: Instant) {
        if !matches!(self.phase, Phase::Clearing { .. }) {
            self.kill_everything();
            self.enter(Phase::Killing, now);
        }
    }

    fn end_within(&mut self, grace: Duration, now: Instant) {
        let deadline = now.after(grace);
        match self.phase {
            Phase::Killing | Phase::Clearing { .. } => return,
            Phase::Ending { deadline: earlier } if earlier <= deadline => return,
            Phase::Running | Phase::Ending { .. } => {}
            // What is stopped cannot save its work.
            Phase::Stopping { .. } | Phase::Still => self.let_go_on(),
        }
        self.enter(Phase::Ending { deadline }, now);
    }

    /// Looks at what happened. To be called when a descriptor of it is ready, a
    /// child has changed, or `due` has come.
    pub(super) fn attend(&mut self, now: Instant) -> Became {
        if self.exit.is_none() {
            self.exit = children::ended(&self.pidfd);
            if self.exit.is_some() {
                self.enter(Phase::Clearing { seen_empty: false }, now);
            }
        }
        let phase = self.phase;
        match phase {
            Phase::Running | Phase::Still => return Became::Same,
            Phase::Ending { deadline } if now < deadline => return Became::Same,
            Phase::Ending { .. } => {
                self.kill_everything();
                self.enter(Phase::Killing, now);
            }
            Phase::Killing => self.kill_everything(),
            Phase::Stopping { .. } if self.is_still() => {
                self.phase = Phase::Still;
                return Became::Still;
            }
            Phase::Clearing { .. } if self.is_empty() => return self.over(),
            Phase::Stopping { .. } | Phase::Clearing { .. } => {}
        }
        self.look_later(now);
        Became::Same
    }

    /// When to look again without being told.
    pub(super) fn due(&self) -> Option<Instant> {
        match self.phase {
            Phase::Running | Phase::Still => None,
            Phase::Ending { deadline } => Some(deadline),
            Phase::Stopping { .. } | Phase::Killing | Phase::Clearing { .. } => Some(self.look),
        }
    }

    fn enter(&mut self, phase: Phase, now: Instant) {
        self.phase = phase;
        self.pause = FIRST_LOOK;
        self.look = now.after(FIRST_LOOK);
    }

    fn look_later(&mut self, now: Instant) {
        self.look = now.after(self.pause);
        self.pause = LAST_LOOK.min(self.pause.saturating_add(self.pause));
    }

    /// Asked once its last process is gone, and before it is reaped.
    fn over(&self) -> Became {
        let Some(exit) = self.exit.clone() else { return Became::Same };
        let not_executed = launch::why_not_executed(&self.failure, &self.program);
        Became::Over(not_executed.map_or(exit, Exit::NotStarted))
    }

    /// Its group, which nobody is in any more.
    pub(super) fn take_group(&mut self) -> Option<Group> {
        self.group.take()
    }

    /// Gives its number back to the host.
    pub(super) fn reap(&mut self) {
        children::reap(self.pid, &self.pidfd);
    }
}

/// Its output ends with it, whoever still has the other end of the pipes.
impl Drop for Process {
    fn drop(&mut self) {
        if let Some(capture) = &self.capture {
            capture.finish();
        }
    }
}

const fn number(signal: CheckpointSignal) -> Signal {
    match signal {
        CheckpointSignal::User1 => Signal::USR1,
        CheckpointSignal::User2 => Signal::USR2,
        CheckpointSignal::Terminate => Signal::TERM,
        CheckpointSignal::HangUp => Signal::HUP,
        CheckpointSignal::Interrupt => Signal::INT,
    }
}
