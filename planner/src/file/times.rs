//! Instants: seconds from the origin, or a time of day, with its sol.

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::{Wrong, shown};

use crate::file::value::{Decimal, SPAN, quantity, whole};
use crate::parameters::Day;
use crate::units::{Span, Time};

const EXPECTED: &str = "a time of day (10:30, 10:30:00.250), with a sol in front (1T10:30), \
                        or seconds from the origin";
/// Instants are no farther away than this: a difference of two is an instant,
/// too.
const FARTHEST: i64 = i64::MAX / 2;

/// `10:30` and `1T10:30`, by this day, or seconds from the origin. A bare time
/// of day is one of sol 0, which begins at the day's midnight.
pub(crate) fn time(text: &str, day: Day) -> Result<Time, Wrong> {
    let ms = if text.contains(':') { clock(text, day)? } else { from_origin(text)? };
    match i64::try_from(ms) {
        Ok(ms) if ms.abs() <= FARTHEST => Ok(Time::new(ms)),
        _ => {
            let message = format!("{} is too far away", shown(text));
            Err(Wrong::new(Rule::Range, message).expected(EXPECTED))
        }
    }
}

/// Whether a day is needed to read this.
pub(crate) fn needs_a_day(text: &str) -> bool {
    text.contains(':')
}

fn from_origin(text: &str) -> Result<i128, Wrong> {
    let bare = text.trim().bytes().all(|one| one.is_ascii_digit() || b".-".contains(&one));
    let read = if bare { quantity(&format!("{text} s"), &SPAN) } else { quantity(text, &SPAN) };
    read.map_err(|wrong| wrong.expected(EXPECTED))
}

fn clock(text: &str, day: Day) -> Result<i128, Wrong> {
    let (sol, clock) = text.trim().split_once('T').unwrap_or(("0", text.trim()));
    let sol: i64 = whole(sol, EXPECTED)?;
    let within = time_of_day(clock)?;
    if within >= day.length {
        let message = format!("{} is not in the day, which has {}", shown(clock), day.length);
        let help = "put the sol in front: 1T00:30 is half an hour into sol 1";
        return Err(Wrong::new(Rule::Range, message).expected(EXPECTED).help(help));
    }
    let midnight = i128::from(day.midnight.get()) + i128::from(sol) * i128::from(day.length.get());
    Ok(midnight + i128::from(within.get()))
}

/// `10:30`, `10:30:00`, `10:30:00.250`: the time since midnight.
pub(crate) fn time_of_day(text: &str) -> Result<Span, Wrong> {
    let bad = || Wrong::new(Rule::Value, format!("{} is no time", shown(text))).expected(EXPECTED);
    let mut parts = text.trim().split(':');
    let (Some(hours), Some(minutes), seconds, None) =
        (parts.next(), parts.next(), parts.next(), parts.next())
    else {
        return Err(bad());
    };
    let (seconds, nothing) = Decimal::take(seconds.unwrap_or("0"))?;
    let [hours, minutes] = [hours, minutes].map(|part| whole::<u16>(part, EXPECTED));
    let (hours, minutes) = (i64::from(hours?), i64::from(minutes?));
    let ms = seconds.times((1_000, 1)).and_then(|ms| i64::try_from(ms).ok());
    match ms {
        Some(ms) if minutes < 60 && ms < 60_000 && nothing.is_empty() => {
            Ok(Span::new((hours * 60 + minutes) * 60_000 + ms))
        }
        Some(_) => Err(bad()),
        None => {
            let message = format!("{} is finer than 1 ms", shown(text));
            Err(Wrong::new(Rule::Range, message).expected(EXPECTED))
        }
    }
}

/// As [`time`] reads it; without a day, in seconds.
pub(crate) fn shown_time(at: Time, day: Option<Day>) -> String {
    let Some(day) = day else { return seconds(at.get()) };
    let since = i128::from(at.get()) - i128::from(day.midnight.get());
    let length = i128::from(day.length.get()).max(1);
    let within = i64::try_from(since.rem_euclid(length)).unwrap_or_default();
    match since.div_euclid(length) {
        0 => shown_clock(Span::new(within)),
        sol => format!("{sol}T{}", shown_clock(Span::new(within))),
    }
}

fn seconds(ms: i64) -> String {
    let (sign, ms) = (if ms < 0 { "-" } else { "" }, ms.unsigned_abs());
    let text = format!("{sign}{}.{:03}", ms / 1_000, ms % 1_000);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// As [`time_of_day`] reads it.
pub(crate) fn shown_clock(since_midnight: Span) -> String {
    let ms = since_midnight.get();
    let (hours, minutes, rest) = (ms / 3_600_000, ms / 60_000 % 60, ms % 60_000);
    match (rest / 1_000, rest % 1_000) {
        (0, 0) => format!("{hours:02}:{minutes:02}"),
        (s, 0) => format!("{hours:02}:{minutes:02}:{s:02}"),
        (s, ms) => format!("{hours:02}:{minutes:02}:{s:02}.{ms:03}"),
    }
}
