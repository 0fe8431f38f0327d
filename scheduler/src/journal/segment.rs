//! The files of a journal: logs that grow, and snapshots of all logs up to one.

use crate::journal::JournalError;
use crate::journal::entry::Entry;
use crate::journal::frame;

/// The version of everything behind the head. It changes with [`Entry`] and all
/// that it holds; a test has a log of this one.
pub(super) const VERSION: u32 = 1;
/// How long a file's head is.
pub(super) const HEAD: usize = 24;

const MARK: [u8; 8] = *b"faregate";

/// Which file of a journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Segment {
    pub(super) number: u64,
    pub(super) kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Grows with each batch.
    Log,
    /// What all logs up to this number add up to.
    Snapshot,
}

impl Segment {
    pub(super) const fn log(number: u64) -> Self {
        Self { number, kind: Kind::Log }
    }

    pub(super) const fn snapshot(number: u64) -> Self {
        Self { number, kind: Kind::Snapshot }
    }

    pub(super) fn name(self) -> String {
        match self.kind {
            Kind::Log => format!("{:08}.log", self.number),
            Kind::Snapshot => format!("{:08}.snapshot", self.number),
        }
    }

    /// The segment of this file name; none: it is not the journal's.
    pub(super) fn of_name(name: &str) -> Option<Self> {
        let (number, extension) = name.split_once('.')?;
        let kind = match extension {
            "log" => Kind::Log,
            "snapshot" => Kind::Snapshot,
            _ => return None,
        };
        let segment = Self { number: number.parse().ok()?, kind };
        (segment.number > 0 && segment.name() == name).then_some(segment)
    }

    /// What goes into each checksum, so that no file passes for another one.
    pub(super) const fn identity(self) -> u64 {
        (self.number << 1) | (self.kind as u64)
    }

    /// The first bytes of the file.
    pub(super) fn head(self) -> [u8; HEAD] {
        let mut head = [0; HEAD];
        head[..8].copy_from_slice(&MARK);
        head[8..12].copy_from_slice(&VERSION.to_le_bytes());
        head[12..20].copy_from_slice(&self.identity().to_le_bytes());
        let sum = crc32fast::hash(&head[..20]);
        head[20..].copy_from_slice(&sum.to_le_bytes());
        head
    }

    /// Whether the file begins as it must.
    pub(super) fn check(self, file: &[u8]) -> Result<Head, JournalError> {
        let Some(head) = file.get(..HEAD) else { return Ok(Head::Torn) };
        if head == self.head() {
            return Ok(Head::Whole);
        }
        let sum = crc32fast::hash(&head[..20]).to_le_bytes();
        if head[..8] == MARK && head[20..] == sum {
            let mut found = [0; 4];
            found.copy_from_slice(&head[8..12]);
            let found = u32::from_le_bytes(found);
            if found != VERSION {
                return Err(JournalError::Version { file: self.name(), found, known: VERSION });
            }
            return Err(JournalError::damaged(&self.name(), 0, "it is another file, renamed"));
        }
        Ok(Head::Torn)
    }
}

/// How a file begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Head {
    Whole,
    /// Not as anybody wrote it to the end.
    Torn,
}

/// Reads all frames from the head on, as far as they are what was written.
pub(super) fn read_frames(
    segment: Segment,
    file: &[u8],
    mut each: impl FnMut(Entry),
) -> Result<Extent, JournalError> {
    let identity = segment.identity();
    let mut extent = Extent { end: HEAD, durable: HEAD };
    let mut entries = Vec::new();
    while let Some(frame) = frame::read(file, identity, extent.end) {
        if !read_entries(frame.payload, &mut entries) {
            let at = u64::try_from(extent.end).unwrap_or(u64::MAX);
            return Err(JournalError::damaged(&segment.name(), at, "a record of unknown form"));
        }
        entries.drain(..).for_each(&mut each);
        extent.end = frame.end;
        extent.durable = extent.durable.max(usize::try_from(frame.durable).unwrap_or(0));
    }
    Ok(extent)
}

/// How far a file can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Extent {
    /// Where the first frame would stand that cannot be read.
    pub(super) end: usize,
    /// What is known to be durable.
    pub(super) durable: usize,
}

/// A frame's entries, one after the other; `false`: they are not entries.
fn read_entries(mut payload: &[u8], entries: &mut Vec<Entry>) -> bool {
    while !payload.is_empty() {
        let Ok((entry, rest)) = postcard::take_from_bytes(payload) else { return false };
        entries.push(entry);
        payload = rest;
    }
    true
}
