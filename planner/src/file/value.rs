//! Quantities, read digit by digit and never through a float: what an integer
//! cannot hold exactly is refused, not rounded.

use faregate_agents::Categories;
use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::{Wrong, shown};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::plan::ActivityId;
use crate::units::{Bytes, Ppm, Span};

/// A kind of quantity: how it can be written, and what it is counted in.
pub(crate) struct Quantity {
    /// Units and how much each is, as a fraction of what is counted.
    pub(crate) units: &'static [(&'static str, i128, i128)],
    /// The finest there is.
    finest: &'static str,
    expected: &'static str,
}

pub(crate) const SPAN: Quantity = Quantity {
    units: &[("h", 3_600_000, 1), ("min", 60_000, 1), ("s", 1_000, 1), ("ms", 1, 1)],
    finest: "1 ms",
    expected: "a length of time, such as 25 min, 90 s, 250 ms or 1 h 30 min",
};

pub(crate) const POWER: Quantity = Quantity {
    units: &[("kW", 1_000_000, 1), ("W", 1_000, 1), ("mW", 1, 1)],
    finest: "1 mW",
    expected: "a power, such as 12.5 W or 250 mW",
};

pub(crate) const ENERGY: Quantity = Quantity {
    units: &[
        ("kWh", 3_600_000_000_000, 1),
        ("Wh", 3_600_000_000, 1),
        ("mWh", 3_600_000, 1),
        ("MJ", 1_000_000_000_000, 1),
        ("kJ", 1_000_000_000, 1),
        ("J", 1_000_000, 1),
        ("mJ", 1_000, 1),
        ("uJ", 1, 1),
    ],
    finest: "1 uJ",
    expected: "an energy, such as 90 Wh or 1500 J",
};

pub(crate) const DATA: Quantity = Quantity {
    units: &[
        ("GB", 1_000_000_000, 1),
        ("MB", 1_000_000, 1),
        ("kB", 1_000, 1),
        ("B", 1, 1),
        ("GiB", 1 << 30, 1),
        ("MiB", 1 << 20, 1),
        ("KiB", 1 << 10, 1),
        ("Gbit", 125_000_000, 1),
        ("Mbit", 125_000, 1),
        ("kbit", 125, 1),
        ("bit", 1, 8),
    ],
    finest: "1 B",
    expected: "an amount of data, such as 12 MB, 96 Mbit or 500 B",
};

pub(crate) const FRACTION: Quantity = Quantity {
    units: &[("%", 10_000, 1), ("ppm", 1, 1)],
    finest: "1 ppm",
    expected: "a fraction of the capacity, such as 45 % or 450000 ppm",
};

/// Adds up `25 min`, or `1 h 30 min`: numbers, each with its unit.
pub(crate) fn quantity(text: &str, of: &Quantity) -> Result<i128, Wrong> {
    let (negative, mut rest) = match text.trim().strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text.trim()),
    };
    if rest.is_empty() {
        return Err(Wrong::new(Rule::Missing, "there is nothing").expected(of.expected));
    }
    let mut sum = 0_i128;
    while !rest.is_empty() {
        let (number, after) = Decimal::take(rest).map_err(|wrong| wrong.expected(of.expected))?;
        let after = after.trim_start();
        let end = after.find(|one: char| !one.is_ascii_alphabetic() && one != '%');
        let (unit, after) = after.split_at(end.unwrap_or(after.len()));
        let part = number.times(unit_of(unit, text, of)?).ok_or_else(|| too_fine(text, of))?;
        sum = sum.checked_add(part).ok_or_else(|| too_large(text, of.expected))?;
        rest = after.trim_start();
    }
    Ok(if negative { -sum } else { sum })
}

fn unit_of(unit: &str, text: &str, of: &Quantity) -> Result<(i128, i128), Wrong> {
    let found = of.units.iter().find(|(name, ..)| *name == unit);
    found.map(|(_, size, parts)| (*size, *parts)).ok_or_else(|| {
        let message = match unit {
            "" => format!("{} has no unit", shown(text)),
            _ => format!("{} is no unit here", shown(unit)),
        };
        let names: Vec<_> = of.units.iter().map(|(name, ..)| *name).collect();
        let help = format!("units are {}", names.join(", "));
        Wrong::new(Rule::Value, message).expected(of.expected).help(help)
    })
}

fn too_fine(text: &str, of: &Quantity) -> Wrong {
    let message = format!("{} is too large, or no multiple of {}", shown(text), of.finest);
    Wrong::new(Rule::Range, message).expected(of.expected)
}

fn too_large(text: &str, expected: &str) -> Wrong {
    Wrong::new(Rule::Range, format!("{} is too large", shown(text))).expected(expected)
}

/// A number as it stands there: its digits, and how many are behind the point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Decimal {
    digits: i128,
    places: u32,
}

impl Decimal {
    /// The number at the begin of this text, and what follows it.
    pub(crate) fn take(text: &str) -> Result<(Self, &str), Wrong> {
        let end = text.find(|one: char| !one.is_ascii_digit() && one != '.');
        let (number, rest) = text.split_at(end.unwrap_or(text.len()));
        let (before, after) = number.split_once('.').unwrap_or((number, "0"));
        let good = |part: &str| !part.is_empty() && part.bytes().all(|one| one.is_ascii_digit());
        if !good(before) || !good(after) {
            let wrong = Wrong::new(Rule::Value, format!("{} is no such number", shown(text)));
            return Err(match rest.starts_with(',') {
                true => wrong.help("write decimals with a point"),
                false => wrong,
            });
        }
        let after = after.trim_end_matches('0');
        let digits = format!("{before}{after}").parse().ok().zip(u32::try_from(after.len()).ok());
        let (digits, places) = digits.ok_or_else(|| too_large(text, "a smaller number"))?;
        Ok((Self { digits, places }, rest))
    }

