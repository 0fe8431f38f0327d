//! Exact amounts. Integers in newtypes: after any history of charges and
//! credits a margin is back where it began, to the unit.

use core::fmt;

macro_rules! amount {
    ($(#[$doc:meta])* $name:ident, $($size:literal $unit:literal),+) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
            /// Exact, in the largest unit that leaves a whole number.
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                for (size, unit) in [$(($size, $unit)),+] {
                    if self.0.is_multiple_of(size) && self.0 >= size {
                        return write!(f, "{} {unit}", self.0 / size);
                    }
                }
                f.write_str("none")
            }
        }
    };
}

amount!(
    /// Electrical power, in milliwatts.
    Milliwatts,
    1_000 "W",
    1 "mW"
);
amount!(
    /// Energy, in microjoules.
    Microjoules,
    1_000_000 "J",
    1_000 "mJ",
    1 "uJ"
);
amount!(
    /// Mass of propellant, in milligrams.
    Milligrams,
    1_000_000 "kg",
    1_000 "g",
    1 "mg"
);
amount!(
    /// Flow of propellant, in milligrams per second.
    MilligramsPerSecond,
    1_000 "g/s",
    1 "mg/s"
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

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn an_amount_is_shown_exactly_in_the_largest_unit_that_fits() {
        assert_eq!(Milliwatts::from_watts(45).to_string(), "45 W");
        assert_eq!(Milliwatts::new(1_500).to_string(), "1500 mW");
        assert_eq!(Microjoules::new(25_001_000).to_string(), "25001 mJ");
        assert_eq!(Milligrams::ZERO.to_string(), "none");
    }
}
