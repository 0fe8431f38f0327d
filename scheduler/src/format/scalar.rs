//! Single values: numbers, times, masks, amounts.
//!
//! All exact: decimals are read digit by digit, never through a float.

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;

use crate::format::diagnostic::Rule;
use crate::format::wrong::{Wrong, shown};
use crate::task::{TaskId, TaskPriority, When};
use crate::time::{Duration, UnixTime};

/// How many categories there are.
const CATEGORIES: u32 = 128;

/// How the conflict column is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Conflict {
    /// Each bit is a category (Gillette 2019). 0 conflicts with nothing.
    #[default]
    Mask,
    /// The number of one category (Gillette 2018): equal numbers conflict, and
    /// 0 is a number like any other.
    Number,
}

pub(crate) fn task_id(text: &str) -> Result<TaskId, Wrong> {
    let expected = "a task number, 1 to 4294967295";
    let number = whole(text, u32::MAX.into(), expected)?;
    u32::try_from(number)
        .ok()
        .and_then(TaskId::new)
        .ok_or_else(|| Wrong::new(Rule::Range, "0 is not a task").expected(expected))
}

pub(crate) fn priority(text: &str) -> Result<TaskPriority, Wrong> {
    let expected = "a priority, 0 to 239";
    let level = whole(text, TaskPriority::TOP.level().into(), expected).map_err(|wrong| {
        if wrong.rule == Rule::Range {
            wrong.help("levels from 240 are for fault responses")
        } else {
            wrong
        }
    })?;
    u8::try_from(level).ok().and_then(TaskPriority::new).ok_or_else(|| too_large(text, expected))
}

pub(crate) fn percent(text: &str) -> Result<u8, Wrong> {
    let expected = "a percentage, 0 to 100";
    u8::try_from(whole(text, 100, expected)?).map_err(|_| too_large(text, expected))
}

/// SMAARTE's `type`.
pub(crate) fn type_number(text: &str) -> Result<u16, Wrong> {
    let expected = "a type, 0 to 65535";
    u16::try_from(whole(text, u16::MAX.into(), expected)?).map_err(|_| too_large(text, expected))
}

pub(crate) fn category(text: &str) -> Result<u8, Wrong> {
    let expected = "the number of a category, 0 to 127";
    let most = u128::from(CATEGORIES - 1);
    u8::try_from(whole(text, most, expected)?).map_err(|_| too_large(text, expected))
}

pub(crate) fn bytes(text: &str) -> Result<u64, Wrong> {
    let expected = "a number of bytes";
    u64::try_from(whole(text, u64::MAX.into(), expected)?).map_err(|_| too_large(text, expected))
}

/// Seconds, to the microsecond.
pub(crate) fn seconds(text: &str) -> Result<Duration, Wrong> {
    decimal(text, 6, "seconds, 0 or more").map(Duration::from_micros)
}

pub(crate) fn watts(text: &str) -> Result<Milliwatts, Wrong> {
    decimal(text, 3, "watts, 0 or more").map(Milliwatts::new)
}

/// `0`, Unix seconds, or `+` and seconds after the load.
pub(crate) fn when(text: &str) -> Result<When, Wrong> {
    let expected = "0, Unix seconds, or + and seconds after the load";
    if let Some(after) = text.strip_prefix('+') {
        return decimal(after, 6, expected).map(Duration::from_micros).map(When::AfterLoad);
    }
    let us = decimal(text, 6, expected)?;
    let us = i64::try_from(us).map_err(|_| too_large(text, expected))?;
    Ok(if us == 0 { When::Unrestricted } else { When::At(UnixTime::from_micros(us)) })
}

/// A mask in decimal or hexadecimal, or `all`.
pub(crate) fn categories(text: &str, conflict: Conflict) -> Result<Categories, Wrong> {
    if text == "all" {
        return Ok(Categories::ALL);
    }
    if conflict == Conflict::Number {
        return category(text).map(|number| Categories::from_mask(1 << number));
    }
    let expected = "a mask of at most 128 bits (decimal, or hexadecimal with 0x), or all";
    match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        None => whole(text, u128::MAX, expected).map(Categories::from_mask),
        Some(digits) if is_hex(digits) => u128::from_str_radix(digits, 16)
            .map(Categories::from_mask)
            .map_err(|_| too_large(text, expected)),
        Some(_) => Err(not_a_number(text, expected)),
    }
}

fn is_hex(digits: &str) -> bool {
    !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// A number without a fraction.
pub(crate) fn whole(text: &str, most: u128, expected: &str) -> Result<u128, Wrong> {
    check_sign(text, expected)?;
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(not_a_number(text, expected));
    }
    match text.parse::<u128>() {
        Ok(number) if number <= most => Ok(number),
        _ => Err(too_large(text, expected)),
    }
}

