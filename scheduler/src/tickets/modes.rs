//! Modes that take gates from everybody.

use std::collections::BTreeMap;

use faregate_runtime::{Broker, Ticket};
use faregate_tickets::clock::Duration;
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use faregate_tickets::validity::Function;

use super::authority::Shared;
use super::driver::GateDevice;

/// How long the first of a gate's two tickets is good for.
const AT_ONCE: Duration = Duration::from_micros(1);

/// The gates that modes have, each by two tickets. The lease of the first ends
/// as soon as it is granted, and a device whose lease has ended is made safe
/// before anybody else has it: so the second one is granted for a device that is
/// off, and keeps it so until the mode is left.
#[derive(Debug, Default)]
pub(super) struct Modes(BTreeMap<String, Vec<Ticket<GateDevice>>>);

impl Modes {
    pub(super) fn enter(&mut self, mode: &str, gates: &[String], broker: &Broker, shared: &Shared) {
        let mut tickets = Vec::new();
        for gate in gates.iter().filter_map(|gate| shared.gates.get(gate)) {
            for lease in [AT_ONCE, Duration::MAX] {
                let want = gate.handle.limited(Function::lease(lease));
                let ticket = match broker.request(Priority::FAULT_RESPONSE, &want) {
                    Ok(ticket) => ticket,
                    Err(refused) => {
                        // There are seats kept for this priority.
                        tracing::error!(mode, gate = gate.name, %refused, "not reserved");
                        continue;
                    }
                };
                shared.names.call(ticket.id(), format!("mode {mode}"));
                tickets.push(ticket);
            }
        }
        self.0.insert(mode.to_owned(), tickets);
    }

    pub(super) fn leave(&mut self, mode: &str) {
        self.0.remove(mode);
    }

    /// The first tickets have done their work.
    pub(super) fn settle(&mut self) {
        let ended =
            |ticket: &Ticket<GateDevice>| ticket.check() == Err(Refusal::NotValid(Why::Expired));
        for tickets in self.0.values_mut() {
            tickets.retain(|ticket| !ended(ticket));
        }
    }
}
