//! Writes batches at the end of a log.

use serde::Serialize;

use crate::journal::JournalError;
use crate::journal::entry::Entry;
use crate::journal::frame;
use crate::journal::points::{self, Point};
use crate::journal::segment::{HEAD, Segment};
use crate::journal::storage::StoredFile;
use crate::manager::Record;

/// The end of a log.
#[derive(Debug)]
pub(super) struct Writer {
    segment: Segment,
    file: Box<dyn StoredFile>,
    /// How much of the file is whole frames.
    written: u64,
    /// How much of it is durable.
    durable: u64,
    /// Room for a frame's head, then the entries that are not yet written.
    batch: Vec<u8>,
    failed: bool,
}

/// A log that is there, empty, with a durable name.
#[derive(Debug)]
pub(super) struct EmptyLog {
    pub(super) segment: Segment,
    pub(super) file: Box<dyn StoredFile>,
}

/// How much of a file is there, and durable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Length {
    pub(super) written: u64,
    pub(super) durable: u64,
}

impl Writer {
    pub(super) fn new(segment: Segment, file: Box<dyn StoredFile>, length: Length) -> Self {
        let Length { written, durable } = length;
        Self { segment, file, written, durable, batch: vec![0; frame::HEAD], failed: false }
    }

    pub(super) const fn len(&self) -> u64 {
        self.written
    }

    pub(super) fn append(&mut self, entry: &Entry<&Record>) -> Result<(), JournalError> {
        let before = self.batch.len();
        let encoded = encode(entry, &mut self.batch);
        let bytes = self.batch.len() - frame::HEAD;
        if !encoded || bytes > frame::PAYLOAD_MAX {
            self.batch.truncate(before);
            return Err(JournalError::TooLong { bytes });
        }
        Ok(())
    }

    pub(super) fn commit(&mut self) -> Result<(), JournalError> {
        if self.failed {
            return Err(JournalError::Failed);
        }
        if self.batch.len() == frame::HEAD {
            return Ok(());
        }
        frame::seal(&mut self.batch, self.segment.identity(), self.written, self.durable);
        if let Err(error) = self.file.write(&self.batch) {
            // What was written of it must not stay before what comes next.
            self.failed = self.file.cut(self.written).is_err();
            return Err(JournalError::storage("writing", &self.segment.name())(error));
        }
        self.written += u64::try_from(self.batch.len()).unwrap_or(u64::MAX);
        self.batch.truncate(frame::HEAD);
        Ok(())
    }

    pub(super) fn sync(&mut self) -> Result<(), JournalError> {
        self.commit()?;
        if self.durable == self.written {
            return Ok(());
        }
        points::hit(Point::BeforeSync);
        if let Err(error) = self.file.sync() {
            self.failed = true;
            return Err(JournalError::storage("syncing", &self.segment.name())(error));
        }
        points::hit(Point::AfterSync);
        self.durable = self.written;
        Ok(())
    }

    /// Goes on in the next log. Only after a sync: bytes of the next one are
    /// witnesses that all of this one is durable.
    pub(super) fn switch_to(&mut self, next: EmptyLog) {
        debug_assert_eq!(self.durable, self.written, "a log is left before it is durable");
        let before = self.written;
        let start = u64::try_from(HEAD).unwrap_or(u64::MAX);
        self.segment = next.segment;
        self.file = next.file;
        self.written = start;
        self.durable = start;
        self.begin_after(before);
    }

    /// The first entry of a log says how long the one before it is.
    pub(super) fn begin_after(&mut self, before: u64) {
        // A few bytes at the beginning of an empty batch: never too long.
        let fits = encode(&Entry::<&Record>::Continues(before), &mut self.batch);
        debug_assert!(fits, "an integer is not encoded");
    }
}

/// Adds an entry; `false`: it has no encoding, and some of it may stand there.
pub(super) fn encode(entry: &Entry<impl Serialize>, bytes: &mut Vec<u8>) -> bool {
    postcard::to_io(entry, bytes).is_ok()
}
