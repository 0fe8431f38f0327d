//! Times as people write them on a command line.

use faregate_client::wire::control::{When, Window};
use faregate_scheduler::time::{Duration, UnixTime};
use jiff::Timestamp;

/// The time of day.
pub(crate) fn now() -> UnixTime {
    UnixTime::from_micros(Timestamp::now().as_microsecond())
}

/// Seconds with at most six decimals.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    micros(text)
        .map(Duration::from_micros)
        .ok_or_else(|| "expected seconds, such as 90 or 0.25".to_owned())
}

/// RFC 3339, or Unix seconds.
pub(crate) fn time(text: &str) -> Result<UnixTime, String> {
    if let Some(us) = micros(text).and_then(|us| i64::try_from(us).ok()) {
        return Ok(UnixTime::from_micros(us));
    }
    text.parse::<Timestamp>()
        .map(|time| UnixTime::from_micros(time.as_microsecond()))
        .map_err(|_| "expected a time, such as 2026-03-01T12:00:00Z or 1772366400".to_owned())
}

/// How many times faster.
pub(crate) fn speed(text: &str) -> Result<f64, String> {
    let speed: f64 = text.parse().map_err(|_| "expected a number, such as 60".to_owned())?;
    if speed.is_finite() && speed > 0.0 { Ok(speed) } else { Err("must be above 0".to_owned()) }
}

/// `st..et`; either end may be left out.
pub(crate) fn window(text: &str) -> Result<Window, String> {
    let (opens, closes) = text
        .split_once("..")
        .ok_or_else(|| "expected earliest..latest, such as +0..+600".to_owned())?;
    Ok(Window { opens: when(opens.trim())?, closes: when(closes.trim())? })
}

fn when(text: &str) -> Result<When, String> {
    if matches!(text, "" | "0") {
        return Ok(When::Unrestricted);
    }
    match text.strip_prefix('+') {
        Some(later) => Ok(When::AfterUs(seconds(later)?.as_micros())),
        None => Ok(When::UnixUs(time(text)?.as_micros())),
    }
}

/// A decimal number of seconds, in microseconds, digit by digit.
fn micros(text: &str) -> Option<u64> {
    let (whole, decimals) = text.split_once('.').unwrap_or((text, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(whole) || !digits(decimals) || decimals.len() > 6 {
        return None;
    }
    let below: u64 = format!("{decimals:0<6}").parse().ok()?;
    whole.parse::<u64>().ok()?.checked_mul(1_000_000)?.checked_add(below)
}

/// Microseconds as seconds with as many decimals as are wanted, at most six.
pub(crate) fn shown(us: u64, decimals: usize) -> String {
    let below = format!("{:06}", us % 1_000_000);
    format!("{}.{}", us / 1_000_000, &below[..decimals.clamp(1, 6)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_exact_to_the_microsecond_and_nothing_else_is_taken() {
        assert_eq!(seconds("0.000001"), Ok(Duration::from_micros(1)));
        assert_eq!(seconds("90"), Ok(Duration::from_secs(90)));
        for wrong in ["", ".", "1.", "-1", "1e3", "0.0000001", "99999999999999999999"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_window_has_two_ends_and_each_may_be_open() {
        let both = Window { opens: When::AfterUs(1_500_000), closes: When::UnixUs(1_000_000) };
        assert_eq!(window("+1.5..1970-01-01T00:00:01Z"), Ok(both));
        assert_eq!(window(".."), Ok(Window::default()));
        assert_eq!(window("0..0"), Ok(Window::default()));
        assert!(window("+1").is_err());
        assert!(window("soon..").is_err());
    }

    #[test]
    fn what_is_shown_is_cut_and_not_rounded() {
        assert_eq!(shown(1_999_999, 1), "1.9");
        assert_eq!(shown(1_000, 3), "0.001");
    }
}
