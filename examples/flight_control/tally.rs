//! What one thread did, and how it was scheduled.

use std::fmt;

use comfy_table::{CellAlignment, Table, presets};
use faregate::prelude::*;

use crate::rhythm::Rhythm;

/// What one thread did, and how it was scheduled.
pub(crate) struct Tally {
    name: &'static str,
    /// The scheduler's priority that the host gave it, or why it did not.
    pub(crate) fifo: Result<u8, String>,
    period: Duration,
    cycles: u64,
    slips: u64,
    latest: Duration,
    issued: u32,
    /// How many commands were refused.
    pub(crate) refused: u32,
    /// The latest more important ticket that a refusal named.
    pub(crate) taken_by: Option<TicketId>,
    faults: u32,
}

impl Tally {
    /// Begins to count, on the thread itself: it asks for its priority here.
    pub(crate) fn begin(name: &'static str, fifo: u8) -> Self {
        let zero = Duration::ZERO;
        Self {
            name,
            fifo: ask_for(fifo).map(|()| fifo),
            period: zero,
            cycles: 0,
            slips: 0,
            latest: zero,
            issued: 0,
            refused: 0,
            taken_by: None,
            faults: 0,
        }
    }

    /// Counts a command; answers whether it was issued.
    pub(crate) fn count<R, F: fmt::Debug>(&mut self, result: Result<R, InvokeError<F>>) -> bool {
        let issued = result.is_ok();
        self.issued += u32::from(issued);
        match result.map_err(|error| error.refusal()) {
            Ok(_) => {}
            Err(Some(refusal)) => {
                self.refused += 1;
                self.note(Err(refusal));
            }
            Err(None) => self.faults += 1,
        }
        issued
    }

    /// Looks who took the ticket, if somebody did.
    pub(crate) fn note(&mut self, result: Result<(), Refusal>) {
        if let Err(Refusal::NotValid(Why::Preempted { by, .. })) = result {
            self.taken_by = Some(by);
        }
    }

    /// The flight is over.
    pub(crate) fn end(mut self, rhythm: &Rhythm) -> Self {
        (self.period, self.cycles) = (rhythm.period, rhythm.cycles);
        (self.slips, self.latest) = (rhythm.slips, rhythm.latest);
        self
    }
}

#[cfg(target_os = "linux")]
fn ask_for(fifo: u8) -> Result<(), String> {
    use faregate::runtime::realtime::RealTime;
    let report = RealTime::request().prefaulted_stack(64 * 1024).fifo(fifo).apply();
    if report.is_complete() { Ok(()) } else { Err(report.to_string()) }
}

#[cfg(not(target_os = "linux"))]
fn ask_for(_: u8) -> Result<(), String> {
    Err("this host has no real-time scheduling that we know of".into())
}

/// All tallies, side by side.
pub(crate) fn table(tallies: &[&Tally]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    let header = ["thread", "period", "FIFO", "cycles", "slips", "latest by", "issued", "refused"];
    table.set_header(header);
    for tally in tallies {
        table.add_row([
            tally.name.to_owned(),
            tally.period.to_string(),
            tally.fifo.as_ref().map_or("no".into(), u8::to_string),
            tally.cycles.to_string(),
            tally.slips.to_string(),
            tally.latest.to_string(),
            tally.issued.to_string(),
            tally.refused.to_string(),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