    /// So many times a fraction; `None`: that is no integer, or too large a one.
    pub(crate) fn times(self, (size, parts): (i128, i128)) -> Option<i128> {
        let parts = 10_i128.checked_pow(self.places)?.checked_mul(parts)?;
        let whole = self.digits.checked_mul(size)?;
        (whole % parts == 0).then_some(whole / parts)
    }
}

/// A quantity that is not negative and fits.
fn unsigned(text: &str, of: &Quantity) -> Result<u64, Wrong> {
    let units = quantity(text, of)?;
    if units < 0 {
        let message = format!("{} is negative", shown(text));
        return Err(Wrong::new(Rule::Range, message).expected(of.expected));
    }
    // Whatever is computed later is signed.
    match i64::try_from(units) {
        Ok(units) => Ok(units.unsigned_abs()),
        Err(_) => Err(too_large(text, of.expected)),
    }
}

/// A length of time. A bare number is seconds.
pub(crate) fn span(text: &str) -> Result<Span, Wrong> {
    let ms = match has_no_unit(text) {
        true => unsigned(&format!("{text} s"), &SPAN)?,
        false => unsigned(text, &SPAN)?,
    };
    Ok(Span::new(i64::try_from(ms).unwrap_or(i64::MAX)))
}

/// Whether it is a number alone.
pub(crate) fn has_no_unit(text: &str) -> bool {
    text.trim().bytes().all(|one| one.is_ascii_digit() || one == b'.')
}

pub(crate) fn power(text: &str) -> Result<Milliwatts, Wrong> {
    unsigned(text, &POWER).map(Milliwatts::new)
}

pub(crate) fn energy(text: &str) -> Result<Microjoules, Wrong> {
    unsigned(text, &ENERGY).map(Microjoules::new)
}

/// Negative where data is freed.
pub(crate) fn data(text: &str) -> Result<Bytes, Wrong> {
    let bytes = i64::try_from(quantity(text, &DATA)?);
    bytes.map(Bytes::new).map_err(|_| too_large(text, DATA.expected))
}

pub(crate) fn fraction(text: &str) -> Result<Ppm, Wrong> {
    match unsigned(text, &FRACTION)? {
        ppm @ 0..=1_000_000 => Ok(Ppm::new(i64::try_from(ppm).unwrap_or(i64::MAX))),
        _ => Err(too_large(text, "at most 100 %")),
    }
}

/// A whole number between these, both included.
pub(crate) fn whole<T>(text: &str, expected: &str) -> Result<T, Wrong>
where
    T: TryFrom<i128>,
{
    let digits = text.trim().strip_prefix('-').unwrap_or(text.trim());
    if digits.is_empty() || !digits.bytes().all(|one| one.is_ascii_digit()) {
        let wrong = Wrong::new(Rule::Value, format!("{} is no whole number", shown(text)));
        return Err(wrong.expected(expected));
    }
    let number = text.trim().parse::<i128>().ok().and_then(|number| T::try_from(number).ok());
    number.ok_or_else(|| {
        let message = format!("{} is too large or too small", shown(text));
        Wrong::new(Rule::Range, message).expected(expected)
    })
}

pub(crate) fn count(text: &str) -> Result<u32, Wrong> {
    whole(text, "a whole number, 0 or more")
}

pub(crate) fn worth(text: &str) -> Result<u64, Wrong> {
    whole(text, "a whole number, 0 or more")
}

pub(crate) fn number(text: &str) -> Result<i64, Wrong> {
    whole(text, "a whole number")
}

pub(crate) fn activity(text: &str) -> Result<ActivityId, Wrong> {
    let expected = "an activity's number, 1 to 4294967295";
    let number = whole(text, expected)?;
    ActivityId::new(number)
        .ok_or_else(|| Wrong::new(Rule::Range, "0 is no activity").expected(expected))
}

/// One resource usage bit.
pub(crate) fn bit(text: &str) -> Result<u8, Wrong> {
    let expected = "the number of a bit, 0 to 127";
    match whole(text, expected)? {
        bit @ 0..=127 => Ok(bit),
        _ => Err(too_large(text, expected)),
    }
}

/// The set that has this bit alone.
pub(crate) fn only(bit: u8) -> Categories {
    Categories::from_mask(1_u128.checked_shl(bit.into()).unwrap_or(0))
}

pub(crate) fn yes_or_no(text: &str) -> Result<bool, Wrong> {
    match text {
        "true" => Ok(true),
        "false" => Ok(false),
        _ => {
            let wrong = Wrong::new(Rule::Value, format!("{} is neither", shown(text)));
            Err(wrong.expected("true or false"))
        }
    }
}

/// A name: what every format can hold, and a terminal shows as it is.
pub(crate) fn name(text: &str) -> Result<String, Wrong> {
    let expected = "a name without control characters";
    if text.trim().is_empty() {
        return Err(Wrong::new(Rule::Missing, "there is nothing").expected(expected));
    }
    if let Some(bad) = text.chars().find(|one| !can_be_named(*one)) {
        let message = format!("a name cannot have {} in it", shown(&bad.to_string()));
        return Err(Wrong::new(Rule::Value, message).expected(expected));
    }
    Ok(text.to_owned())
}

/// XML has no way to write the others, or readers disagree about them.
fn can_be_named(one: char) -> bool {
    !one.is_control() && !matches!(one, '\u{FFFE}' | '\u{FFFF}' | '\u{2028}' | '\u{2029}')
}
