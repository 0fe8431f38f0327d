//! What can go wrong on the way to a manager.

use core::fmt;
use std::io;
use std::time::Duration;

use crate::Refused;

/// Why something was not done.
#[derive(Debug)]
pub enum Error {
    /// The manager refused.
    Refused(Refused),
    /// There is no port; the text says what was looked for.
    NoPort(String),
    /// The manager has closed the port: the attempt is over, the manager has
    /// stopped, or what was said to it was no message.
    Closed,
    /// The manager speaks another protocol.
    Version {
        /// What it speaks.
        theirs: u32,
    },
    /// The manager's answer is none.
    NotUnderstood(String),
    /// What is to be sent is longer than a message may be.
    TooLong {
        /// Its length in bytes.
        length: usize,
        /// The longest.
        limit: usize,
    },
    /// No answer came in time. What was asked may be done nevertheless.
    NoAnswer {
        /// How long was waited.
        within: Duration,
    },
    /// The operating system refused.
    Io(io::Error),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(refused) => refused.fmt(f),
            Self::NoPort(why) => f.write_str(why),
            Self::Closed => f.write_str("the manager has closed the port"),
            Self::Version { theirs } => write!(
                f,
                "the manager speaks version {theirs} of the protocol, this program version {}: \
                 use the one that came with the manager",
                crate::PROTOCOL
            ),
            Self::NotUnderstood(why) => write!(f, "the manager's answer is not understood: {why}"),
            Self::TooLong { length, limit } => {
                write!(f, "{length} bytes are more than the {limit} of one message")
            }
            Self::NoAnswer { within } => write!(
                f,
                "no answer within {} s; what was asked may be done nevertheless",
                within.as_secs_f64()
            ),
            Self::Io(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for Error {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Refused(refused) => Some(refused),
            Self::Io(error) => Some(error),
            _ => None,
        }
    }
}

impl From<Refused> for Error {
    fn from(refused: Refused) -> Self {
        Self::Refused(refused)
    }
}

impl From<io::Error> for Error {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<rustix::io::Errno> for Error {
    fn from(error: rustix::io::Errno) -> Self {
        Self::Io(error.into())
    }
}
