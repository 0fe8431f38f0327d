//! Exact amounts. Integers in newtypes: after any history of charges and
//! credits a margin is back where it began, to the unit.

use core::fmt;

macro_rules! amount {
    ($(#[$doc:meta])* $name:ident, $unit:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(u64);

        impl $name {
            /// Nothing.
            pub const ZERO: Self = Self(0);

            /// The amount in its own unit.
            #[must_use]
            pub const fn new(units: u64) -> Self {
                Self(units)
            }

            /// The number of units.
            #[must_use]
            pub const fn get(self) -> u64 {
                self.0
            }

            /// Whether there is nothing of it.
            #[must_use]
            pub const fn is_zero(self) -> bool {
                self.0 == 0
            }

            /// The sum, or the largest amount where it would not fit.
            #[must_use]
            pub const fn saturating_add(self, other: Self) -> Self {
                Self(self.0.saturating_add(other.0))
            }

            /// The difference, or nothing where `other` is the larger.
            #[must_use]
            pub const fn saturating_sub(self, other: Self) -> Self {
                Self(self.0.saturating_sub(other.0))
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!("{} ", $unit), self.0)
            }
        }
    };
}

amount!(
    /// Electrical power, in milliwatts.
    Milliwatts,
    "mW"
);
amount!(
    /// Energy, in microjoules.
    Microjoules,
    "uJ"
);
amount!(
    /// Mass of propellant, in milligrams.
    Milligrams,
    "mg"
);
amount!(
    /// Flow of propellant, in milligrams per second.
    MilligramsPerSecond,
    "mg/s"
);

impl Milliwatts {
    /// Whole watts.
    #[must_use]
    pub const fn from_watts(watts: u32) -> Self {
        // A u32 times 1000 always fits in a u64.
        Self(watts as u64 * 1000)
    }
}

impl Microjoules {
    /// Whole joules.
    #[must_use]
    pub const fn from_joules(joules: u32) -> Self {
        Self(joules as u64 * 1_000_000)
    }
}
