//! What is printed, and where colours are.
//!
//! Everything is written with an error as its answer: a reader that goes away
//! ends the program quietly.

use std::fmt::Display;
use std::io::{self, Write};

use anstyle::{AnsiColor, Style};
use comfy_table::{Attribute, Cell, Color, ContentArrangement, LineStyle, Table, TableStyle};
use faregate_tickets::amount::Milliwatts;
use serde::Serialize;

/// A line on standard output.
pub(crate) fn line(text: impl Display) -> io::Result<()> {
    let mut out = anstream::stdout().lock();
    writeln!(out, "{text}")?;
    out.flush()
}

/// Exactly these bytes on standard output.
pub(crate) fn bytes(bytes: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(bytes)?;
    out.flush()
}

/// A document on standard output.
pub(crate) fn json(value: &impl Serialize) -> io::Result<()> {
    line(serde_json::to_string_pretty(value)?)
}

/// A document on one line of standard output.
pub(crate) fn json_line(value: &impl Serialize) -> io::Result<()> {
    line(serde_json::to_string(value)?)
}

/// A line on standard error. If that is gone, there is nobody to tell.
pub(crate) fn complain(text: impl Display) {
    let _ = writeln!(anstream::stderr(), "{text}");
}

/// A line under the header, and around the rows.
const RULED: TableStyle =
    TableStyle::new().top_border(RULE).header_separator(RULE).bottom_border(RULE);

const RULE: LineStyle = LineStyle::none().fill('─').junction('─');

/// A table that fits the terminal.
pub(crate) fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(RULED).set_content_arrangement(ContentArrangement::Dynamic).set_header(header);
    table
}

/// A cell of a table in one of these styles.
pub(crate) fn cell(style: Style, text: impl Display) -> Cell {
    let cell = Cell::new(text);
    match style {
        GOOD => cell.fg(Color::Green),
        ODD => cell.fg(Color::Yellow),
        BAD => cell.fg(Color::Red).add_attribute(Attribute::Bold),
        FAINT => cell.add_attribute(Attribute::Dim),
        STRONG => cell.add_attribute(Attribute::Bold),
        _ => cell,
    }
}

/// Power that was computed, to a tenth of a watt from one watt on.
pub(crate) fn about(power: Milliwatts) -> String {
    let tenths = power.get().saturating_add(50) / 100;
    match (tenths / 10, tenths % 10) {
        (0, _) => power.to_string(),
        (whole, 0) => format!("{whole} W"),
        (whole, tenth) => format!("{whole}.{tenth} W"),
    }
}

/// Something good.
pub(crate) const GOOD: Style = AnsiColor::Green.on_default();
/// Something to look at.
pub(crate) const ODD: Style = AnsiColor::Yellow.on_default();
/// Something bad.
pub(crate) const BAD: Style = AnsiColor::Red.on_default().bold();
/// Something beside the point.
pub(crate) const FAINT: Style = Style::new().dimmed();
/// A heading.
pub(crate) const STRONG: Style = Style::new().bold();

/// The text in this style, where the reader is a terminal.
pub(crate) fn styled(style: Style, text: impl Display) -> String {
    format!("{style}{text}{style:#}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_average_has_no_digits_that_say_nothing() {
        let shown =
            [32_947, 9_105, 1_000, 999_960, 950, 949, 12].map(|mw| about(Milliwatts::new(mw)));
        assert_eq!(shown, ["32.9 W", "9.1 W", "1 W", "1000 W", "1 W", "949 mW", "12 mW"]);
    }
}
