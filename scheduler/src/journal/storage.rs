//! What a journal needs of a disk: a few named files that grow at their ends.
//!
//! It is a port so that a simulation can lose power between any two writes.

use core::fmt::Debug;
use std::io;

use serde::{Deserialize, Serialize};

/// A place for files. Names are plain, without directories.
pub trait Storage: Send + Sync + Debug {
    /// The names of the files that are there, in any order.
    ///
    /// # Errors
    ///
    /// When the storage cannot be read.
    fn names(&self) -> io::Result<Vec<String>>;

    /// Everything that is in a file.
    ///
    /// # Errors
    ///
    /// When there is none, or it cannot be read.
    fn read(&self, name: &str) -> io::Result<Vec<u8>>;

    /// A new file, empty; one of the same name is replaced. The name is durable
    /// after [`sync_names`](Self::sync_names).
    ///
    /// # Errors
    ///
    /// When the storage cannot be written.
    fn create(&self, name: &str) -> io::Result<Box<dyn StoredFile>>;

    /// A file that is there, to be written at its end, after so many bytes of
    /// it: the rest is cut off.
    ///
    /// # Errors
    ///
    /// When there is none, or the storage cannot be written.
    fn append(&self, name: &str, keep: u64) -> io::Result<Box<dyn StoredFile>>;

    /// Removes a file.
    ///
    /// # Errors
    ///
    /// When there is none, or the storage cannot be written.
    fn remove(&self, name: &str) -> io::Result<()>;

    /// Makes durable which names there are.
    ///
    /// # Errors
    ///
    /// When the storage cannot be written.
    fn sync_names(&self) -> io::Result<()>;

    /// Which start of the host this is: between two equal ones, nothing that
    /// was written can have been lost.
    fn boot(&self) -> Boot;
}

/// A file that is written at its end.
pub trait StoredFile: Send + Debug {
    /// Writes after everything written before.
    ///
    /// # Errors
    ///
    /// When the storage is full or fails. Some of the bytes may then have been
    /// written; [`cut`](Self::cut) takes them back.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Cuts the file off after so many bytes, and goes on writing there.
    ///
    /// # Errors
    ///
    /// When the storage fails.
    fn cut(&mut self, keep: u64) -> io::Result<()>;

    /// Waits until everything written is durable.
    ///
    /// # Errors
    ///
    /// When the storage fails. What was written since the last sync may or may
    /// not be durable, now or ever.
    fn sync(&mut self) -> io::Result<()>;
}

/// Tells one start of the host from another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Boot(Option<[u8; 16]>);

impl Boot {
    /// Nobody knows which start this is.
    pub const UNKNOWN: Self = Self(None);

    /// The start of this identity.
    #[must_use]
    pub const fn new(identity: [u8; 16]) -> Self {
        Self(Some(identity))
    }

    /// Whether both are certainly the same: an unknown one equals nothing.
    #[must_use]
    pub fn is_certainly(self, other: Self) -> bool {
        self.0.is_some() && self.0 == other.0
    }
}
