//! Time and fractions as integers. Power, energy and data are
//! [`Milliwatts`](faregate_tickets::amount::Milliwatts),
//! [`Microjoules`](faregate_tickets::amount::Microjoules) and [`Bytes`]: a
//! milliwatt for a millisecond is a microjoule, so nothing is ever rounded.

use core::fmt;

use serde::{Deserialize, Serialize};

macro_rules! integer {
    ($(#[$doc:meta])* $name:ident($raw:ty)) => {
        $(#[$doc])*
        #[derive(
            Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
        )]
        #[serde(transparent)]
        pub struct $name($raw);

        impl $name {
            /// None of it; for an instant, the origin.
            pub const ZERO: Self = Self(0);

            /// So many units.
            #[must_use]
            pub const fn new(units: $raw) -> Self {
                Self(units)
            }

            /// The number of units.
            #[must_use]
            pub const fn get(self) -> $raw {
                self.0
            }
        }
    };
}

integer! {
    /// An instant: milliseconds from the origin that the plan, the parameters
    /// and the state share.
    Time(i64)
}

integer! {
    /// A length of time, in milliseconds.
    Span(i64)
}

integer! {
    /// Bytes of data; negative where a downlink frees them.
    Bytes(i64)
}

integer! {
    /// Millionths of the battery's capacity.
    Ppm(i64)
}

impl Time {
    /// The instant `span` later.
    #[must_use]
    pub const fn after(self, span: Span) -> Self {
        Self(self.0.saturating_add(span.0))
    }

    /// The instant `span` earlier.
    #[must_use]
    pub const fn before(self, span: Span) -> Self {
        Self(self.0.saturating_sub(span.0))
    }

    /// The time since `earlier`: negative where that is the later one.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Span {
        Span(self.0.saturating_sub(earlier.0))
    }
}

impl Span {
    /// So many seconds.
    #[must_use]
    pub const fn from_secs(s: i64) -> Self {
        Self(s.saturating_mul(1_000))
    }

    /// So many minutes.
    #[must_use]
    pub const fn from_mins(min: i64) -> Self {
        Self::from_secs(min.saturating_mul(60))
    }
}

fn seconds(ms: i64, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let sign = if ms < 0 { "-" } else { "" };
    let (s, ms) = (ms.unsigned_abs() / 1_000, ms.unsigned_abs() % 1_000);
    match ms {
        0 => write!(f, "{sign}{s} s"),
        ms => write!(f, "{sign}{s}.{ms:03} s"),
    }
}

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        seconds(self.0, f)
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        seconds(self.0, f)
    }
}

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} B", self.0)
    }
}

impl fmt::Display for Ppm {
    /// In percent, exact.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let (whole, rest) = (self.0.unsigned_abs() / 10_000, self.0.unsigned_abs() % 10_000);
        match rest {
            0 => write!(f, "{sign}{whole} %"),
            rest => write!(f, "{sign}{} %", format!("{whole}.{rest:04}").trim_end_matches('0')),
        }
    }
}
