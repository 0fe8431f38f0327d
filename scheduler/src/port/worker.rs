//! Issues the commands of one attempt, one after the other.

use core::sync::atomic::Ordering::Relaxed;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crossbeam::channel::Receiver;
use faregate_client::wire::Id;
use faregate_client::wire::command::Answer;
use faregate_client::{RefusalKind, Refused};
use parking_lot::Mutex;

use crate::executive::{CommandRefused, Commands, RefusedKind, Waker};
use crate::manager::Attempt;
use crate::port::beat::Beat;
use crate::port::connection::Connection;
use crate::port::counts::Counting;
use crate::port::entrance::{Entrance, Quiet};

/// What the threads share of one attempt.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) attempt: Attempt,
    pub(super) entrance: Entrance,
    /// Whether a heartbeat came since the manager's thread last asked.
    pub(super) beat: Beat,
    /// The gates that the attempt has commanded. Never locked by the manager's
    /// thread.
    pub(super) commanded: Mutex<BTreeSet<String>>,
}

impl Line {
    pub(super) fn new(attempt: Attempt) -> Self {
        Self { attempt, entrance: Entrance::new(), beat: Beat::new(), commanded: Mutex::default() }
    }
}

/// A command to be issued, and whom to answer.
pub(super) struct Errand {
    pub(super) from: Arc<Connection>,
    pub(super) id: Option<Id>,
    pub(super) gate: String,
    pub(super) command: String,
    pub(super) arguments: Vec<String>,
}

/// What a worker issues commands with.
pub(super) struct Tools {
    pub(super) commands: Arc<dyn Commands>,
    pub(super) manager: Waker,
    pub(super) counts: Arc<Counting>,
}

/// Until there are no more errands and nobody can send any.
pub(super) fn work(line: &Line, errands: &Receiver<Errand>, tools: &Tools) {
    for errand in errands {
        let outcome = issue(line, &errand, tools);
        let count = if outcome.is_ok() { &tools.counts.done } else { &tools.counts.refused };
        count.fetch_add(1, Relaxed);
        errand.from.answer(
            errand.id,
            match outcome {
                Ok(reply) => Answer::Done { reply },
                Err(why) => Answer::Refused(why),
            },
        );
    }
}

fn issue(line: &Line, errand: &Errand, tools: &Tools) -> Result<String, Refused> {
    let Some(inside) = line.entrance.enter() else { return Err(over(line.attempt)) };
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        tools.commands.command(line.attempt, &errand.gate, &errand.command, &errand.arguments)
    }));
    if inside.leave() == Quiet::Now {
        tools.manager.wake();
    }
    let reply = outcome.unwrap_or_else(|_| Err(panicked(&errand.gate))).map_err(told)?;
    line.commanded.lock().insert(errand.gate.clone());
    Ok(reply)
}

pub(super) fn over(attempt: Attempt) -> Refused {
    Refused::new(RefusalKind::Over, format!("{attempt} is over"))
}

/// The broker contains what drivers do; this is about whoever is between.
fn panicked(gate: &str) -> CommandRefused {
    let reason = format!("the command panicked on its way to {gate}: a defect of the manager");
    CommandRefused::new(RefusedKind::Fault, reason)
}

fn told(refused: CommandRefused) -> Refused {
    let kind = match refused.kind {
        RefusedKind::Taken => RefusalKind::Preempted,
        RefusedKind::Over => RefusalKind::Over,
        RefusedKind::NoSuchGate => RefusalKind::UnknownGate,
        RefusedKind::NotItsGate => RefusalKind::NotDeclared,
        RefusedKind::BadCommand => RefusalKind::BadArguments,
        RefusedKind::NotNow => RefusalKind::Limit,
        RefusedKind::Fault => RefusalKind::Faulted,
    };
    Refused { taker: refused.taken_by, ..Refused::new(kind, refused.reason) }
}
