//! A timed plan for people.

use std::io;

use comfy_table::{Cell, CellAlignment, Table};
use faregate_planner::timed::{AwakePhase, Fate, Row};
use faregate_planner::units::Time;
use faregate_planner::words::{Words, span};

use super::Made;
use super::document::status;
use crate::out;

pub(super) fn print(made: &Made) -> io::Result<()> {
    out::line(out::styled(out::STRONG, &made.plan.name))?;
    out::line(activities(made))?;
    awake(made)?;
    let words = made.words();
    for (heading, all) in [
        ("Exceeded by mandatory activities", &made.timed.excess),
        ("Unavoidable", &made.timed.unavoidable),
    ] {
        let said = all.iter().map(|excess| words.excess(excess)).collect::<Vec<_>>();
        listed(heading, &said)?;
    }
    explanations(made, &words)?;
    listed(&out::styled(out::BAD, "Violations"), &made.violations)?;
    out::line(format_args!("\n{}", verdict(made)))?;
    made.search.iter().try_for_each(|search| out::line(search.said()))
}

fn activities(made: &Made) -> Table {
    let words = made.words();
    let mut rows: Vec<&Row> = made.timed.rows.iter().collect();
    rows.sort_by_key(|row| when(made, row).map_or((true, Time::ZERO), |(start, _)| (false, start)));
    let mut table =
        out::table(&["id", "activity", "priority", "status", "start", "end", "takes", "why"]);
    for row in rows {
        let slot = when(made, row);
        let time = |at: Option<Time>| Cell::new(at.map_or_else(String::new, |at| words.time(at)));
        let takes = slot.map_or_else(String::new, |(start, end)| span(end.since(start).get()));
        table.add_row([
            right(row.id.get()),
            Cell::new(name(made, row)),
            right(priority(made, row)),
            state(made, row),
            time(slot.map(|slot| slot.0)),
            time(slot.map(|slot| slot.1)),
            right(takes),
            Cell::new(why(row, &words)),
        ]);
    }
    table
}

fn right(text: impl std::fmt::Display) -> Cell {
    Cell::new(text).set_alignment(CellAlignment::Right)
}

fn when(made: &Made, row: &Row) -> Option<(Time, Time)> {
    let slot = made.timed.slot(row.id).map(|slot| (slot.start, slot.end));
    let ended = made.state.ended.iter().find(|ended| ended.id == row.id);
    slot.or_else(|| ended.and_then(|ended| Some((ended.started?, ended.ended))))
}

fn name(made: &Made, row: &Row) -> String {
    made.activity(row.id).and_then(|activity| activity.name.clone()).unwrap_or_default()
}

fn priority(made: &Made, row: &Row) -> String {
    let Some(activity) = made.activity(row.id) else { return String::new() };
    let mark = if made.is_mandatory(activity) { "mandatory " } else { "" };
    format!("{mark}{}", activity.priority)
}

fn state(made: &Made, row: &Row) -> Cell {
    let style = match &row.fate {
        Fate::Scheduled(_) | Fate::Running(_) => out::GOOD,
        Fate::Out(_) if made.is_missed(row) => out::BAD,
        Fate::Out(_) => out::ODD,
        Fate::Ended(_) => out::FAINT,
    };
    out::cell(style, status(&row.fate).replace('_', " "))
}

fn why(row: &Row, words: &Words<'_>) -> String {
    match &row.fate {
        Fate::Out(reason) => words.reason(reason),
        _ => String::new(),
    }
}

fn awake(made: &Made) -> io::Result<()> {
    let words = made.words();
    let phases = made.timed.awake.iter().map(|phase| {
        let long = span(phase.down.since(phase.up).get());
        let why = if is_idle(made, phase) { BATTERY_FULL } else { "" };
        let (wakeup, asleep) = (words.time(phase.wakeup), words.time(phase.asleep));
        format!("{wakeup} to {asleep}, up for {long}{why}")
    });
    listed("Awake", &phases.collect::<Vec<_>>())?;
    let heated = made.timed.preheats.iter().map(|preheat| {
        let long = span(preheat.end.since(preheat.start).get());
        format!("{} from {} for {long}", preheat.zone, words.time(preheat.start))
    });
    listed("Heated", &heated.collect::<Vec<_>>())
}

/// Why the computer is up where nothing needs it.
const BATTERY_FULL: &str = ": nothing to do, but the battery is at its maximum";

/// Whether it wakes up for nothing but the battery's maximum.
fn is_idle(made: &Made, phase: &AwakePhase) -> bool {
    let meets = |from: Time, until: Time| from < phase.asleep && phase.wakeup < until;
    let slots = made.timed.rows.iter().filter_map(|row| made.timed.slot(row.id));
    let windows = made.state.windows.iter().filter(|window| window.awake);
    let needs = slots.map(|slot| (slot.start, slot.end));
    let needs = needs.chain(windows.map(|window| (window.start, window.end)));
    let needs = needs.chain(made.timed.preheats.iter().map(|heat| (heat.start, heat.end)));
    // What was begun before now may have had its reason then.
    phase.wakeup > made.state.now && !needs.into_iter().any(|(from, until)| meets(from, until))
}

/// One line for each activity and each limit.
fn explanations(made: &Made, words: &Words<'_>) -> io::Result<()> {
    let lines = made.explanations.iter().flatten().flat_map(|(id, said)| {
        let name = words.activity(*id);
        said.iter().map(move |said| format!("{name}: {said}"))
    });
    let heading = "What would let them in at their turn, each by itself, and when they would start";
    listed(heading, &lines.collect::<Vec<_>>())
}

fn listed(heading: &str, lines: &[String]) -> io::Result<()> {
    if lines.is_empty() {
        return Ok(());
    }
    out::line(format_args!("\n{heading}:"))?;
    lines.iter().try_for_each(|line| out::line(format_args!("  {line}")))
}

fn verdict(made: &Made) -> String {
    let rows = &made.timed.rows;
    let within = rows.iter().filter(|row| made.timed.slot(row.id).is_some()).count();
    let out = rows.iter().filter(|row| matches!(row.fate, Fate::Out(_))).count();
    let missed: Vec<_> = made.missed().map(|row| made.words().activity(row.id)).collect();
    let plural = if within == 1 { "activity" } else { "activities" };
    let counts = format!("{within} {plural} scheduled, {out} left out");
    match missed.as_slice() {
        [] => format!("{}: {counts}", out::styled(out::GOOD, "every mandatory activity is in")),
        missed => {
            let said = out::styled(out::BAD, "mandatory activities are left out");
            format!("{said}: {}; {counts}", missed.join(", "))
        }
    }
}
