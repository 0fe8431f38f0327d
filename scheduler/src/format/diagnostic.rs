//! What is wrong with a file, where, and what to do about it.

use core::fmt;
use core::ops::Range;

use serde::Serialize;

use crate::format::wrong::{Wrong, harmless};

/// Whether a file with this in it is loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Nothing of the file is loaded.
    Error,
    /// The file is loaded, and somebody should look at this.
    Warning,
}

/// Which rule was broken: a name that tools can rely on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(into = "&'static str")]
pub enum Rule {
    /// The file is no UTF-8 text.
    Encoding,
    /// Nobody knows in which format the file is.
    Format,
    /// The file is not TOML.
    Syntax,
    /// A quote is not closed, or stands in the wrong place.
    Quote,
    /// A file with columns does not say which.
    Header,
    /// A row has more fields than the header.
    ExtraFields,
    /// Something that must be there is not.
    Missing,
    /// A column, key or word that nobody knows.
    Unknown,
    /// Something that may be there once is there twice, or two things that
    /// exclude each other are.
    Duplicate,
    /// Not what can be read there: a word where a number belongs.
    Value,
    /// A number that is too large, too small, or too fine.
    Range,
    /// The window ends before it starts, or the cutoff is before it.
    Window,
    /// A body that does not fit its type.
    Body,
    /// A task that nobody knows is referred to.
    UnknownTask,
    /// A category, gate, agent or mode that the mission does not have.
    UnknownName,
    /// Tasks wait for each other in a circle.
    Cycle,
    /// A state of charge is asked for, and the mission has no battery.
    NoBattery,
    /// The task can never run: it needs more than there is.
    NeverRuns,
    /// The body cannot be pre-empted in this way.
    Preemption,
    /// A task that runs once may run twice, or a policy has no effect.
    Restart,
    /// What a shell would act on, and there is no shell.
    NoShell,
    /// What is written has no effect.
    NoEffect,
    /// An activity that nobody knows is referred to.
    UnknownActivity,
    /// A field that does not fit the kind of what has it.
    Kind,
    /// An energy that is not the power times the duration.
    Energy,
    /// An activity is more important than one that it depends on.
    Importance,
    /// A table whose rows are not in order, or do not begin at 0.
    Table,
    /// Limits that contradict each other.
    Limits,
    /// Something was taken for granted that another file would tell.
    Assumed,
    /// A version of a format that this program does not know.
    Version,
    /// A binary file that is not what was written.
    Damaged,
}

impl Rule {
    /// All of them.
    pub const ALL: [Self; 31] = [
        Self::Encoding,
        Self::Format,
        Self::Syntax,
        Self::Quote,
        Self::Header,
        Self::ExtraFields,
        Self::Missing,
        Self::Unknown,
        Self::Duplicate,
        Self::Value,
        Self::Range,
        Self::Window,
        Self::Body,
        Self::UnknownTask,
        Self::UnknownName,
        Self::Cycle,
        Self::NoBattery,
        Self::NeverRuns,
        Self::Preemption,
        Self::Restart,
        Self::NoShell,
        Self::NoEffect,
        Self::UnknownActivity,
        Self::Kind,
        Self::Energy,
        Self::Importance,
        Self::Table,
        Self::Limits,
        Self::Assumed,
        Self::Version,
        Self::Damaged,
    ];

    /// Those that files of the planner alone can break: `docs/plan-format.md`
    /// has them.
    pub const PLANNER: [Self; 9] = [
        Self::UnknownActivity,
        Self::Kind,
        Self::Energy,
        Self::Importance,
        Self::Table,
        Self::Limits,
        Self::Assumed,
        Self::Version,
        Self::Damaged,
    ];

    /// Its name, as tools see it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Encoding => "encoding",
            Self::Format => "format",
            Self::Syntax => "syntax",
            Self::Quote => "quote",
            Self::Header => "header",
            Self::ExtraFields => "extra-fields",
            Self::Missing => "missing",
            Self::Unknown => "unknown",
            Self::Duplicate => "duplicate",
            Self::Value => "value",
            Self::Range => "range",
            Self::Window => "window",
            Self::Body => "body",
            Self::UnknownTask => "unknown-task",
            Self::UnknownName => "unknown-name",
            Self::Cycle => "cycle",
            Self::NoBattery => "no-battery",
            Self::NeverRuns => "never-runs",
            Self::Preemption => "preemption",
            Self::Restart => "restart",
            Self::NoShell => "no-shell",
            Self::NoEffect => "no-effect",
            Self::UnknownActivity => "unknown-activity",
            Self::Kind => "kind",
            Self::Energy => "energy",
            Self::Importance => "importance",
            Self::Table => "table",
            Self::Limits => "limits",
            Self::Assumed => "assumed",
            Self::Version => "version",
            Self::Damaged => "damaged",
        }
    }
}

impl From<Rule> for &'static str {
    fn from(rule: Rule) -> Self {
        rule.name()
    }
}

/// Where something stands in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub struct Place {
    /// Its line, from 1.
    pub line: usize,
    /// Its column, from 1, in characters.
    pub column: usize,
    /// Its bytes, a byte order mark not counted.
    pub span: Range<usize>,
}

/// Something that is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Whether the file is loaded all the same.
    pub severity: Severity,
    /// Which rule was broken.
    pub rule: Rule,
    /// The file's name, as it was given.
    pub file: String,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// Which column or key; none: the row or the file.
    pub field: Option<String>,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub expected: Option<String>,
    /// What to do.
    pub help: Option<String>,
    /// The other place, where there are two.
    pub also: Option<Also>,
}

/// Another place that has to do with it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Also {
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// What is there.
    pub message: String,
}

impl Diagnostic {
    /// This, at this place of a file: without control characters, which a
    /// terminal would obey. Names of columns, gates and files are what somebody
    /// else wrote.
    pub(crate) fn of(severity: Severity, file: &str, place: Place, wrong: Wrong) -> Self {
        Self {
            severity,
            rule: wrong.rule,
            file: harmless(file.to_owned()),
            place,
            field: None,
            message: harmless(wrong.message),
            expected: wrong.expected.map(harmless),
            help: wrong.help.map(harmless),
            also: None,
        }
    }

    /// Whether nothing of the file is loaded because of it.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

impl fmt::Display for Diagnostic {
    /// On one line, as compilers do: `file:line:column: error: message`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { line, column, .. } = self.place;
        let severity = if self.is_error() { "error" } else { "warning" };
        write!(f, "{}:{line}:{column}: {severity}: {}", self.file, self.message)?;
        match &self.expected {
            Some(expected) => write!(f, "; expected {expected}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_one_line_it_reads_as_compilers_say_it() {
        let place = Place { line: 3, column: 7, span: 20..21 };
        let told = |wrong: Wrong| {
            Diagnostic::of(Severity::Error, "a.csv", place.clone(), wrong).to_string()
        };
        let wrong = Wrong::new(Rule::NoBattery, "no battery");
        assert_eq!(told(wrong.clone()), "a.csv:3:7: error: no battery");
        assert_eq!(told(wrong.expected("0")), "a.csv:3:7: error: no battery; expected 0");
    }
}
