//! The native format: TOML with every field of tasks and mission.

pub(crate) mod keys;
mod mission;
pub(crate) mod policies;
pub(crate) mod steps;
mod syntax;
mod table;
pub(crate) mod task;
pub(crate) mod value;

use toml::de::DeTable;

use crate::format::draft::Draft;
use crate::format::native::table::Table;
use crate::format::wrong::Report;
use crate::mission::Mission;

/// What a native file has.
#[derive(Debug)]
pub(crate) struct Native {
    pub(crate) drafts: Vec<Draft>,
    pub(crate) mission: Option<Mission>,
    /// Where the mission stands.
    pub(crate) mission_at: core::ops::Range<usize>,
    /// Whether all of the mission could be read.
    pub(crate) mission_good: bool,
}

impl Native {
    /// A file without a mission.
    pub(crate) const fn of_tasks(drafts: Vec<Draft>) -> Self {
        Self { drafts, mission: None, mission_at: 0..0, mission_good: true }
    }
}

/// Reads a native file. Categories that tasks name are those of the file's own
/// mission, or else of the one that is given.
pub(crate) fn read(report: &mut Report<'_>, given: Option<&Mission>) -> Native {
    let (document, errors) = DeTable::parse_recoverable(report.source.text());
    let syntax = syntax::Syntax::new(&errors, report);
    let mut top = Table::new(document.get_ref(), document.span(), "", report);
    let mut native = Native::of_tasks(Vec::new());
    native.mission_good = errors.is_empty();
    if let Some((table, at)) = top.table("mission") {
        let before = top.report.found.len();
        native.mission = Some(mission::read(table, at.clone(), top.report));
        native.mission_at = at;
        native.mission_good &= top.report.found.len() == before;
    }
    let mission = native.mission.as_ref().or(given);
    let names = mission.map(|mission| &mission.categories);
    let names = task::Names { of_categories: names, complete: native.mission_good };
    for (table, at) in top.tables("task") {
        if top.report.is_enough(native.drafts.len(), at.clone()) {
            break;
        }
        native.drafts.push(task::read(table, at, names, top.report));
    }
    top.finish(keys::FILE);
    syntax.tell(report);
    native
}
