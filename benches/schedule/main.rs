//! What the schedule manager costs: decisions, and how they grow with the
//! schedule.
//!
//! `cargo bench --bench schedule`. Rows 13 to 16 of the targets in
//! `docs/performance.md`. The peer is SMAARTE's own algorithm: sort by
//! priority, then sweep the whole schedule, at each event.

mod decisions;
#[path = "../../scheduler/tests/support/week.rs"]
mod fixture;
mod smaarte;
#[path = "../support/mod.rs"]
mod support;
mod week;
mod world;

use std::process::ExitCode;

fn main() -> ExitCode {
    support::run("schedule", |bench| {
        decisions::measure(bench)?;
        week::measure(bench)
    })
}
