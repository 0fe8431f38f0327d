//! What goes wrong with a rover, as values.

use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::Instant;

use super::model::WindowModel;

/// Something goes wrong, or is otherwise than planned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RoverFault {
    /// A zone's heater does nothing.
    HeaterDead {
        /// Which zone.
        zone: usize,
        /// From then.
        from: Instant,
        /// Until then.
        until: Instant,
    },
    /// The gauge and the thermometers say nothing new.
    SensorsSilent {
        /// From then.
        from: Instant,
        /// Until then.
        until: Instant,
    },
    /// Something draws that nobody planned.
    Drain {
        /// From then.
        from: Instant,
        /// Until then.
        until: Instant,
        /// So much.
        load: Milliwatts,
    },
    /// The battery has lost so much at once.
    Discharge {
        /// When.
        at: Instant,
        /// How much.
        energy: Microjoules,
    },
    /// An onboard variable changes.
    Variable {
        /// When.
        at: Instant,
        /// Its name.
        name: String,
        /// Its value; none: nobody knows it any more.
        value: Option<i64>,
    },
    /// A communication window that has not opened is moved or replaced; none:
    /// it is cancelled.
    Window {
        /// When that becomes known.
        at: Instant,
        /// Which window.
        index: usize,
        /// What it is from then on.
        becomes: Option<WindowModel>,
    },
}

/// All that goes wrong in one simulation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RoverScript(pub Vec<RoverFault>);

impl RoverScript {
    /// When something of it begins or ends next.
    pub(crate) fn next_after(&self, now: Instant) -> Option<Instant> {
        self.0.iter().flat_map(RoverFault::instants).filter(|at| *at > now).min()
    }

    /// What happens at exactly this instant.
    pub(crate) fn at(&self, now: Instant) -> impl Iterator<Item = &RoverFault> {
        self.0.iter().filter(move |fault| fault.instants().contains(&now))
    }

    pub(crate) fn heater_is_dead(&self, zone: usize, now: Instant) -> bool {
        self.0.iter().any(|fault| {
            matches!(fault, RoverFault::HeaterDead { zone: dead, from, until }
                if *dead == zone && *from <= now && now < *until)
        })
    }

    pub(crate) fn is_silent(&self, now: Instant) -> bool {
        self.0.iter().any(|fault| {
            matches!(fault, RoverFault::SensorsSilent { from, until }
                if *from <= now && now < *until)
        })
    }

    pub(crate) fn drain(&self, now: Instant) -> Milliwatts {
        let drains = self.0.iter().filter_map(|fault| match fault {
            RoverFault::Drain { from, until, load } if *from <= now && now < *until => Some(*load),
            _ => None,
        });
        drains.fold(Milliwatts::ZERO, Milliwatts::saturating_add)
    }
}

impl RoverFault {
    fn instants(&self) -> [Instant; 2] {
        match self {
            Self::HeaterDead { from, until, .. }
            | Self::SensorsSilent { from, until }
            | Self::Drain { from, until, .. } => [*from, *until],
            Self::Discharge { at, .. } | Self::Variable { at, .. } | Self::Window { at, .. } => {
                [*at, *at]
            }
        }
    }
}
