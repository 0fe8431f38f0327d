//! What becomes of a task of the native format that is pre-empted, fails or
//! runs too long.

use toml::de::DeValue;

use crate::format::diagnostic::Rule;
use crate::format::draft::Draft;
use crate::format::native::table::Table;
use crate::format::native::value::{self, set, word};
use crate::format::wrong::Wrong;
use crate::format::{policy, scalar};
use crate::task::{Overrun, Restart};
use crate::time::Duration;

/// What happens when a task runs too long, by name.
pub(crate) const OVERRUNS: [(&str, Overrun); 3] = [
    ("report", Overrun::Report),
    ("abort", Overrun::Abort),
    ("abort_and_restart", Overrun::AbortAndRestart),
];

/// Reads the policies.
pub(crate) fn read(table: &mut Table<'_, '_, '_>, draft: &mut Draft) {
    let way = table.read("preempt", way);
    let grace = table.read("grace", value::duration);
    let signal = table.read("signal", |value| policy::signal(value::text(value)?));
    match (way, table.value("preempt").is_some()) {
        (Some(way), _) => {
            let span = table.span("preempt");
            let read = policy::combine(way, grace, signal);
            set(&mut draft.task.preemption, table.report.take(span, "preempt", read));
        }
        (None, true) => {}
        (None, false) => table.present(&["grace", "signal"]).into_iter().for_each(|key| {
            let wrong = Wrong::new(Rule::NoEffect, format!("{key} without preempt says nothing"));
            table.error(
                table.span(key),
                key,
                wrong.help("add preempt = \"checkpoint\" or \"kill\""),
            );
        }),
    }
    let overrun = table.read("overrun", |value| word(value, &OVERRUNS));
    set(&mut draft.task.overrun, overrun);
    set(&mut draft.task.restart, restart(table));
}

fn way(value: &DeValue<'_>) -> Result<&'static str, Wrong> {
    word(value, &policy::WAYS.map(|way| (way, way)))
}

fn restart(table: &mut Table<'_, '_, '_>) -> Option<Restart> {
    let again =
        table.read("restart", |value| word(value, &[("never", false), ("on_failure", true)]));
    let limit = table.read("restart_limit", value::number("how often, 0 or more", limit));
    let back_off = table.read("back_off", value::duration);
    if again == Some(true) {
        let (limit, back_off) = (limit.unwrap_or(1), back_off.unwrap_or(Duration::ZERO));
        return Some(Restart::OnFailure { limit, back_off });
    }
    if table.value("restart").is_none() || again.is_some() {
        for key in table.present(&["restart_limit", "back_off"]) {
            let wrong =
                Wrong::new(Rule::NoEffect, format!("{key} has no effect without a restart"));
            table.error(table.span(key), key, wrong.help("add restart = \"on_failure\""));
        }
    }
    again.map(|_| Restart::Never)
}

fn limit(text: &str) -> Result<u32, Wrong> {
    let number = scalar::whole(text, u32::MAX.into(), "how often, 0 or more")?;
    u32::try_from(number).map_err(|_| Wrong::new(Rule::Range, "too often"))
}
