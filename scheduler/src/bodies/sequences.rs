//! Commands at times.
//!
//! Times count from the start of the sequence, without its pauses. One command
//! is issued at a time, by a worker: a device may be slow, and the manager's
//! thread waits for none.

use std::collections::BTreeMap;

use crate::bodies::holds::TERMINATED;
use crate::bodies::workers::{Call, WorkerId, Workers};
use crate::executive::{CommandRefused, RefusedKind};
use crate::manager::{Attempt, Event, Exit, Stop};
use crate::task::Step;
use crate::time::{Duration, Instant};

/// How long a sequence whose tickets were taken waits to be stopped for it.
/// The two come from different threads: the refusal may be here first.
const STOP_FOLLOWS: Duration = Duration::from_secs(1);

/// A clock that can be halted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch {
    ran: Duration,
    since: Option<Instant>,
}

impl Watch {
    pub(super) const fn started(now: Instant) -> Self {
        Self { ran: Duration::ZERO, since: Some(now) }
    }

    pub(super) fn halt(&mut self, now: Instant) {
        if let Some(since) = self.since.take() {
            self.ran = self.ran.saturating_add(now.since(since));
        }
    }

    pub(super) fn go_on(&mut self, now: Instant) {
        self.since.get_or_insert(now);
    }

    /// When it shows this much; `None`: never, if it is not let go on.
    pub(super) fn comes_to(&self, shown: Duration) -> Option<Instant> {
        Some(self.since?.after(shown.saturating_sub(self.ran)))
    }
}

/// The sequences that are not over.
#[derive(Debug, Default)]
pub(super) struct Sequences {
    live: BTreeMap<Attempt, Sequence>,
}

#[derive(Debug)]
struct Sequence {
    steps: Vec<Step>,
    next: usize,
    watch: Watch,
    doing: Doing,
    asked: Asked,
}

/// What the sequence itself is at.
#[derive(Debug)]
enum Doing {
    /// Its next step's time is awaited.
    Waits,
    /// A command is being issued by this worker, and given up at an instant
    /// where its longest time is declared.
    Commands { worker: WorkerId, until: Option<Instant> },
    /// A command was refused because the tickets were taken.
    Taken { until: Instant, last_look: bool, why: String },
}

/// What the sequence is asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    Run,
    Pause { told: bool },
    End { deadline: Option<Instant> },
}

impl Sequences {
    pub(super) fn start(&mut self, attempt: Attempt, steps: &[Step], now: Instant) {
        let (watch, steps) = (Watch::started(now), steps.to_vec());
        let (doing, asked) = (Doing::Waits, Asked::Run);
        self.live.insert(attempt, Sequence { steps, next: 0, watch, doing, asked });
    }

    /// A command that is in progress is waited for.
    pub(super) fn stop(&mut self, attempt: Attempt, how: Stop, now: Instant) {
        let Some(sequence) = self.live.get_mut(&attempt) else { return };
        sequence.watch.halt(now);
        sequence.asked = match (how, sequence.asked) {
            (_, Asked::End { .. }) => return,
            (Stop::Pause, _) => Asked::Pause { told: false },
            (Stop::Checkpoint { grace, .. } | Stop::Kill { grace }, _) => {
                Asked::End { deadline: Some(now.after(grace)) }
            }
        };
    }

    pub(super) fn resume(&mut self, attempt: Attempt, now: Instant) {
        let Some(sequence) = self.live.get_mut(&attempt) else { return };
        if !matches!(sequence.asked, Asked::End { .. }) {
            sequence.asked = Asked::Run;
            sequence.watch.go_on(now);
        }
    }

    /// A command is over. One that was given up is not heard of again.
    pub(super) fn answered(
        &mut self,
        attempt: Attempt,
        by: WorkerId,
        answer: Result<String, CommandRefused>,
        now: Instant,
        events: &mut Vec<Event>,
    ) {
        let Some(sequence) = self.live.get_mut(&attempt) else { return };
        if !matches!(sequence.doing, Doing::Commands { worker, .. } if worker == by) {
            return;
        }
        if let Some(exit) = sequence.take(answer, now) {
            self.live.remove(&attempt);
            events.push(Event::Exited { attempt, exit });
        }
    }

    /// Ends what has waited long enough. To be called once in a turn of the
    /// manager, when all answers were heard.
    pub(super) fn give_up(&mut self, now: Instant, events: &mut Vec<Event>) {
        self.each(events, |_, sequence, _| sequence.give_up(now));
    }

    /// Does what is due. To be called when all answers were heard.
    pub(super) fn poll(&mut self, now: Instant, workers: &mut Workers, events: &mut Vec<Event>) {
        self.each(events, |attempt, sequence, events| sequence.poll(attempt, now, workers, events));
    }

    /// Does this with each; those that give an exit are over.
    fn each(
        &mut self,
        events: &mut Vec<Event>,
        mut act: impl FnMut(Attempt, &mut Sequence, &mut Vec<Event>) -> Option<Exit>,
    ) {
        self.live.retain(|attempt, sequence| {
            let exit = act(*attempt, sequence, events);
            exit.map(|exit| events.push(Event::Exited { attempt: *attempt, exit })).is_none()
        });
    }

