//! The known name that somebody may have meant.

/// What other words people use for a field, the names of SMAARTE's own
/// structure among them.
const MEANT: [(&str, &str); 26] = [
    ("start", "st"),
    ("start_time", "st"),
    ("opens", "st"),
    ("end", "et"),
    ("end_time", "et"),
    ("closes", "et"),
    ("duration", "dur"),
    ("duration_min", "dur_min"),
    ("duration_max", "dur_max"),
    ("conflict", "con"),
    ("conflicts", "con"),
    ("categories", "con"),
    ("priority", "pri"),
    ("routine_interval", "interval"),
    ("period", "interval"),
    ("ram", "memory"),
    ("battery", "power"),
    ("draw", "draw_w"),
    ("peak_draw", "draw_w"),
    ("supply", "supply_w"),
    ("preemption", "preempt"),
    ("arguments", "args"),
    ("program", "run"),
    ("command", "run"),
    ("dependencies", "after"),
    ("steps", "step"),
];

/// The one of the known names that is nearest, if any is near.
#[must_use]
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Whoever wrote so long a word meant none of these, and comparing costs its
    // square.
    if name.len() > 40 {
        return None;
    }
    let name = name.trim().to_lowercase();
    let known: Vec<&str> = known.into_iter().collect();
    let meant = MEANT.iter().filter_map(|(word, meant)| {
        known.iter().find(|known| *known == meant).map(|known| (*word, *known))
    });
    let allowed = name.chars().count().div_ceil(3).min(3);
    (known.iter().map(|known| (*known, *known)))
        .chain(meant)
        .map(|(word, known)| (strsim::osa_distance(&name, word), word, known))
        .filter(|(distance, word, _)| *distance <= allowed && *distance < word.chars().count())
        .min_by_key(|(distance, ..)| *distance)
        .map(|(.., known)| known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_or_longer_name_finds_the_one_that_is_meant() {
        let known = ["id", "st", "et", "dur", "interval", "memory", "con"];
        assert_eq!(nearest("intervall", known), Some("interval"));
        assert_eq!(nearest("memroy", known), Some("memory"));
        assert_eq!(nearest("start_time", known), Some("st"));
        assert_eq!(nearest("durration", known), Some("dur"));
        assert_eq!(nearest("ID", known), Some("id"));
        assert_eq!(nearest("colour", known), None);
        assert_eq!(nearest("x", known), None);
    }
}
