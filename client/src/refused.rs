//! Refusals as they are told over a port.

use core::fmt;

use serde::{Deserialize, Serialize};

/// A refusal: what a program goes by, and what a person reads.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refused {
    /// For programs.
    pub kind: RefusalKind,
    /// For people: which rule, by how much, who has what is needed.
    pub reason: String,
    /// Who took what is needed, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub taker: Option<String>,
    /// What is wrong with a schedule that was to be added; all at once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub problems: Vec<Problem>,
}

impl Refused {
    /// A refusal of this kind, for this reason.
    #[must_use]
    pub fn new(kind: RefusalKind, reason: impl Into<String>) -> Self {
        Self { kind, reason: reason.into(), taker: None, problems: Vec::new() }
    }

    /// The same, with who took what is needed.
    #[must_use]
    pub fn taken_by(mut self, taker: impl Into<String>) -> Self {
        self.taker = Some(taker.into());
        self
    }

    /// The same, with what is wrong with a schedule.
    #[must_use]
    pub fn with_problems(mut self, problems: Vec<Problem>) -> Self {
        self.problems = problems;
        self
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)?;
        for problem in &self.problems {
            write!(f, "\n{problem}")?;
        }
        Ok(())
    }
}

impl core::error::Error for Refused {}

/// Which refusal it is: what a program decides by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RefusalKind {
    /// The task's tickets were taken by somebody more important. They come back
    /// in their turn.
    Preempted,
    /// The task's tickets are not valid yet, or no longer, and nobody took them.
    Waiting,
    /// A supervisor barred the task.
    Barred,
    /// Safe mode, or a mode of the mission, keeps everybody from it.
    SafeMode,
    /// The ticket has expired.
    Expired,
    /// A validity function said no: a limit, a window, an interlock.
    Limit,
    /// The task did not declare that it commands this gate.
    NotDeclared,
    /// No gate has this name.
    UnknownGate,
    /// The gate has no command of this name.
    UnknownCommand,
    /// The arguments are not what the command takes.
    BadArguments,
    /// The device's driver failed, or its gate is out of service.
    Faulted,
    /// The attempt that asks is over.
    Over,
    /// Too much is asked at a time.
    Busy,
    /// No task has this number.
    UnknownTask,
    /// What was to be loaded or set has mistakes.
    Invalid,
    /// The manager does not do it: the reason says why.
    NotDone,
    /// The message is none, or too long.
    Malformed,
    /// The manager is of another version, and does not know what is asked.
    UnknownRequest,
    /// The port is another user's.
    NotPermitted,
    /// The manager stops.
    Stopping,
    /// Something that this version of the client does not know.
    #[serde(other)]
    Other,
}

/// A mistake in a schedule.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Problem {
    /// The line, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// The column, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<u64>,
    /// The field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// What is wrong, and what was expected.
    pub message: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}")?;
            if let Some(column) = self.column {
                write!(f, ", column {column}")?;
            }
            f.write_str(": ")?;
        }
        if let Some(field) = &self.field {
            write!(f, "{field}: ")?;
        }
        f.write_str(&self.message)
    }
}
