//! How a run went.

use std::fmt;

use faregate_tickets::clock::Instant;

/// How a run went. Two runs of the same bodies with the same seed have equal
/// reports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// Why it is over.
    pub over: Over,
    /// The virtual time at its end.
    pub at: Instant,
    /// How each body ended, in the order in which they were spawned.
    pub ends: Vec<(&'static str, End)>,
    /// How often somebody was picked to run.
    pub choices: u64,
    /// How often a body was entered; the difference went on without a switch.
    pub resumes: u64,
    /// A digest of who passed which switch point when: equal for equal
    /// schedules, and for hardly any others.
    pub fingerprint: u64,
    /// Every switch point passed, if [`log`](super::Interleaver::log) was
    /// asked for.
    pub log: Vec<Switch>,
}

impl Report {
    /// How the body of this name ended.
    #[must_use]
    pub fn end_of(&self, name: &str) -> Option<End> {
        self.ends.iter().find(|(other, _)| *other == name).map(|(_, end)| *end)
    }
}

/// Why a run is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Over {
    /// Every body came to its end.
    Finished,
    /// The time was up.
    Horizon,
    /// A body called [`stop`](super::stop).
    Stopped,
    /// Everybody waits for somebody, and nobody for a time.
    Stalled,
    /// The bodies go on and on without any time passing.
    Livelocked,
}

/// How a body ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum End {
    /// It returned.
    Finished,
    /// It called [`die`](super::die), and unwound.
    Died,
    /// It was still there when the run was over, and was unwound then.
    Abandoned,
    /// It was still there when the run was over and would not unwind: it waits
    /// for ever in a destructor. Its stack stays allocated.
    Leaked,
}

/// A switch point that a body passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Switch {
    /// When.
    pub at: Instant,
    /// Who.
    pub body: &'static str,
    /// Where.
    pub what: &'static str,
}

impl fmt::Display for Switch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}: {}", self.at, self.body, self.what)
    }
}
