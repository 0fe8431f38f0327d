//! The laws that a flight must not break.

use std::fmt;

use faregate_tickets::amount::Milliwatts;

/// How a spacecraft was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Law {
    /// More was drawn than the supply gives, for longer than the bus bears.
    BusTripped {
        /// What was drawn.
        draw: Milliwatts,
        /// What there was.
        supply: Milliwatts,
    },
    /// Heaters and thruster valve drew more than the propulsion converter gives.
    PropulsionTripped {
        /// What was drawn.
        draw: Milliwatts,
        /// What there was.
        supply: Milliwatts,
    },
    /// It spins too fast to be brought back.
    SpunUp {
        /// The rate, in microradians per second.
        rate_urad_s: u64,
    },
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BusTripped { draw, supply } => {
                write!(f, "the bus tripped: {draw} drawn, {supply} supplied")
            }
            Self::PropulsionTripped { draw, supply } => {
                write!(f, "the propulsion converter tripped: {draw} drawn, {supply} supplied")
            }
            Self::SpunUp { rate_urad_s } => {
                write!(
                    f,
                    "spun up beyond recovery: {}.{:03} rad/s",
                    rate_urad_s / 1_000_000,
                    rate_urad_s / 1_000 % 1_000
                )
            }
        }
    }
}
