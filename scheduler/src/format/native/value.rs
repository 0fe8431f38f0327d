//! Values of the native format.

use std::str::FromStr;

use faregate_tickets::amount::Milliwatts;
use jiff::{SignedDuration, Timestamp};
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use crate::format::diagnostic::Rule;
use crate::format::scalar;
use crate::format::suggest;
use crate::format::words;
use crate::format::wrong::{Wrong, shown};
use crate::task::When;
use crate::time::{Duration, UnixTime};

/// What a value is not.
pub(crate) fn other(value: &DeValue<'_>, expected: &str) -> Wrong {
    let what = match value {
        DeValue::String(text) => format!("the string {}", shown(text)),
        DeValue::Integer(number) => format!("the number {}", shown(&number.to_string())),
        DeValue::Float(number) => format!("the number {}", shown(number.as_str())),
        DeValue::Boolean(value) => format!("the truth value {value}"),
        DeValue::Datetime(time) => format!("the time {time}"),
        DeValue::Array(_) => "an array".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    };
    Wrong::new(Rule::Value, format!("this is {what}")).expected(expected)
}

pub(crate) fn text<'t>(value: &'t DeValue<'_>) -> Result<&'t str, Wrong> {
    match value {
        DeValue::String(text) => Ok(text),
        _ => Err(other(value, "a string")),
    }
}

/// A name: a string that is not empty.
pub(crate) fn name(value: &DeValue<'_>) -> Result<String, Wrong> {
    match text(value)? {
        "" => Err(Wrong::new(Rule::Value, "the name is empty").expected("a name")),
        name => Ok(name.to_owned()),
    }
}

pub(crate) fn truth(value: &DeValue<'_>) -> Result<bool, Wrong> {
    match value {
        DeValue::Boolean(value) => Ok(*value),
        _ => Err(other(value, "true or false")),
    }
}

pub(crate) fn array<'t>(value: &'t DeValue<'t>) -> Result<&'t DeArray<'t>, Wrong> {
    match value {
        DeValue::Array(items) => Ok(items),
        _ => Err(other(value, "an array")),
    }
}

pub(crate) fn table<'t>(value: &'t DeValue<'t>) -> Result<&'t DeTable<'t>, Wrong> {
    match value {
        DeValue::Table(table) => Ok(table),
        _ => Err(other(value, "a table")),
    }
}

/// A number as the readers of columns know it: in decimal digits.
pub(crate) fn digits(value: &DeValue<'_>, expected: &str) -> Result<String, Wrong> {
    match value {
        DeValue::Integer(number) if number.radix() == 10 => Ok(number.as_str().to_owned()),
        DeValue::Integer(number) => u128::from_str_radix(number.as_str(), number.radix())
            .map(|number| number.to_string())
            .map_err(|_| other(value, expected)),
        DeValue::Float(number) => Ok(number.as_str().to_owned()),
        _ => Err(other(value, expected)),
    }
}

/// A reader of a column, for a number.
pub(crate) fn number<T>(
    expected: &'static str,
    read: fn(&str) -> Result<T, Wrong>,
) -> impl Fn(&DeValue<'_>) -> Result<T, Wrong> {
    move |value| read(&digits(value, expected)?)
}

pub(crate) fn watts(value: &DeValue<'_>) -> Result<Milliwatts, Wrong> {
    scalar::watts(&digits(value, "a number of watts")?)
}

/// Seconds as a number, or a string with a unit.
pub(crate) fn duration(value: &DeValue<'_>) -> Result<Duration, Wrong> {
    match value {
        DeValue::String(text) => duration_of(text),
        _ => scalar::seconds(&digits(value, DURATION)?),
    }
}

const DURATION: &str = "seconds, or a string such as \"1.5s\", \"20min\", \"1h 30min\"";

/// A duration with units, or in seconds.
pub(crate) fn duration_of(text: &str) -> Result<Duration, Wrong> {
    let wrong =
        |rule, what: &str| Wrong::new(rule, format!("{} {what}", shown(text))).expected(DURATION);
    if let Ok(seconds) = scalar::seconds(text) {
        return Ok(seconds);
    }
    let duration =
        SignedDuration::from_str(text).map_err(|_| wrong(Rule::Value, "is no duration"))?;
    let us = u64::try_from(duration.as_micros())
        .map_err(|_| wrong(Rule::Range, "is negative, or too long"))?;
    if duration.subsec_nanos() % 1_000 != 0 {
        return Err(wrong(Rule::Range, "is finer than a microsecond"));
    }
    Ok(Duration::from_micros(us))
}

