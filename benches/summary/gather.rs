//! The findings of all benches, and what is missing.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::support::{Curve, Failure, Figure, Fragment, Peer};

/// Who measures which rows of the targets. Row 12 is the audit's.
const SOURCES: [(&str, &[u8]); 8] = [
    ("invoke", &[1, 2, 3, 4, 5, 6]),
    ("curves", &[7, 8]),
    ("latency", &[9]),
    ("emergency", &[10]),
    ("soak", &[11]),
    ("schedule", &[13, 14, 15, 16]),
    ("journal", &[17]),
    ("planner", &[18, 19, 21]),
];

/// What all benches found together.
#[derive(Debug, Default)]
pub(crate) struct Summary {
    pub(crate) figures: Vec<Figure>,
    pub(crate) peers: Vec<Peer>,
    pub(crate) curves: Vec<Curve>,
    /// Rows that nobody measured.
    pub(crate) missing: Vec<(u8, String)>,
}

impl Summary {
    /// Of the fragments in this directory.
    pub(crate) fn of(directory: &Path) -> Result<Self, Failure> {
        let mut summary = Self::default();
        for (name, rows) in SOURCES {
            match Fragment::read(directory, name)? {
                Some(fragment) => summary.take_in(fragment, rows),
                None => summary.missing.extend(rows.iter().map(|&row| (row, missing(name)))),
            }
        }
        // Stable: within a row the order is the bench's own.
        summary.figures.sort_by_key(|figure| figure.row);
        Ok(summary)
    }

    fn take_in(&mut self, fragment: Fragment, rows: &[u8]) {
        let measures = |row| fragment.figures.iter().any(|figure| figure.row == Some(row));
        let unmeasured = rows.iter().filter(|&&row| !measures(row));
        // A bench of one row need not number it.
        if let [_, _, ..] = rows {
            self.missing.extend(unmeasured.map(|&row| (row, missing(&fragment.name))));
        }
        let only = if let [row] = rows { Some(*row) } else { None };
        let numbered = fragment
            .figures
            .into_iter()
            .map(|figure| Figure { row: figure.row.or(only), ..figure });
        self.figures.extend(numbered);
        self.peers.extend(fragment.peers);
        self.curves.extend(fragment.curves);
    }

    /// Writes the figures, and what is missing, as a list.
    pub(crate) fn write(&self, path: &Path) -> Result<(), Failure> {
        let figures = self.figures.iter().map(|figure| {
            let Figure { name, value, unit, target, met, row } = figure;
            json!({ "name": name, "value": value, "unit": unit, "target": target, "met": met, "row": row })
        });
        let missing = self.missing.iter().map(|(row, name)| {
            json!({ "name": name, "value": null, "unit": "", "target": null, "met": null, "row": row })
        });
        let all: Vec<Value> = figures.chain(missing).collect();
        fs::write(path, serde_json::to_string_pretty(&all)?)?;
        Ok(())
    }

    /// How many targets are met, and what was not measured. Nothing fails for
    /// it: the figures inform.
    pub(crate) fn verdict(&self) -> String {
        let count = |met| self.figures.iter().filter(|figure| figure.met == Some(met)).count();
        let mut verdict = format!("{} targets met, {} missed", count(true), count(false));
        for (row, name) in &self.missing {
            verdict.push_str(&format!("\nMISSING row {row}: {name}"));
        }
        verdict
    }
}

fn missing(name: &str) -> String {
    format!("not measured: `{name}` wrote nothing")
}