/// A number with at most so many digits after the point, times ten to the
/// power of that.
pub(crate) fn decimal(text: &str, places: usize, expected: &str) -> Result<u64, Wrong> {
    check_sign(text, expected)?;
    let (before, after) = text.split_once('.').unwrap_or((text, "0"));
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(before) || !digits(after) {
        return Err(not_a_number(text, expected));
    }
    let after = after.trim_end_matches('0');
    if after.len() > places {
        let message = format!("{} has more than {places} digits after the point", shown(text));
        return Err(Wrong::new(Rule::Range, message).expected(expected));
    }
    format!("{before}{after:0<places$}").parse().map_err(|_| too_large(text, expected))
}

fn check_sign(text: &str, expected: &str) -> Result<(), Wrong> {
    match text.strip_prefix(['-', '\u{2212}']) {
        Some(rest) if rest.starts_with(|first: char| first.is_ascii_digit()) => {
            let message = format!("{} is negative", shown(text));
            Err(Wrong::new(Rule::Range, message).expected(expected))
        }
        _ => Ok(()),
    }
}

fn too_large(text: &str, expected: &str) -> Wrong {
    Wrong::new(Rule::Range, format!("{} is too large", shown(text))).expected(expected)
}

/// Says what spreadsheets do to numbers, where that is what happened.
fn not_a_number(text: &str, expected: &str) -> Wrong {
    if text.is_empty() {
        return Wrong::new(Rule::Missing, "there is nothing").expected(expected);
    }
    let wrong = Wrong::new(Rule::Value, format!("{} is no such number", shown(text)));
    let numeric = text.starts_with(|first: char| first.is_ascii_digit());
    let wrong = wrong.expected(expected);
    if numeric && text.contains(['e', 'E']) && !text.starts_with("0x") {
        return wrong.help(
            "write it out; where a spreadsheet has shortened it, format the column as a number",
        );
    }
    if numeric && text.contains(',') {
        return wrong.help("write decimals with a point");
    }
    wrong
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_of_seconds_are_exact() {
        assert_eq!(seconds("0.15"), Ok(Duration::from_millis(150)));
        assert_eq!(seconds("3"), Ok(Duration::from_secs(3)));
        assert_eq!(seconds("0.100000000"), Ok(Duration::from_millis(100)));
        assert_eq!(seconds("18446744073709.551615"), Ok(Duration::MAX));
        assert_eq!(seconds("18446744073709.551616").unwrap_err().rule, Rule::Range);
        assert_eq!(seconds("0.0000001").unwrap_err().rule, Rule::Range);
        assert_eq!(watts("4.5"), Ok(Milliwatts::new(4_500)));
    }

    #[test]
    fn a_time_is_restricted_absolute_or_after_the_load() {
        assert_eq!(when("0"), Ok(When::Unrestricted));
        assert_eq!(when("+0"), Ok(When::AfterLoad(Duration::ZERO)));
        assert_eq!(when("+2.5"), Ok(When::AfterLoad(Duration::from_millis(2_500))));
        assert_eq!(when("1553323537"), Ok(When::At(UnixTime::from_secs(1_553_323_537))));
        for bad in ["", "+", "-5", "+-5", "1e9", "1,5", ".", "5.", "soon", "99999999999999"] {
            assert!(when(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_mask_has_up_to_128_bits() {
        let mask = |text| categories(text, Conflict::Mask).map(Categories::mask);
        assert_eq!(mask("9"), Ok(9));
        assert_eq!(mask("0xFf"), Ok(255));
        assert_eq!(mask("all"), Ok(u128::MAX));
        assert_eq!(mask("340282366920938463463374607431768211455"), Ok(u128::MAX));
        let over = mask("340282366920938463463374607431768211456").unwrap_err();
        assert_eq!(over.rule, Rule::Range);
        assert_eq!(mask("0x1ffffffffffffffffffffffffffffffff").unwrap_err().rule, Rule::Range);
        assert_eq!(mask("0x").unwrap_err().rule, Rule::Value);
        assert_eq!(mask("0x+1").unwrap_err().rule, Rule::Value);
    }

    #[test]
    fn equal_numbers_conflict_in_files_of_2018() {
        let number = |text| categories(text, Conflict::Number).map(Categories::mask);
        assert_eq!(number("0"), Ok(1));
        assert_eq!(number("3"), Ok(8));
        assert_eq!(number("127"), Ok(1 << 127));
        assert!(number("128").is_err());
    }

    #[test]
    fn a_task_is_never_as_important_as_a_fault_response() {
        assert_eq!(priority("239"), Ok(TaskPriority::TOP));
        let over = priority("240").unwrap_err();
        assert_eq!(over.rule, Rule::Range);
        assert!(over.help.unwrap().contains("fault responses"));
    }

    #[test]
    fn what_a_spreadsheet_did_to_a_number_is_explained() {
        assert!(seconds("1.55E+09").unwrap_err().help.unwrap().contains("spreadsheet"));
        assert!(seconds("0,15").unwrap_err().help.unwrap().contains("point"));
    }
}