const WHEN: &str = "0, Unix seconds, \"+\" and a duration after the load, or a time such as \
                    2026-03-01T12:00:00Z";

/// 0, Unix seconds, a duration after the load, or a date and time.
pub(crate) fn when(value: &DeValue<'_>) -> Result<When, Wrong> {
    match value {
        DeValue::String(text) => when_of(text),
        DeValue::Datetime(time) => date(&time.to_string()),
        DeValue::Integer(number) if number.as_str().starts_with('+') => {
            let wrong = other(value, WHEN);
            Err(wrong.help(format!("put it in quotes: \"{}\" is after the load", number.as_str())))
        }
        _ => scalar::when(&digits(value, WHEN)?),
    }
}

/// The same as a string.
pub(crate) fn when_of(text: &str) -> Result<When, Wrong> {
    if let Some(after) = text.strip_prefix('+') {
        return duration_of(after).map(When::AfterLoad);
    }
    if text.contains('T') || text.contains(':') {
        return date(text);
    }
    scalar::when(text).map_err(|wrong| wrong.expected(WHEN))
}

fn date(text: &str) -> Result<When, Wrong> {
    let time = Timestamp::from_str(text).map_err(|_| {
        Wrong::new(Rule::Value, format!("{} is no point in time", shown(text)))
            .expected(WHEN)
            .help("a date and time of day with its offset: Z, or +01:00")
    })?;
    if time.subsec_nanosecond() % 1_000 != 0 {
        let message = format!("{} is finer than a microsecond", shown(text));
        return Err(Wrong::new(Rule::Range, message).expected(WHEN));
    }
    Ok(When::At(UnixTime::from_micros(time.as_microsecond())))
}

const SIZE: &str = "bytes, or a string such as \"3MiB\", \"1.5 GB\"";

/// Bytes as a number, or a string with a unit.
pub(crate) fn size(value: &DeValue<'_>) -> Result<u64, Wrong> {
    match value {
        DeValue::String(text) => size_of(text),
        _ => scalar::bytes(&digits(value, SIZE)?),
    }
}

/// The same as a string.
pub(crate) fn size_of(text: &str) -> Result<u64, Wrong> {
    if let Ok(bytes) = scalar::bytes(text) {
        return Ok(bytes);
    }
    // `parse_size` rounds what has more digits, and adds past the largest number.
    if text.bytes().filter(u8::is_ascii_digit).count() > 18 {
        let message = format!("{} has more than 18 digits", shown(text));
        return Err(Wrong::new(Rule::Range, message).expected(SIZE));
    }
    parse_size::parse_size(text.as_bytes())
        .map_err(|_| Wrong::new(Rule::Value, format!("{} is no size", shown(text))).expected(SIZE))
}

/// Words: an array of them, or a line that is split as a shell splits it.
pub(crate) fn words(value: &DeValue<'_>) -> Result<words::Words, Wrong> {
    match value {
        DeValue::String(line) => words::split(line),
        DeValue::Array(items) => {
            let words: Vec<String> = items
                .iter()
                .map(Spanned::get_ref)
                .map(|word| text(word).map(str::to_owned))
                .collect::<Result<_, _>>()?;
            words::check(&words)?;
            Ok(words::Words { words, warning: None })
        }
        _ => Err(other(value, "words in one string, or an array of strings")),
    }
}

/// One of these words, with what it means.
pub(crate) fn word<T: Copy>(value: &DeValue<'_>, known: &[(&'static str, T)]) -> Result<T, Wrong> {
    let names = known.iter().map(|(name, _)| *name);
    let expected = names.clone().collect::<Vec<_>>().join(", ");
    let text = text(value).map_err(|wrong| wrong.expected(expected.clone()))?;
    known.iter().find(|(name, _)| *name == text).map(|(_, meaning)| *meaning).ok_or_else(|| {
        let wrong = Wrong::new(Rule::Unknown, format!("nobody knows {}", shown(text)));
        match suggest::nearest(text, names) {
            Some(near) => wrong.expected(expected).help(format!("did you mean {near}?")),
            None => wrong.expected(expected),
        }
    })
}

/// Puts a value into a field, if it could be read.
pub(crate) fn set<T>(field: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *field = value;
    }
}
