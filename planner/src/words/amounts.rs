//! Amounts in units that people use: cut to a digit that says enough, away from
//! zero, so that what is missing is never said to be less.

use crate::timed::Limit;
use crate::units::Ppm;

/// How far a limit is exceeded, in its unit.
#[must_use]
pub fn amount(limit: &Limit, by: i64) -> String {
    match limit {
        Limit::SoftMinimum | Limit::Handover => energy(by),
        Limit::Data => bytes(by),
        Limit::Peak => power(by),
        Limit::Engines if by == 1 => "1 sequence engine".into(),
        Limit::Engines => format!("{by} sequence engines"),
        Limit::Computer | Limit::Lead | Limit::Range => span(by),
        Limit::Resources(_) | Limit::Timeline(_) | Limit::Dependency => by.to_string(),
    }
}

/// Microjoules: watt-hours with one digit, or joules where that is nothing.
#[must_use]
pub fn energy(uj: i64) -> String {
    const WATT_HOUR: u64 = 3_600_000_000;
    match uj.unsigned_abs() {
        0 => "0 Wh".into(),
        tenths if tenths >= WATT_HOUR / 10 => said(uj, WATT_HOUR, 1, "Wh"),
        _ => said(uj, 1_000_000, 3, "J"),
    }
}

/// Milliwatts as watts, exact.
#[must_use]
pub fn power(mw: i64) -> String {
    said(mw, 1_000, 3, "W")
}

/// Bytes, in the largest unit that leaves something before the point.
#[must_use]
pub fn bytes(bytes: i64) -> String {
    match bytes.unsigned_abs() {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => said(bytes, 1_000, 1, "kB"),
        1_000_000..1_000_000_000 => said(bytes, 1_000_000, 1, "MB"),
        _ => said(bytes, 1_000_000_000, 2, "GB"),
    }
}

/// Milliseconds, in hours, minutes and seconds.
#[must_use]
pub fn span(ms: i64) -> String {
    let sign = if ms < 0 { "-" } else { "" };
    let ms = ms.unsigned_abs();
    let (hours, minutes) = (ms / 3_600_000, ms / 60_000 % 60);
    let mut parts = Vec::new();
    if hours > 0 {
        parts.push(format!("{hours} h"));
    }
    if minutes > 0 {
        parts.push(format!("{minutes} min"));
    }
    match ms % 60_000 {
        0 if !parts.is_empty() => {}
        below if below % 1_000 == 0 => parts.push(format!("{} s", below / 1_000)),
        below => parts.push(format!("{}.{:03} s", below / 1_000, below % 1_000)),
    }
    format!("{sign}{}", parts.join(" "))
}

/// A charge in percent of a capacity, with one digit, rounded down as charges
/// are.
#[must_use]
pub fn percent(charge: i64, capacity: u64) -> String {
    let permille = (i128::from(charge) * 1_000).div_euclid(i128::from(capacity.max(1)));
    let ppm = i64::try_from(permille).unwrap_or(i64::MAX / 1_000).saturating_mul(1_000);
    Ppm::new(ppm).to_string()
}

/// In this unit, with at most so many digits below the point.
fn said(amount: i64, unit: u64, digits: u32, name: &str) -> String {
    let sign = if amount < 0 { "-" } else { "" };
    let parts = 10_u128.pow(digits);
    let scaled = (u128::from(amount.unsigned_abs()) * parts).div_ceil(u128::from(unit));
    let (whole, below) = (scaled / parts, scaled % parts);
    let width = usize::try_from(digits).unwrap_or(0);
    let below = format!("{below:0width$}");
    match below.trim_end_matches('0') {
        "" => format!("{sign}{whole} {name}"),
        below => format!("{sign}{whole}.{below} {name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_never_said_to_be_less() {
        assert_eq!(energy(3_600_000_001), "1.1 Wh");
        assert_eq!(energy(1), "0.001 J");
        assert_eq!(energy(-36_000_000_000), "-10 Wh");
        assert_eq!(bytes(1_000_001), "1.1 MB");
        assert_eq!(power(1), "0.001 W");
        assert_eq!(bytes(i64::MIN), "-9223372036.86 GB");
    }

    #[test]
    fn a_span_is_said_in_the_units_of_a_clock() {
        assert_eq!(span(0), "0 s");
        assert_eq!(span(15_000_000), "4 h 10 min");
        assert_eq!(span(-90_250), "-1 min 30.250 s");
    }

    #[test]
    fn a_charge_is_rounded_down() {
        assert_eq!(percent(1_999, 2_000), "99.9 %");
        assert_eq!(percent(-1, 2_000), "-0.1 %");
    }
}
