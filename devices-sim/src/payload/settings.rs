//! The settings of a unit as a mission file gives them: names with their units,
//! values as text.

use std::collections::BTreeMap;
use std::collections::BTreeSet;

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Duration;

/// Reads settings, and remembers what was wrong and what nobody asked for.
pub(crate) struct Settings<'a> {
    given: &'a BTreeMap<String, String>,
    known: BTreeSet<&'static str>,
    wrong: Vec<String>,
}

impl<'a> Settings<'a> {
    pub(crate) fn new(given: &'a BTreeMap<String, String>) -> Self {
        Self { given, known: BTreeSet::new(), wrong: Vec::new() }
    }

    /// Watts, to the milliwatt.
    pub(crate) fn watts(&mut self, name: &'static str, default: Milliwatts) -> Milliwatts {
        self.thousandths(name).map_or(default, Milliwatts::new)
    }

    /// Seconds, to the millisecond.
    pub(crate) fn seconds(&mut self, name: &'static str, default: Duration) -> Duration {
        self.thousandths(name).map_or(default, Duration::from_millis)
    }

    /// A whole number.
    pub(crate) fn number(&mut self, name: &'static str, default: u64) -> u64 {
        let Some(text) = self.text(name) else { return default };
        text.parse().unwrap_or_else(|_| {
            self.expected(name, text, "a whole number");
            default
        })
    }

    /// A number with up to three decimals, in thousandths.
    pub(crate) fn thousandths(&mut self, name: &'static str) -> Option<u64> {
        let text = self.text(name)?;
        let number = thousandths(text);
        if number.is_none() {
            self.expected(name, text, "a number with at most three decimals");
        }
        number
    }

    /// A name that means nothing to the unit itself: any will do.
    pub(crate) fn name(&mut self, name: &'static str) {
        let _ = self.text(name);
    }

    /// Spans in seconds: `0..600, 5800..6400`.
    pub(crate) fn spans(&mut self, name: &'static str) -> Option<Vec<(Duration, Duration)>> {
        let text = self.text(name)?;
        let spans = text.split(',').map(span).collect::<Option<Vec<_>>>();
        if spans.is_none() {
            self.expected(name, text, "spans of seconds, such as `0..600, 5800..6400`");
        }
        spans
    }

    /// What was read, or everything that was wrong.
    pub(crate) fn finish<T>(mut self, kind: &str, read: T) -> Result<T, Vec<String>> {
        for name in self.given.keys().filter(|name| !self.known.contains(name.as_str())) {
            let known = self.known.iter().copied().collect::<Vec<_>>().join(", ");
            self.wrong.push(format!("a {kind} has no parameter `{name}`; it has {known}"));
        }
        if self.wrong.is_empty() { Ok(read) } else { Err(self.wrong) }
    }

    fn text(&mut self, name: &'static str) -> Option<&'a str> {
        self.known.insert(name);
        self.given.get(name).map(|text| text.trim())
    }

    fn expected(&mut self, name: &str, text: &str, expected: &str) {
        self.wrong.push(format!("`{name}` is `{text}`; expected {expected}"));
    }
}

/// `12.5` as 12 500.
pub(crate) fn thousandths(text: &str) -> Option<u64> {
    let (whole, decimals) = text.split_once('.').unwrap_or((text, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(whole) || !digits(decimals) || decimals.len() > 3 {
        return None;
    }
    let thousand: u64 = format!("{decimals:0<3}").parse().ok()?;
    whole.parse::<u64>().ok()?.checked_mul(1_000)?.checked_add(thousand)
}

fn span(text: &str) -> Option<(Duration, Duration)> {
    let (from, to) = text.trim().split_once("..")?;
    let from = Duration::from_millis(thousandths(from.trim())?);
    let to = Duration::from_millis(thousandths(to.trim())?);
    (from < to).then_some((from, to))
}
