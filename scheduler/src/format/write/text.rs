//! Values as text.

use faregate_tickets::amount::Milliwatts;

use crate::task::When;
use crate::time::Duration;

/// A whole number of so small a part, with a point.
fn decimal(number: u64, places: u32) -> String {
    let unit = 10_u64.pow(places);
    let (whole, part) = (number / unit, number % unit);
    if part == 0 {
        return whole.to_string();
    }
    let width = places as usize;
    let digits = format!("{part:0width$}");
    format!("{whole}.{}", digits.trim_end_matches('0'))
}

pub(crate) fn seconds(duration: Duration) -> String {
    decimal(duration.as_micros(), 6)
}

pub(crate) fn watts(draw: Milliwatts) -> String {
    decimal(draw.get(), 3)
}

/// As a column has it. What is not after 1970 has no text of its own there.
pub(crate) fn when(when: When) -> String {
    match when {
        When::Unrestricted => "0".to_owned(),
        When::AfterLoad(after) => format!("+{}", seconds(after)),
        When::At(time) => decimal(u64::try_from(time.as_micros()).unwrap_or(0), 6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_are_as_short_as_they_can_be() {
        let shown = |us| seconds(Duration::from_micros(us));
        assert_eq!(shown(1_500_000), "1.5");
        assert_eq!(shown(20_000_000), "20");
        assert_eq!(shown(1), "0.000001");
        assert_eq!(watts(Milliwatts::new(4_250)), "4.25");
    }
}
