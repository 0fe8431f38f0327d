//! The journal: what a manager must not forget, on a disk.
//!
//! A manager's [`Record`]s are appended before what they tell of is done. After
//! the process has died, of whatever, [`Journal::open`] gives back what they
//! add up to. What was *committed* survives the death of the process; what was
//! *synced* survives the loss of power, too.
//!
//! ```
//! use faregate_scheduler::journal::{Journal, Options};
//! use faregate_scheduler::manager::Record;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let directory = tempfile::tempdir()?;
//! # let path = directory.path().join("journal");
//! let entered = Record::Mode { name: "eclipse".into(), entered: true };
//! let (mut journal, restored, opened) = Journal::open(&path, Options::default())?;
//! assert!(opened.clean && restored.modes.is_empty());
//! journal.append(&entered)?;
//! journal.sync()?;
//! drop(journal); // As if the process had died: it was not closed.
//!
//! let (_journal, restored, opened) = Journal::open(&path, Options::default())?;
//! assert!(!opened.clean);
//! assert_eq!(restored.modes, ["eclipse"]);
//! # Ok(())
//! # }
//! ```
//!
//! # The parts
//!
//! | part | what |
//! |---|---|
//! | [`replay`](mod@replay) | what records add up to |
//! | [`storage`] | what a journal needs of a disk |
//! | [`memory`] | a disk in memory, whose power can be cut |
//! | [`points`] | where a test kills the process |

mod compact;
mod entry;
mod error;
mod file;
mod frame;
pub mod memory;
mod open;
pub mod points;
pub mod replay;
mod segment;
pub mod storage;
mod sum;
mod writer;

use std::io;
use std::path::Path;
use std::sync::Arc;

pub use error::JournalError;
pub use open::Opened;
pub use replay::{Replay, replay, replay_bytes};

use crate::executive::JournalSink;
use crate::manager::{Record, Restored};
use compact::{Compactor, Step};
use entry::Entry;
use storage::Storage;
use writer::Writer;

/// How a journal is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// The log is compacted when it is longer than this, in bytes, and longer
    /// than twice what the compaction before left.
    pub compact_above: u64,
    /// Who compacts.
    pub compaction: Compaction,
    /// What is done about damage.
    pub damage: Damage,
}

/// Who makes a snapshot of a log that has grown long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compaction {
    /// A thread of its own, started by [`Journal::open`]. It inherits the
    /// opener's scheduling: a real-time thread raises itself afterwards.
    Background,
    /// Whoever calls [`Journal::sync`], and waits for it. For simulations.
    Inline,
    /// Nobody.
    Never,
}

/// What [`Journal::open`] does about bytes that were durable and are not what
/// was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// Refuses, and says where they are.
    Refuse,
    /// Goes on with what comes before them, and keeps a copy of the damaged
    /// files. Tasks that were accepted later are lost, and attempts that began
    /// later may be made again: that is for people to weigh.
    KeepWhatPrecedes,
}

impl Default for Options {
    fn default() -> Self {
        Self { compact_above: 4 << 20, compaction: Compaction::Background, damage: Damage::Refuse }
    }
}

/// An open journal. Nobody else has the same one open.
///
/// To drop it is to leave it as a process does that dies. [`Journal::close`]
/// says that nothing was lost.
#[derive(Debug)]
pub struct Journal {
    storage: Arc<dyn Storage>,
    writer: Writer,
    compactor: Compactor,
}

impl Journal {
    /// Opens the journal in this directory, or makes an empty one.
    ///
    /// # Errors
    ///
    /// When another process has it open, when its files cannot be read or
    /// written, are damaged, or were written by another version.
    pub fn open(path: &Path, options: Options) -> Result<(Self, Restored, Opened), JournalError> {
        Self::open_on(Arc::new(file::Directory::open(path)?), options)
    }

    /// Opens the journal on any storage.
    ///
    /// # Errors
    ///
    /// As [`Journal::open`], but for the other process: storage knows of that.
    pub fn open_on(
        storage: Arc<dyn Storage>,
        options: Options,
    ) -> Result<(Self, Restored, Opened), JournalError> {
        let (writer, restored, opened) = open::open(&storage, options.damage)?;
        let compactor = Compactor::new(&storage, options, opened.snapshot_bytes);
        Ok((Self { storage, writer, compactor }, restored, opened))
    }

    /// Adds a record to the batch that [`commit`](Self::commit) or
    /// [`sync`](Self::sync) writes. Nothing of a batch survives without the
    /// rest of it.
    ///
    /// # Timing
    ///
    /// No system call.
    ///
    /// # Errors
    ///
    /// When the batch becomes longer than a journal can read again; it is then
    /// as it was.
    pub fn append(&mut self, record: &Record) -> Result<(), JournalError> {
        self.writer.append(&Entry::Record(record))
    }

    /// Writes the batch: it survives the death of this process.
    ///
    /// # Timing
    ///
    /// One `write` of one batch, into the host's page cache. Nothing when there
    /// is no batch.
    ///
    /// # Errors
    ///
    /// When the storage fails or is full. The batch is kept, and may be
    /// committed again, unless the error is [`JournalError::Failed`].
    pub fn commit(&mut self) -> Result<(), JournalError> {
        self.writer.commit()
    }

    /// Writes the batch and waits until everything written is durable: it
    /// survives the loss of power.
    ///
    /// # Timing
    ///
    /// One `write`, one `fdatasync`: as slow as the disk.
    ///
    /// # Errors
    ///
    /// As [`commit`](Self::commit). A sync that failed is not tried again: the
    /// host has forgotten which bytes it did not write, so the journal refuses
    /// everything from then on.
    pub fn sync(&mut self) -> Result<(), JournalError> {
        self.writer.sync()?;
        match self.compactor.step(self.writer.len()) {
            Step::Nothing => Ok(()),
            Step::Switch(next) => {
                self.writer.switch_to(next);
                self.compactor.switched();
                Ok(())
            }
        }
    }

    /// Closes the journal in order: everything is durable, and the next one who
    /// opens it knows.
    ///
    /// # Errors
    ///
    /// As [`sync`](Self::sync).
    pub fn close(mut self) -> Result<(), JournalError> {
        self.writer.append(&Entry::Closed)?;
        self.writer.sync()
    }

    /// How long the log is that has not been compacted, in bytes.
    #[must_use]
    pub const fn log_bytes(&self) -> u64 {
        self.writer.len()
    }

    /// How often the log was compacted since it was opened.
    #[must_use]
    pub const fn compactions(&self) -> u64 {
        self.compactor.done()
    }

    /// The storage it is on.
    #[must_use]
    pub fn storage(&self) -> &Arc<dyn Storage> {
        &self.storage
    }
}

impl JournalSink for Journal {
    fn append(&mut self, record: &Record) -> io::Result<()> {
        Self::append(self, record).map_err(io::Error::other)
    }

    fn commit(&mut self) -> io::Result<()> {
        Self::commit(self).map_err(io::Error::other)
    }

    fn sync(&mut self) -> io::Result<()> {
        Self::sync(self).map_err(io::Error::other)
    }
}
