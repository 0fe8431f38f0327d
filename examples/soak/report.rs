//! What the soak found: a table for people, and figures for programs.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;

use crate::drive::Tally;
use crate::rows::{Row, Where};
use crate::subject::Outcome;

/// At least so many of 100 invocations are admitted.
const ADMITTED_PERCENT: f64 = 20.0;
/// On one processor, at least so many holders are pre-empted inside a command,
/// under each strategy.
const CAUGHT: u64 = 1_000;

/// A row that was soaked.
pub(crate) struct Soaked {
    pub(crate) row: Row,
    pub(crate) tally: Tally,
    pub(crate) took: Duration,
}

impl Soaked {
    /// Adds another pass.
    pub(crate) fn add(&mut self, tally: Tally, took: Duration) {
        self.tally = self.tally.and(tally);
        self.took += took;
    }

    fn place(&self) -> &'static str {
        match self.row.place {
            Where::AllCores => "all cores",
            Where::OneCpu => "one CPU",
        }
    }

    fn name(&self) -> String {
        format!("{}, {}, {}", self.row.strategy, self.row.through, self.place())
    }

    fn is_as_it_must_be(&self) -> bool {
        (self.tally.late > 0) == self.row.control
    }

    fn per_second(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a rate for people")]
        let revocations = self.tally.revocations as f64;
        revocations / self.took.as_secs_f64().max(1e-9)
    }
}

/// One figure, as all benches write them.
#[derive(Debug, Serialize)]
pub(crate) struct Figure {
    row: u8,
    name: String,
    value: f64,
    unit: String,
    target: Option<String>,
    met: Option<bool>,
}

#[derive(Serialize)]
struct Fragment<'a> {
    name: &'static str,
    figures: &'a [Figure],
}

impl Figure {
    #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
    fn count(name: String, value: u64, unit: String, target: &str, met: bool) -> Self {
        let target = Some(target.into());
        Self { row: 11, name, value: value as f64, unit, target, met: Some(met) }
    }

    /// What was asked and is not so.
    pub(crate) fn failure(&self) -> Option<String> {
        let Self { name, value, unit, target, met, .. } = self;
        let target = target.as_deref().unwrap_or_default();
        (*met == Some(false)).then(|| format!("{name}: {value} {unit}, should be {target}"))
    }
}

/// Every condition, with what it came to.
pub(crate) fn figures(soaked: &[Soaked], asked: u64) -> Vec<Figure> {
    let late = soaked.iter().map(|soaked| {
        let name = format!("{}: commands after quiescence", soaked.name());
        let unit = format!("in {} revocations", soaked.tally.revocations);
        let target = if soaked.row.control { "> 0" } else { "0" };
        Figure::count(name, soaked.tally.late, unit, target, soaked.is_as_it_must_be())
    });
    let ours = || soaked.iter().filter(|soaked| !soaked.row.control);
    let admitted = ours().map(|soaked| {
        let percent = soaked.tally.admitted_percent();
        Figure {
            row: 11,
            name: format!("{}: invocations admitted", soaked.name()),
            value: percent,
            unit: "%".into(),
            target: Some(format!(">= {ADMITTED_PERCENT}")),
            met: Some(percent >= ADMITTED_PERCENT),
        }
    });
    let total = ours().map(|soaked| soaked.tally.revocations).sum();
    let name = "revocations of valid tickets".into();
    let target = format!(">= {asked}");
    let revocations = Figure::count(name, total, "in all".into(), &target, total >= asked);
    late.chain(admitted).chain(caught(soaked)).chain([revocations]).collect()
}

/// Of each strategy, over all that it was soaked through.
fn caught(soaked: &[Soaked]) -> Vec<Figure> {
    let on_one_cpu = || soaked.iter().filter(|soaked| soaked.row.place == Where::OneCpu);
    let mut strategies: Vec<_> = on_one_cpu().map(|soaked| soaked.row.strategy).collect();
    strategies.dedup();
    let caught = |strategy: &&str| {
        let same = on_one_cpu().filter(|soaked| soaked.row.strategy == *strategy);
        let caught: u64 = same.map(|soaked| soaked.tally.caught).sum();
        let name = format!("{strategy}, one CPU: holders pre-empted inside a command");
        Figure::count(name, caught, "revocations".into(), &format!(">= {CAUGHT}"), caught >= CAUGHT)
    };
    strategies.iter().map(caught).collect()
}

/// A table of what was soaked.
pub(crate) fn table(soaked: &[Soaked]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header([
        "strategy",
        "revoked through",
        "where",
        "revocations",
        "tickets hit",
        "per second",
        "inside a command",
        "admitted",
        "of it stores",
        "after quiescence",
        "",
    ]);
    for soaked in soaked {
        let tally = &soaked.tally;
        table.add_row([
            soaked.row.strategy.into(),
            soaked.row.through.into(),
            soaked.place().into(),
            tally.revocations.to_string(),
            tally.hit.to_string(),
            format!("{:.0}", soaked.per_second()),
            tally.caught.to_string(),
            format!("{:.0} %", tally.admitted_percent()),
            tally.by_store.to_string(),
            tally.late.to_string(),
            verdict(soaked).into(),
        ]);
    }
    for column in table.column_iter_mut().skip(3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn verdict(soaked: &Soaked) -> &'static str {
    match (soaked.is_as_it_must_be(), soaked.row.control) {
        (true, true) => "seen, as it must be",
        (true, false) => "none, as it must be",
        (false, true) => "NOT SEEN",
        (false, false) => "FAILED",
    }
}

/// Writes the figures to `target/bench/soak.json`; answers where that is.
pub(crate) fn write(figures: &[Figure]) -> Outcome<PathBuf> {
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    let path = target.join("bench").join("soak.json");
    fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
    fs::write(&path, serde_json::to_string_pretty(&Fragment { name: "soak", figures })?)?;
    Ok(path)
}
