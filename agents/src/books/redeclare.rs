//! A device that is declared anew: another draw, other categories and times.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Power, Profile};
use faregate_tickets::id::GateId;

use crate::policy::Categories;
use crate::refusal::NotRedeclared;

use super::device::{DeviceBook, Phase};
use super::{Books, bit};

/// What is declared of a device from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Redeclared {
    /// Its largest draw.
    pub draw: Milliwatts,
    /// Its conflict categories.
    pub categories: Categories,
    /// How long after its safing command it is what it was told to be.
    pub settling: Duration,
    /// How long after settling a state estimate measured then has arrived.
    pub estimate_lag: Duration,
}

impl Redeclared {
    fn of(self, profile: Profile) -> Profile {
        let Self { draw, settling, estimate_lag, .. } = self;
        Profile { draw, settling, estimate_lag, ..profile }
    }
}

impl<const G: usize, const T: usize, const S: usize> Books<G, T, S> {
    /// Declares a device anew. Nothing is decided: nobody has it or asks for it,
    /// and nothing is charged for it, before and after.
    ///
    /// # Errors
    /// [`NotRedeclared`], and the books are as they were.
    ///
    /// # Timing
    /// One look at each seat.
    pub fn redeclare(&mut self, gate: GateId, declared: &Redeclared) -> Result<(), NotRedeclared> {
        let device = self.device(gate).ok_or(NotRedeclared::UnknownGate)?;
        // Who asked was told what it asks for, and has its lease by it.
        if let Some(ticket) = self.named_by(gate) {
            return Err(NotRedeclared::Requested { by: ticket });
        }
        if !self.is_known_off(device) {
            return Err(NotRedeclared::MayBeOn);
        }
        if let Some(device) = self.device_mut(gate) {
            device.profile = declared.of(device.profile);
            device.categories = declared.categories;
        }
        Ok(())
    }

    fn named_by(&self, gate: GateId) -> Option<faregate_tickets::id::TicketId> {
        (0..).zip(&self.grants).find_map(|(seat, grant)| {
            let names = grant.serial != 0 && grant.gates & bit(gate) != 0;
            names.then(|| grant.id(seat))
        })
    }

    /// Whether it draws nothing. One that was not charged until now counts as
    /// off without having been seen off: that is not enough, or the new charge
    /// would begin too late (**Margin Kept**).
    fn is_known_off(&self, device: &DeviceBook) -> bool {
        let seen_off = device
            .seen
            .is_some_and(|seen| seen.state == Power::Off && seen.measured_at > device.counts_from);
        device.phase == Phase::Off && (self.is_charged(device) || seen_off)
    }
}
