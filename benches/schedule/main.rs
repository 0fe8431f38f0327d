//! What the schedule manager costs: decisions, and how they grow with the
//! schedule.
//!
//! `cargo bench --bench schedule`. Rows 13 to 16 of the targets in
//! `docs/performance.md`. The peer is SMAARTE's own algorithm: sort by
//! priority, then sweep the whole schedule, at each event.

mod decisions;
#[expect(dead_code, reason = "a fixture of the scheduler's own tests")]
#[path = "../../scheduler/tests/support/week.rs"]
mod fixture;
#[cfg(target_os = "linux")]
mod lateness;
#[cfg(target_os = "linux")]
mod resume;
#[cfg(target_os = "linux")]
mod scene;
mod smaarte;
#[path = "../support/mod.rs"]
mod support;
mod week;
mod world;

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    if let Some(done) = resume::as_child() {
        return done;
    }
    support::run("schedule", |bench| {
        decisions::measure(bench)?;
        week::measure(bench)?;
        #[cfg(target_os = "linux")]
        {
            resume::measure(bench)?;
            lateness::measure(bench)?;
        }
        Ok(())
    })
}
