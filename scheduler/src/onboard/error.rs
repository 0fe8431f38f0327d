//! Why a schedule cannot be run on this host.

use core::fmt;
use std::io;
use std::path::PathBuf;

use crate::journal::JournalError;
use crate::tickets::NotInstalled;

/// Why a schedule cannot be run here.
#[derive(Debug)]
#[non_exhaustive]
pub enum NotOnboard {
    /// The host lacks something.
    Host(io::Error),
    /// The mission's broker cannot be put together.
    Installation(NotInstalled),
    /// The mission says nothing of a device with this name.
    UnknownDevice(String),
    /// Devices of the mission that no driver was given for.
    NoDriver(Vec<String>),
    /// The journal cannot be used.
    Journal(JournalError),
    /// Telecommands cannot be taken there.
    Control(PathBuf, io::Error),
    /// The schedule was refused.
    Refused(String),
}

impl fmt::Display for NotOnboard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Host(error) => write!(f, "the host has no room for a run: {error}"),
            Self::Installation(why) => why.fmt(f),
            Self::UnknownDevice(name) => write!(f, "the mission has no device `{name}`"),
            Self::NoDriver(names) => write!(f, "no driver was given for {}", names.join(", ")),
            Self::Journal(error) => error.fmt(f),
            Self::Control(path, error) => {
                write!(f, "no telecommands can be taken at {}: {error}", path.display())
            }
            Self::Refused(why) => write!(f, "the schedule is not accepted: {why}"),
        }
    }
}

impl std::error::Error for NotOnboard {}

impl From<io::Error> for NotOnboard {
    fn from(error: io::Error) -> Self {
        Self::Host(error)
    }
}

impl From<NotInstalled> for NotOnboard {
    fn from(why: NotInstalled) -> Self {
        Self::Installation(why)
    }
}

impl From<JournalError> for NotOnboard {
    fn from(error: JournalError) -> Self {
        Self::Journal(error)
    }
}
