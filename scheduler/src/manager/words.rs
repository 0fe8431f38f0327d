//! What the manager says, in words for people: one line for each change.

use core::fmt;

use crate::manager::{Exit, HeldBy, Note, WaitsFor};
use crate::task::Outcome;

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Aborted => "aborted",
            Self::Missed => "missed",
        })
    }
}

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Code(code) => write!(f, "exit code {code}"),
            Self::Signal(signal) => write!(f, "signal {signal}"),
            Self::Panicked(why) => write!(f, "panicked: {why}"),
            Self::Failed(why) => write!(f, "failed: {why}"),
            Self::NotStarted(why) => write!(f, "not started: {why}"),
        }
    }
}

impl fmt::Display for HeldBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Task(task) => write!(f, "{task} has"),
            Self::GapOf(task) => write!(f, "the gap after {task} keeps"),
            Self::Unknown => f.write_str("somebody has"),
        }
    }
}

impl fmt::Display for WaitsFor {
    /// Reads on after *waits for*.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time => f.write_str("its time"),
            Self::Dependency(task) => write!(f, "the end of {task}"),
            Self::Categories { shared, by } => write!(f, "categories {shared}, which {by}"),
            Self::Gate { gate, by } => write!(f, "{gate}, which {by}"),
            Self::Draw { short_by } => write!(f, "draw: {short_by} are missing"),
            Self::Memory { short_by } => write!(f, "memory: {short_by} bytes are missing"),
            Self::Storage { short_by } => write!(f, "storage: {short_by} bytes are missing"),
            Self::Battery { now: None, .. } => f.write_str("the battery: no battery estimate"),
            Self::Battery { now: Some(now), wanted } => {
                write!(f, "the battery: {wanted} % wanted, {now} % there")
            }
            Self::Slot => f.write_str("a place among those that run"),
            Self::Mode(mode) => write!(f, "the end of mode {mode}"),
            Self::Held => f.write_str("a telecommand: it is held"),
            Self::MoreImportant(task) => write!(f, "{task}, which is more important"),
            Self::Tickets(why) => write!(f, "tickets: {why}"),
            Self::HandOver => f.write_str("its tickets, which are being handed over"),
        }
    }
}

impl WaitsFor {
    /// Reads on after *is stopped for*, as the agents say it of who took its
    /// tickets: a task waits for the end of a mode, and is stopped for the mode.
    pub(crate) fn stops(&self) -> String {
        match self {
            Self::Mode(mode) => format!("mode {mode}"),
            Self::MoreImportant(task)
            | Self::Categories { by: HeldBy::Task(task), .. }
            | Self::Gate { by: HeldBy::Task(task), .. } => task.to_string(),
            other => other.to_string(),
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Accepted(task) => write!(f, "{task} accepted"),
            Self::Removed(task) => write!(f, "{task} removed"),
            Self::Waits { occurrence, waits_for } => {
                write!(f, "{occurrence} waits for {waits_for}")
            }
            Self::Started(attempt) => write!(f, "{attempt} started"),
            Self::Stopping { attempt, why } => write!(f, "{attempt} is being stopped: {why}"),
            Self::Paused(attempt) => write!(f, "{attempt} paused"),
            Self::Resumed(attempt) => write!(f, "{attempt} resumed"),
            Self::Preempted(attempt) => write!(f, "{attempt} pre-empted, to be run again"),
            Self::Over { attempt, exit, outcome } => write!(f, "{attempt} {outcome} ({exit})"),
            Self::Ended { occurrence, outcome } => write!(f, "{occurrence} {outcome}"),
            Self::Missed { task, first, last, why, .. } if first == last => {
                write!(f, "{task} missed occurrence {first}: {why}")
            }
            Self::Missed { task, first, last, count, why } => {
                write!(f, "{task} missed {count} occurrences, {first} to {last}: {why}")
            }
            Self::NeverRuns { task, why } => write!(f, "{task} never runs: {why}"),
            Self::Overran { attempt, duration } => {
                write!(f, "{attempt} runs longer than its {duration}")
            }
            Self::Runaway(attempt) => write!(f, "{attempt} did not return: its worker is lost"),
            Self::Mode { name, entered: true } => write!(f, "mode {name} entered"),
            Self::Mode { name, entered: false } => write!(f, "mode {name} left"),
        }
    }
}
