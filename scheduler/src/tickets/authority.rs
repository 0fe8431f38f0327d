//! Commands on an occurrence's tickets, from any thread.
//!
//! What decides is the ticket: when it has gone, it refuses (*Closed Door*),
//! whatever is said here. The lock around it only keeps two workers of one task
//! from using it at the same time.

use core::fmt;
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use faregate_runtime::Ticket;
use faregate_tickets::refusal::{InvokeError, Refusal};
use faregate_tickets::standing::Why;
use parking_lot::{Mutex, RwLock};

use super::driver::{GateCommand, GateDevice};
use super::gates::Gates;
use super::names::Names;
use crate::executive::{CommandRefused, Commands, RefusedKind};
use crate::manager::{Attempt, Occurrence};
use crate::time::Duration;

/// What the port and the workers share.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) gates: Gates,
    pub(super) names: Names,
    authorities: RwLock<HashMap<Occurrence, Arc<Authority>>>,
}

impl Shared {
    pub(super) fn new(gates: Gates) -> Self {
        Self { gates, names: Names::default(), authorities: RwLock::default() }
    }

    pub(super) fn give(&self, occurrence: Occurrence, authority: Arc<Authority>) {
        self.authorities.write().insert(occurrence, authority);
    }

    pub(super) fn end(&self, occurrence: Occurrence) {
        self.authorities.write().remove(&occurrence);
    }
}

/// The tickets of one occurrence for devices. They are given back when the last
/// one who uses them has let go: a worker inside a slow command holds up nobody.
pub(super) struct Authority {
    /// The attempt whose commands count; 0 for none.
    attempt: AtomicU32,
    /// Who took the tickets, where the tickets themselves cannot say it.
    taken_by: Mutex<Option<String>>,
    tickets: Vec<DeviceTicket>,
}

struct DeviceTicket {
    gate: String,
    ticket: Mutex<Ticket<GateDevice>>,
    /// The manager wanted to renew it while it was in use.
    renewal_due: AtomicBool,
}

impl Authority {
    pub(super) fn new(tickets: impl Iterator<Item = (String, Ticket<GateDevice>)>) -> Self {
        let tickets = tickets.map(|(gate, ticket)| DeviceTicket {
            gate,
            ticket: Mutex::new(ticket),
            renewal_due: AtomicBool::new(false),
        });
        Self { attempt: AtomicU32::new(0), taken_by: Mutex::default(), tickets: tickets.collect() }
    }

    /// Whose commands count from now on; 0 for nobody's.
    pub(super) fn serve(&self, attempt: u32) {
        self.attempt.store(attempt, Ordering::Release);
    }

    pub(super) fn attempt(&self) -> u32 {
        self.attempt.load(Ordering::Acquire)
    }

    pub(super) fn taken_by(&self, taker: Option<String>) {
        *self.taken_by.lock() = taker;
    }

    pub(super) fn has_devices(&self) -> bool {
        !self.tickets.is_empty()
    }

    pub(super) fn gates(&self) -> impl Iterator<Item = &str> {
        self.tickets.iter().map(|device| device.gate.as_str())
    }

    /// Renews all leases. One that is in use is renewed by whoever uses it.
    pub(super) fn renew(&self) {
        for device in &self.tickets {
            device.renewal_due.store(true, Ordering::Release);
            device.renew_if_due();
        }
    }
}

impl DeviceTicket {
    fn renew_if_due(&self) {
        while self.renewal_due.load(Ordering::Acquire) {
            // Who is inside looks again after it has left: one of the two sees
            // the mark.
            let Some(ticket) = self.ticket.try_lock() else { return };
            self.renewal_due.store(false, Ordering::Release);
            // A ticket that is not valid has no lease that runs.
            let _ = ticket.renew();
        }
    }
}

impl fmt::Debug for Authority {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gates: Vec<_> = self.tickets.iter().map(|device| &device.gate).collect();
        f.debug_struct("Authority").field("gates", &gates).finish_non_exhaustive()
    }
}

