//! The timed plan, executed by the schedule manager: what is planned runs when it
//! is planned, and what becomes of it comes back.
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

mod attacks;
mod early;
mod fits;
mod handover;
#[cfg(target_os = "linux")]
mod lamps;
mod limits;
#[cfg(target_os = "linux")]
mod onboard;
mod small;
mod sol;
mod sooner;
mod stage;
mod tickets;
