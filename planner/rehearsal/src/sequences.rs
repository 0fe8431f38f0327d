//! Sequences: which units they command. It is the sequence that says so, and not
//! the plan.

use std::collections::BTreeMap;

/// The units of the simulated rover, beside its engines.
const UNITS: [&str; 7] = ["mast", "wheels", "arm", "drill", "caching", "turret", "laser"];

/// Which units each sequence commands, by the first word of its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sequences(BTreeMap<String, Vec<usize>>);

impl Default for Sequences {
    /// The sequences of the example plans.
    fn default() -> Self {
        let book = [
            ("drive", &["wheels"][..]),
            ("turn", &["wheels"]),
            ("mast", &["mast"]),
            ("pan", &["mast"]),
            ("arm", &["arm"]),
            ("place", &["arm", "turret"]),
            ("drill", &["arm", "drill"]),
            ("sample", &["arm", "drill"]),
            ("cache", &["caching"]),
        ];
        let mut sequences = Self(BTreeMap::new());
        for (word, units) in book {
            sequences.add(word, units);
        }
        sequences
    }
}

impl Sequences {
    /// How many units there are.
    #[must_use]
    pub const fn units() -> usize {
        UNITS.len()
    }

    /// The name of a unit.
    #[must_use]
    pub fn unit_name(unit: usize) -> Option<&'static str> {
        UNITS.get(unit).copied()
    }

    /// No sequence commands any unit: each uses its engines alone.
    #[must_use]
    pub const fn none() -> Self {
        Self(BTreeMap::new())
    }

    /// Sequences whose names begin with this word command these units. Unknown
    /// units are left out.
    pub fn add(&mut self, word: &str, units: &[&str]) {
        let found = units.iter().filter_map(|unit| UNITS.iter().position(|name| name == unit));
        self.0.insert(word.to_owned(), found.collect());
    }

    /// The units that a sequence of this name commands.
    #[must_use]
    pub fn of(&self, sequence: &str) -> &[usize] {
        let word = sequence.split(|c: char| !c.is_alphabetic()).next().unwrap_or_default();
        self.0.get(word).map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_says_which_units_it_commands() {
        let mut sequences = Sequences::default();
        assert_eq!(sequences.of("place_mahli").len(), 2);
        assert_eq!(sequences.of("driver"), &[0; 0]);
        sequences.add("wave", &["arm", "nothing"]);
        assert_eq!(sequences.of("wave-2").iter().map(|u| UNITS[*u]).collect::<Vec<_>>(), ["arm"]);
    }
}
