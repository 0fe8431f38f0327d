//! What the schedule manager costs: decisions, and how they grow with the
//! schedule.
//!
//! `cargo bench --bench schedule`. Rows 13 to 16 of the targets in
//! `docs/performance.md`. The peer is SMAARTE's own algorithm: sort by
//! priority, then sweep the whole schedule, at each event.

#[cfg(target_os = "linux")]
#[expect(dead_code, reason = "the curves need more of it")]
#[path = "../curves/count.rs"]
mod count;
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
#[cfg(target_os = "linux")]
mod steps;
mod stream;
#[path = "../support/mod.rs"]
mod support;
mod week;
mod world;

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    if let Some(done) = resume::as_child().or_else(|| count::as_child(steps::cases)) {
        return done;
    }
    support::run("schedule", |bench| {
        // First what forks: a fork copies the tables of all memory in use.
        #[cfg(target_os = "linux")]
        {
            lateness::measure(bench)?;
            resume::measure(bench)?;
            steps::measure(bench)?;
        }
        decisions::measure(bench)?;
        week::measure(bench)
    })
}
