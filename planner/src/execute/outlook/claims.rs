//! Who holds what, and when: resource bits, engines, power.

use crate::parameters::Parameters;
use crate::plan::Activity;
use crate::state::Window;
use crate::timed::{Limit, Preheat, Slot};
use crate::units::Time;

/// Something is held for a time: half-open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim {
    from: Time,
    to: Time,
    bits: u128,
    engines: u64,
    peak: u64,
}

impl Claim {
    pub(super) fn of(activity: &Activity, slot: Slot) -> Self {
        Self {
            from: slot.start,
            to: slot.end,
            bits: activity.resources.mask(),
            engines: activity.engines.into(),
            peak: activity.peak.get(),
        }
    }

    pub(super) fn of_window(window: &Window) -> Self {
        Self {
            from: window.start,
            to: window.end,
            bits: window.resources.mask(),
            engines: window.engines.into(),
            peak: window.peak.get(),
        }
    }

    pub(super) fn of_heating(heating: &Preheat, parameters: &Parameters) -> Option<Self> {
        let zone = parameters.zones.iter().find(|zone| zone.name == heating.zone)?;
        let (from, to) = (heating.start, heating.end);
        Some(Self { from, to, bits: 0, engines: 0, peak: zone.load.peak.get() })
    }

    fn holds_at(&self, at: Time) -> bool {
        self.from <= at && at < self.to
    }
}

/// Whether all of them fit. The end may overlap by the tolerance: a start that
/// was late by so much is worth it, and the agents make whoever comes next wait.
pub(super) fn beside(mine: &Claim, others: &[Claim], parameters: &Parameters) -> Result<(), Limit> {
    let from = mine.from;
    let to =
        mine.to.before(parameters.handover_tolerance).max(from.after(crate::units::Span::new(1)));
    let meets = |other: &&Claim| other.from < to && from < other.to;
    let shared = others.iter().filter(meets).fold(0, |bits, other| bits | other.bits & mine.bits);
    if shared != 0 {
        return Err(Limit::Resources(shared));
    }
    let begins = others.iter().map(|other| other.from).filter(|at| from < *at && *at < to);
    for at in begins.chain([from]) {
        let held = others.iter().filter(|other| other.holds_at(at));
        let (engines, peak) = held.fold((mine.engines, mine.peak), |(engines, peak), other| {
            (engines.saturating_add(other.engines), peak.saturating_add(other.peak))
        });
        // The computer is up: its part is never missing.
        if peak.saturating_add(parameters.awake.peak.get()) > parameters.peak_limit.get() {
            return Err(Limit::Peak);
        }
        if engines > parameters.engines.into() {
            return Err(Limit::Engines);
        }
    }
    Ok(())
}
