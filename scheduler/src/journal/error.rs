//! Why a journal cannot be opened or written, and what to do about it.

use core::fmt;
use std::io;
use std::path::PathBuf;

/// A journal that cannot be opened or written.
#[derive(Debug)]
#[non_exhaustive]
pub enum JournalError {
    /// Another process has the journal open.
    InUse {
        /// Its directory.
        path: PathBuf,
        /// Who has it, as they wrote it there.
        by: String,
    },
    /// The storage failed.
    Storage {
        /// What was being done.
        doing: &'static str,
        /// To which file.
        file: String,
        /// What the host said.
        source: io::Error,
    },
    /// Bytes that were durable are not what was written.
    Damaged {
        /// In which file.
        file: String,
        /// From which byte on.
        offset: u64,
        /// What is wrong there.
        what: &'static str,
    },
    /// The journal was written by another version.
    Version {
        /// Which file.
        file: String,
        /// Its format's version.
        found: u32,
        /// The version that this program reads and writes.
        known: u32,
    },
    /// A batch of records is too long to be read again.
    TooLong {
        /// How long it would be, in bytes.
        bytes: usize,
    },
    /// An earlier write or sync failed, and nobody knows what is durable.
    Failed,
}

impl JournalError {
    pub(super) fn storage(
        doing: &'static str,
        file: &str,
    ) -> impl FnOnce(io::Error) -> Self + use<> {
        let file = file.to_owned();
        move |source| Self::Storage { doing, file, source }
    }

    pub(super) fn damaged(file: &str, offset: u64, what: &'static str) -> Self {
        Self::Damaged { file: file.to_owned(), offset, what }
    }
}

impl fmt::Display for JournalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InUse { path, by } => write!(
                f,
                "the journal in {} is in use by {by}: end that one first, or choose another directory",
                path.display()
            ),
            Self::Storage { doing, file, source } => {
                write!(f, "{doing} the journal's file {file}: {source}")
            }
            Self::Damaged { file, offset, what } => write!(
                f,
                "the journal's file {file} is damaged at byte {offset}: {what}. Restore the \
                 directory from a copy; or open it keeping what precedes the damage: then tasks \
                 accepted later are lost, and attempts begun later may be made again"
            ),
            Self::Version { file, found, known } => write!(
                f,
                "the journal's file {file} has format {found}, and this program knows format \
                 {known}: go on with the program that wrote it, or let that one end its schedule \
                 and begin an empty journal"
            ),
            Self::TooLong { bytes } => write!(
                f,
                "{bytes} bytes of records at once are too many for the journal: load the schedule \
                 in parts"
            ),
            Self::Failed => f.write_str(
                "the journal failed earlier, and nobody knows what of it is durable: end the \
                 program, look after the disk, and start again",
            ),
        }
    }
}

impl std::error::Error for JournalError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Storage { source, .. } => Some(source),
            _ => None,
        }
    }
}