/// Commands the devices of a mission by name, each on the tickets of the
/// occurrence that asks. Clones are the same.
#[derive(Clone, Debug)]
pub struct Commander(pub(super) Arc<Shared>);

impl Commander {
    /// The gates, by name.
    #[must_use]
    pub fn gates(&self) -> &Gates {
        &self.0.gates
    }

    fn authority(&self, attempt: Attempt) -> Result<Arc<Authority>, CommandRefused> {
        let found = self.0.authorities.read().get(&attempt.occurrence).cloned();
        found.ok_or_else(|| over(attempt))
    }

    fn refused(&self, authority: &Authority, refusal: Refusal) -> CommandRefused {
        let kind = match refusal {
            Refusal::Denied(_) => RefusedKind::NotNow,
            Refusal::Faulted(_) | Refusal::Reentered => RefusedKind::Fault,
            Refusal::Undeclared => RefusedKind::BadCommand,
            _ => RefusedKind::Taken,
        };
        let chosen = authority.taken_by.lock().clone();
        let (reason, taken_by) = match (refusal, chosen) {
            (Refusal::NotValid(Why::NotYetGranted), Some(by)) => {
                (format!("the ticket is not valid: taken by {by}"), Some(by))
            }
            _ => (self.0.names.refused(refusal), self.0.names.taken_by(refusal)),
        };
        CommandRefused { kind, reason, taken_by }
    }
}

impl Commands for Commander {
    fn command(
        &self,
        attempt: Attempt,
        gate: &str,
        command: &str,
        arguments: &[String],
    ) -> Result<String, CommandRefused> {
        let named = self.0.gates.get(gate).ok_or_else(|| no_such_gate(gate, &self.0.gates))?;
        let authority = self.authority(attempt)?;
        let device = authority.tickets.iter().find(|device| device.gate == gate);
        let device = device.ok_or_else(|| not_its_gate(attempt, gate))?;
        let parsed = named.parse(command, arguments);
        let command = parsed.map_err(|why| {
            CommandRefused::new(RefusedKind::BadCommand, format!("{gate}: {why}"))
        })?;
        let done = invoke(device, &authority, attempt, command);
        device.renew_if_due();
        match done {
            None => Err(over(attempt)),
            Some(Ok(reply)) => Ok(reply.to_string()),
            Some(Err(InvokeError::Refused(refusal))) => Err(self.refused(&authority, refusal)),
            Some(Err(InvokeError::Fault(fault))) => {
                Err(CommandRefused::new(RefusedKind::Fault, format!("{gate} failed: {fault}")))
            }
            Some(Err(InvokeError::Panicked)) => Err(CommandRefused::new(
                RefusedKind::Fault,
                format!("the driver of {gate} panicked"),
            )),
        }
    }

    fn wcet(&self, gate: &str, command: &str) -> Option<Duration> {
        self.0.gates.wcet(gate, command)
    }
}

type Invoked = Result<super::driver::Reply, InvokeError<super::driver::Fault>>;

/// `None`: the attempt was over when its turn came.
fn invoke(
    device: &DeviceTicket,
    authority: &Authority,
    attempt: Attempt,
    command: GateCommand,
) -> Option<Invoked> {
    let ticket = device.ticket.lock();
    (authority.attempt() == attempt.number).then(|| ticket.invoke(command))
}

fn over(attempt: Attempt) -> CommandRefused {
    CommandRefused::new(RefusedKind::Over, format!("{attempt} is over, or has no tickets"))
}

fn no_such_gate(gate: &str, gates: &Gates) -> CommandRefused {
    let known: Vec<_> = gates.names().collect();
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    CommandRefused::new(
        RefusedKind::NoSuchGate,
        format!("the mission has no gate `{gate}`; it has {known}"),
    )
}

fn not_its_gate(attempt: Attempt, gate: &str) -> CommandRefused {
    let task = attempt.occurrence.task;
    let reason = format!("{task} did not say that it commands `{gate}`: name it among its gates");
    CommandRefused::new(RefusedKind::NotItsGate, reason)
}
