//! The tickets of one activity.

use faregate_devices_sim::rover::RoverCommand;
use faregate_tickets::refusal::Refusal;

use super::{PlaceTicket, SwitchTicket};

pub(crate) struct Seat<'b, 'g> {
    pub(crate) place: usize,
    pub(super) ticket: PlaceTicket<'b, 'g>,
    pub(super) devices: Vec<(usize, SwitchTicket<'b, 'g>)>,
    pub(crate) state: SeatState,
}

/// What was found when it was looked at last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SeatState {
    Waits,
    /// Granted, after so many revocations.
    Granted(usize),
    Taken,
}

/// What has become of a seat since it was looked at last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    Granted,
    Taken,
    Returned,
}

impl Seat<'_, '_> {
    pub(crate) fn check(&self) -> Result<(), Refusal> {
        self.ticket.check()
    }

    /// Whether it was granted, as far as was looked, and still is.
    pub(crate) fn is_granted(&self) -> bool {
        matches!(self.state, SeatState::Granted(_)) && self.check().is_ok()
    }

    /// Looks again. What was taken and came back in between was taken first:
    /// that it came back is found at the next look.
    pub(crate) fn turn(&mut self) -> Option<Turn> {
        let (valid, revocations) = (self.check().is_ok(), self.ticket.revocations());
        let (state, turn) = match self.state {
            SeatState::Waits if valid => (SeatState::Granted(revocations), Turn::Granted),
            SeatState::Taken if valid => (SeatState::Granted(revocations), Turn::Returned),
            SeatState::Granted(then) if !valid || then != revocations => {
                (SeatState::Taken, Turn::Taken)
            }
            _ => return None,
        };
        self.state = state;
        Some(turn)
    }

    /// Gives each device a command. Whether all of them took it.
    pub(crate) fn command(&self, command: RoverCommand) -> bool {
        let took = self.devices.iter().map(|(_, ticket)| ticket.invoke(command).is_ok());
        !took.fold(false, |refused, took| refused | !took)
    }

    /// Whether every ticket refuses.
    pub(crate) fn refuses(&self) -> bool {
        let mut tickets = self.devices.iter().map(|(_, ticket)| ticket);
        self.check().is_err() && tickets.all(|ticket| ticket.invoke(RoverCommand::On).is_err())
    }
}
