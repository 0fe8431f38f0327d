//! Where an activity starts if it can, instead of at its earliest start.
//!
//! The earliest start is not the cheapest: it may wake the computer up for one
//! activity that fits as well into time in which the computer is up anyway.

use crate::timeline::Intervals;
use crate::units::Time;

use super::Pass;

/// Which of its valid starts an activity takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Leaning {
    /// The earliest.
    Earliest,
    /// The earliest in time in which the computer is up anyway, if there is one.
    Awake,
    /// The earliest from then on, if there is one.
    NotBefore(i64),
}

impl Pass<'_> {
    /// What an activity leans to of these starts; none: to the earliest.
    pub(super) fn leant(&self, item: usize, starts: &Intervals) -> Option<Intervals> {
        let leant = match self.leanings[item] {
            Leaning::Earliest => return None,
            Leaning::NotBefore(at) => Intervals::between(Time::new(at), Time::new(i64::MAX)),
            Leaning::Awake => {
                let length = self.problem.items[item].shortest;
                let phases = self.world.phases.iter();
                let long = phases.filter(|phase| phase.down.at - phase.up.at >= length);
                Intervals::of(
                    long.map(|phase| (Time::new(phase.up.at), Time::new(phase.down.at - length))),
                )
            }
        };
        let leant = leant.intersection(starts);
        (!leant.is_empty()).then_some(leant)
    }
}
