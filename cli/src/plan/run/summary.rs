//! What came of it, in a table.

use std::io;

use faregate_planner::trace::Cause;
use faregate_planner::words::{energy, span};
use faregate_rehearsal::{Summary, Won};

use super::Outcome;
use super::lines::because;
use crate::out::{self, BAD, GOOD};

/// The four causes of the slides first.
const CAUSES: [Cause; 7] = [
    Cause::Cutoff,
    Cause::HardLimit,
    Cause::SoftLimit,
    Cause::Duration,
    Cause::ChargeUnknown,
    Cause::TicketsTaken,
    Cause::Ordered,
];

pub(super) fn print(outcome: &Outcome<'_>) -> io::Result<()> {
    out::line("")?;
    table(outcome.summary, outcome.as_it_stood)?;
    if let Some(won) = outcome.won {
        out::line(said(won))?;
    }
    verdict(outcome.violations.len(), outcome.violations.iter())
}

/// Whether a rule was broken, and which.
pub(super) fn verdict<'v>(
    count: usize,
    violations: impl Iterator<Item = &'v String>,
) -> io::Result<()> {
    for violation in violations {
        out::line(out::styled(BAD, violation))?;
    }
    match count {
        0 => out::line(out::styled(GOOD, "checked: no rule was broken")),
        1 => out::line(out::styled(BAD, "checked: 1 violation")),
        count => out::line(out::styled(BAD, format_args!("checked: {count} violations"))),
    }
}

/// Counts in rows; beside them those of the plan as it stood, if there are any.
pub(super) fn table(here: &Summary, there: Option<&Summary>) -> io::Result<()> {
    let header: &[&str] =
        if there.is_some() { &["", "executed", "as it stood"] } else { &["", "executed"] };
    let mut table = out::table(header);
    let mut row = |name: String, of: &dyn Fn(&Summary) -> String| {
        let mut cells = vec![name, of(here)];
        cells.extend(there.map(of));
        table.add_row(cells);
    };
    if here.executions > 1 {
        row("executions".into(), &|one| one.executions.to_string());
    }
    row("succeeded".into(), &|one| one.succeeded.to_string());
    row("failed".into(), &|one| one.failed.to_string());
    for cause in CAUSES {
        let of = move |one: &Summary| one.aborted.get(&cause).copied().unwrap_or(0).to_string();
        row(format!("aborted: {}", because(cause)), &of);
    }
    row("completed: succeeded or failed".into(), &|one| (one.succeeded + one.failed).to_string());
    row("not started".into(), &|one| one.not_started.to_string());
    row("not started: vetoed".into(), &|one| one.vetoed.to_string());
    row("cleanups".into(), &|one| one.cleanups.to_string());
    row("early starts".into(), &|one| one.early_starts.to_string());
    row("pauses".into(), &|one| one.paused.to_string());
    row("new plans".into(), &|one| one.replans.to_string());
    row("handovers".into(), &|one| one.handovers.to_string());
    row("handovers without a next plan".into(), &|one| one.went_on.to_string());
    let each = |one: &Summary| i64::try_from(one.executions.max(1)).unwrap_or(1);
    row("computer up".into(), &|one| minutes(one.awake_ms / each(one)));
    row("drawn beside the base load".into(), &|one| {
        energy(charge(one.drawn_uj / one.executions.max(1)))
    });
    row("charge at the end".into(), &|one| energy(charge(one.charge_uj / one.executions.max(1))));
    out::line(table)
}

fn said(won: &Won) -> String {
    let activities = if won.activities.abs() == 1 { "activity" } else { "activities" };
    let earlier = if won.earlier_ms < 0 { "later" } else { "earlier" };
    let less = if won.awake_ms < 0 { "longer" } else { "shorter" };
    let less_drawn = if won.energy_uj < 0 { "more" } else { "less" };
    format!(
        "against the plan as it stood: {:+} {activities}; {} {earlier} in sum; \
         computer up {} {less}; {} {less_drawn} drawn",
        won.activities,
        minutes(won.earlier_ms.abs()),
        minutes(won.awake_ms.abs()),
        energy(won.energy_uj.saturating_abs()),
    )
}

fn charge(uj: u64) -> i64 {
    i64::try_from(uj).unwrap_or(i64::MAX)
}

/// Whole minutes are exact enough for a sum over a day.
fn minutes(ms: i64) -> String {
    span(ms / 60_000 * 60_000)
}
