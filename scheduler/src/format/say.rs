//! Single values as native files say them, for command lines.

use crate::format::native::value;
use crate::format::words;
use crate::format::wrong::Wrong;
use crate::task::When;
use crate::time::Duration;

/// A duration: seconds, or with units (`250ms`, `20min`, `1h 30min`).
///
/// # Errors
///
/// What is wrong, and what would be right.
pub fn duration(text: &str) -> Result<Duration, String> {
    value::duration_of(text).map_err(sentence)
}

/// A point in time: `0`, Unix seconds, `+` and a duration, or RFC 3339.
///
/// # Errors
///
/// What is wrong, and what would be right.
pub fn when(text: &str) -> Result<When, String> {
    value::when_of(text).map_err(sentence)
}

/// Bytes: a number, or with a unit (`3MiB`).
///
/// # Errors
///
/// What is wrong, and what would be right.
pub fn size(text: &str) -> Result<u64, String> {
    value::size_of(text).map_err(sentence)
}

/// Arguments, split as a POSIX shell splits them.
///
/// # Errors
///
/// What is wrong, and what would be right.
pub fn words(line: &str) -> Result<Vec<String>, String> {
    words::split(line).map(|split| split.words).map_err(sentence)
}

fn sentence(wrong: Wrong) -> String {
    match wrong.expected {
        Some(expected) => format!("{}; expected {expected}", wrong.message),
        None => wrong.message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_units_and_what_is_none_is_explained() {
        assert_eq!(duration("1h 30min"), Ok(Duration::from_secs(5_400)));
        assert_eq!(duration("1.5"), duration("1500ms"));
        assert_eq!(when("+20min"), Ok(When::AfterLoad(Duration::from_secs(1_200))));
        assert_eq!(size("3MiB"), Ok(3 << 20));
        assert!(size("18446744073709.55161555161815").unwrap_err().contains("18 digits"));
        assert_eq!(words("sleep '3 4'"), Ok(vec!["sleep".into(), "3 4".into()]));
        let wrong = duration("-5s").unwrap_err();
        assert!(wrong.contains("negative") && wrong.contains("expected seconds"), "{wrong}");
        assert!(duration("5ns").unwrap_err().contains("finer"));
        assert!(when("2026-03-01T12:00:00").unwrap_err().contains("no point in time"));
    }
}
