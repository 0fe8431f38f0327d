//! What people are told: tickets are called by whose they are.

use std::collections::BTreeMap;

use faregate_agents::Waiting;
use faregate_tickets::id::TicketId;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use parking_lot::Mutex;

use super::gates::Gates;

/// How many tickets' names are remembered: who took something may be gone when
/// it is asked after.
const REMEMBERED: usize = 4096;

/// Whose each ticket is, or was: a task's or a mode's.
#[derive(Debug, Default)]
pub(super) struct Names(Mutex<BTreeMap<usize, String>>);

impl Names {
    pub(super) fn call(&self, ticket: TicketId, name: String) {
        let mut names = self.0.lock();
        names.insert(ticket.serial, name);
        if names.len() > REMEMBERED {
            // Serials grow: the first is the oldest.
            names.pop_first();
        }
    }

    /// Whose ticket it is, if it is one of ours.
    pub(super) fn of(&self, ticket: TicketId) -> Option<String> {
        self.0.lock().get(&ticket.serial).cloned()
    }

    fn called(&self, ticket: TicketId) -> String {
        self.of(ticket).unwrap_or_else(|| ticket.to_string())
    }

    /// Who took the tickets, or why they went.
    pub(super) fn taker(&self, refusal: Refusal) -> String {
        match refusal {
            Refusal::NotValid(Why::Preempted { by, priority }) => {
                self.of(by).unwrap_or_else(|| format!("{by} at {priority}"))
            }
            Refusal::NotValid(why) => why.to_string(),
            Refusal::RevokedAll { .. } => "safe mode".to_owned(),
            other => other.to_string(),
        }
    }

    /// Who took the tickets, where somebody did.
    pub(super) fn taken_by(&self, refusal: Refusal) -> Option<String> {
        let is_taken = matches!(
            refusal,
            Refusal::NotValid(Why::Preempted { .. }) | Refusal::RevokedAll { .. }
        );
        is_taken.then(|| self.taker(refusal))
    }

    /// Why a command was refused.
    pub(super) fn refused(&self, refusal: Refusal) -> String {
        match refusal {
            Refusal::NotValid(Why::Preempted { by, priority }) => {
                let by = self.called(by);
                format!("the ticket is not valid: taken by {by} at {priority}")
            }
            other => other.to_string(),
        }
    }

    /// What a request waits for.
    pub(super) fn waiting(&self, waiting: Waiting, gates: &Gates) -> String {
        match waiting {
            Waiting::Gate { gate, by } => {
                format!("{} is taken by {}", gates.called(gate), self.called(by))
            }
            Waiting::Categories { shared, by: Some(by) } => {
                format!("categories {shared} are used by {}", self.called(by))
            }
            Waiting::Exclusive { by } => {
                format!("its agent allows one ticket at a time: {}", self.called(by))
            }
            Waiting::Faulted { gate, fault } => {
                format!("{} is faulted: {fault}", gates.called(gate))
            }
            other => other.to_string(),
        }
    }
}
