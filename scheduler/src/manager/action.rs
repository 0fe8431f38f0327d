//! What the manager asks of its executive.

use crate::manager::{Attempt, Note, Occurrence, Record, Reply, TelecommandId};
use crate::time::Duration;

/// Something to be done, in this order. An executive that fails to do it says
/// so by an event.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Write this to the journal.
    Journal(Record),
    /// Everything written so far is durable before anything that follows.
    Sync,
    /// Ask for tickets: what [`Manager::needs`](crate::Manager::needs) says of
    /// the occurrence, all or nothing.
    Request {
        /// For which occurrence.
        occurrence: Occurrence,
        /// Whose tickets it is to take: each is told by
        /// [`Event::Taken`](crate::manager::Event::Taken), before this one is
        /// granted.
        victims: Vec<Occurrence>,
    },
    /// Give the tickets of the occurrence back: it is over, or need not wait
    /// any more.
    Relinquish {
        /// Whose.
        occurrence: Occurrence,
    },
    /// Start a body; its task is [`Manager::task`](crate::Manager::task).
    Start {
        /// Which attempt.
        attempt: Attempt,
    },
    /// Stop a body, so that it can go on or be run again.
    Stop {
        /// Which attempt.
        attempt: Attempt,
        /// How.
        how: Stop,
        /// For whom, for people.
        why: StopWhy,
    },
    /// Let a stopped body go on. Its devices were made safe meanwhile.
    Continue {
        /// Which attempt.
        attempt: Attempt,
    },
    /// Run the manager's own function: load this file, beside what is there,
    /// and tell what came of it by
    /// [`Event::Exited`](crate::manager::Event::Exited).
    Load {
        /// Which attempt it is the body of.
        attempt: Attempt,
        /// The file.
        path: String,
    },
    /// Take these gates from everybody, as long as the mode lasts.
    Reserve {
        /// The mode's name.
        mode: String,
    },
    /// Give the mode's gates back.
    Unreserve {
        /// The mode's name.
        mode: String,
    },
    /// Answer a telecommand.
    Answer {
        /// Which one.
        id: TelecommandId,
        /// What.
        reply: Reply,
    },
    /// Tell people.
    Note(Note),
}

/// How a body is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stop {
    /// Stopped where it is; answered by
    /// [`Event::Stopped`](crate::manager::Event::Stopped).
    Pause,
    /// Told, and after the grace killed; answered by
    /// [`Event::Exited`](crate::manager::Event::Exited).
    Checkpoint {
        /// How long it has.
        grace: Duration,
        /// The signal that tells a process.
        signal: crate::task::CheckpointSignal,
    },
    /// Terminated, and after the grace killed; answered by
    /// [`Event::Exited`](crate::manager::Event::Exited).
    Kill {
        /// How long it has.
        grace: Duration,
    },
}

/// Why a body is stopped.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum StopWhy {
    /// Its tickets were taken.
    Preempted {
        /// By whom, for people.
        by: String,
    },
    /// It ran too long, past its cutoff, was silent, used too much, or was
    /// ended by a telecommand.
    Aborted {
        /// Which, for people.
        why: String,
    },
}