    pub(super) fn next_due(&self) -> Option<Instant> {
        self.live.values().filter_map(Sequence::due).min()
    }
}

impl Sequence {
    /// What the answer means; an exit: the sequence is over.
    fn take(&mut self, answer: Result<String, CommandRefused>, now: Instant) -> Option<Exit> {
        self.doing = Doing::Waits;
        let refused = match answer {
            Err(refused) => refused,
            Ok(_) => {
                self.next += 1;
                return None;
            }
        };
        let why = self.about(&refused.reason);
        match (refused.kind, self.asked) {
            (_, Asked::End { .. }) => {}
            // It is tried again when the tickets are valid again.
            (RefusedKind::Taken, Asked::Pause { .. }) => {}
            (RefusedKind::Taken, Asked::Run) => {
                let until = now.after(STOP_FOLLOWS);
                self.doing = Doing::Taken { until, last_look: false, why };
            }
            _ => return self.failed(why),
        }
        None
    }

    fn failed(&mut self, why: String) -> Option<Exit> {
        let continues = self.steps.get(self.next).is_some_and(|step| step.continues);
        self.next += 1;
        self.doing = Doing::Waits;
        if continues { None } else { Some(Exit::Failed(why)) }
    }

    fn about(&self, what: &str) -> String {
        let step = self.steps.get(self.next);
        let command = step.map(|step| format!("{} {}", step.gate, step.command));
        format!("step {} ({}): {what}", self.next + 1, command.unwrap_or_default())
    }

    fn poll(
        &mut self,
        attempt: Attempt,
        now: Instant,
        workers: &mut Workers,
        events: &mut Vec<Event>,
    ) -> Option<Exit> {
        match self.asked {
            Asked::Run => self.advance(attempt, now, workers),
            Asked::Pause { told } => {
                self.pause(attempt, told, events);
                None
            }
            Asked::End { deadline } => self.end(attempt, deadline, now, events),
        }
    }

    /// Does not wait for ever: for a response, or for the stop that explains a
    /// refusal.
    fn give_up(&mut self, now: Instant) -> Option<Exit> {
        match &mut self.doing {
            Doing::Commands { until: Some(until), .. } if *until <= now => {
                let why = self.about("no response within its declared time");
                self.failed(why)
            }
            // The turn may come late, and the stop in the same one: it asks for
            // tickets after bodies.
            Doing::Taken { until, last_look, .. } if *until <= now && !*last_look => {
                *last_look = true;
                None
            }
            Doing::Taken { until, why, .. } if *until <= now => {
                let why = why.clone();
                self.failed(why)
            }
            _ => None,
        }
    }

    fn advance(&mut self, attempt: Attempt, now: Instant, workers: &mut Workers) -> Option<Exit> {
        if !matches!(self.doing, Doing::Waits) {
            return None;
        }
        let Some(step) = self.steps.get(self.next) else { return Some(Exit::Code(0)) };
        if self.watch.comes_to(step.offset).is_none_or(|due| due > now) {
            return None;
        }
        let wcet = workers.commands().wcet(&step.gate, &step.command);
        match workers.give(Call::Command(attempt, step.clone())) {
            Ok(worker) => {
                let until = wcet.map(|wcet| now.after(wcet));
                self.doing = Doing::Commands { worker, until };
                None
            }
            Err(why) => Some(Exit::Failed(self.about(&why))),
        }
    }

    /// A command in progress is heard first: its answer belongs to this side of
    /// the pause.
    fn pause(&mut self, attempt: Attempt, told: bool, events: &mut Vec<Event>) {
        if matches!(self.doing, Doing::Taken { .. }) {
            self.doing = Doing::Waits;
        }
        if matches!(self.doing, Doing::Waits) && !told {
            self.asked = Asked::Pause { told: true };
            events.push(Event::Stopped { attempt });
        }
    }

    fn end(
        &mut self,
        attempt: Attempt,
        deadline: Option<Instant>,
        now: Instant,
        events: &mut Vec<Event>,
    ) -> Option<Exit> {
        if !matches!(self.doing, Doing::Commands { .. }) {
            return Some(TERMINATED);
        }
        if deadline.is_some_and(|deadline| deadline <= now) {
            self.asked = Asked::End { deadline: None };
            events.push(Event::Runaway { attempt });
        }
        None
    }

    fn due(&self) -> Option<Instant> {
        let given_up = match &self.doing {
            Doing::Commands { until, .. } => *until,
            Doing::Taken { until, .. } => Some(*until),
            Doing::Waits => None,
        };
        let asked = match self.asked {
            Asked::End { deadline } => deadline,
            Asked::Run if matches!(self.doing, Doing::Waits) => {
                let offset = self.steps.get(self.next).map(|step| step.offset);
                self.watch.comes_to(offset.unwrap_or_default())
            }
            Asked::Run | Asked::Pause { .. } => None,
        };
        given_up.into_iter().chain(asked).min()
    }
}
