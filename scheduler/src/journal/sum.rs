//! What the files of a journal add up to, and what of them is damage.
//!
//! A log is left only when all of it is durable. So whatever stands in a later
//! log is a witness that the one before it was complete; inside the last one,
//! frames are each other's witnesses (*Durable Evidence*).

use crate::journal::JournalError;
use crate::journal::entry::Entry;
use crate::journal::frame;
use crate::journal::open::Found;
use crate::journal::replay::Replay;
use crate::journal::segment::{Extent, HEAD, Head, Kind, Segment, read_frames};
use crate::journal::storage::Storage;
use crate::manager::Record;

/// What files add up to.
#[derive(Debug, Default)]
pub(super) struct Sum {
    pub(super) replay: Replay,
    /// The number of the snapshot that it begins with; 0: none.
    pub(super) base: u64,
    pub(super) snapshot_bytes: u64,
    /// The logs after it, as far as they were read.
    pub(super) logs: Vec<Log>,
    /// Where it ends too early.
    pub(super) damage: Option<JournalError>,
}

/// A log that was read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Log {
    pub(super) segment: Segment,
    pub(super) extent: Extent,
    length: usize,
}

impl Log {
    pub(super) fn end(&self) -> u64 {
        u64::try_from(self.extent.end).unwrap_or(u64::MAX)
    }

    /// Nothing stands in it but a head, or the beginning of one.
    pub(super) const fn is_untouched(&self) -> bool {
        self.length <= HEAD
    }

    /// How many bytes stand behind its last whole frame.
    pub(super) fn torn(&self) -> u64 {
        u64::try_from(self.length.saturating_sub(self.extent.end)).unwrap_or(u64::MAX)
    }
}

impl Sum {
    pub(super) fn torn(&self) -> u64 {
        self.logs.iter().map(Log::torn).sum()
    }

    /// Damage is a finding; anything else that is wrong ends the reading.
    fn or_damage(&mut self, result: Result<(), JournalError>) -> Result<(), JournalError> {
        match result {
            Err(damage @ JournalError::Damaged { .. }) => {
                self.damage = Some(damage);
                Ok(())
            }
            other => other,
        }
    }
}

/// Adds up the newest complete snapshot and the logs after it, up to this one.
/// At damage it stops, and says so.
pub(super) fn add_up(
    storage: &dyn Storage,
    found: &Found,
    up_to: u64,
) -> Result<Sum, JournalError> {
    let mut sum = newest_snapshot(storage, found)?;
    if sum.damage.is_none() {
        let files = logs_between(storage, found, sum.base, up_to)?;
        let added = add_logs(&mut sum, &files);
        sum.or_damage(added)?;
    }
    Ok(sum)
}

/// A log as it stands on the storage.
struct File {
    segment: Segment,
    bytes: Vec<u8>,
}

impl File {
    fn read(storage: &dyn Storage, segment: Segment) -> Result<Self, JournalError> {
        let name = segment.name();
        let bytes = storage.read(&name).map_err(JournalError::storage("reading", &name))?;
        Ok(Self { segment, bytes })
    }

    fn damaged(&self, offset: usize, what: &'static str) -> JournalError {
        damaged(self.segment, offset, what)
    }

    fn is_touched(&self) -> bool {
        self.bytes.len() > HEAD
    }

    /// How long its first entry says that the log before it is.
    fn length_before(&self) -> Option<usize> {
        let first = frame::read(&self.bytes, self.segment.identity(), HEAD)?;
        match postcard::take_from_bytes(first.payload).ok()? {
            (Entry::<Record>::Continues(length), _) => usize::try_from(length).ok(),
            _ => None,
        }
    }
}

fn logs_between(
    storage: &dyn Storage,
    found: &Found,
    base: u64,
    up_to: u64,
) -> Result<Vec<File>, JournalError> {
    let numbers = found.numbers(Kind::Log).filter(|number| *number > base && *number <= up_to);
    numbers.map(|number| File::read(storage, Segment::log(number))).collect()
}

fn add_logs(sum: &mut Sum, files: &[File]) -> Result<(), JournalError> {
    if files.is_empty() && sum.base > 0 {
        return Err(damaged(Segment::log(sum.base + 1), 0, "it is missing"));
    }
    for (index, (file, number)) in files.iter().zip(sum.base + 1..).enumerate() {
        if file.segment.number != number {
            return Err(damaged(Segment::log(number), 0, "it is missing"));
        }
        let log = add_log(&mut sum.replay, file, &files[index + 1..])?;
        sum.logs.push(log);
    }
    Ok(())
}

fn add_log(replay: &mut Replay, file: &File, later: &[File]) -> Result<Log, JournalError> {
    let was_left = later.iter().any(File::is_touched);
    let (segment, length) = (file.segment, file.bytes.len());
    let head = segment.check(&file.bytes)?;
    if head == Head::Torn {
        if was_left || file.is_touched() {
            return Err(file.damaged(0, "it does not begin as a journal's log does"));
        }
        return Ok(Log { segment, extent: Extent { end: HEAD, durable: HEAD }, length });
    }
    let extent = read_frames(segment, &file.bytes, |entry| replay.apply_entry(entry))?;
    let told = later.first().and_then(File::length_before);
    if told.is_some_and(|told| told != extent.end) || (was_left && extent.end != length) {
        return Err(file.damaged(extent.end, "what stood here is gone, and more was written later"));
    }
    if extent.end < length && frame::was_durable(&file.bytes, segment.identity(), extent.end) {
        return Err(file.damaged(extent.end, "what stands here is not what was written"));
    }
    Ok(Log { segment, extent, length })
}

/// The newest snapshot that is whole. One that is not counts for nothing while
/// the logs that it was to replace are still there.
fn newest_snapshot(storage: &dyn Storage, found: &Found) -> Result<Sum, JournalError> {
    for number in found.numbers(Kind::Snapshot).rev() {
        let file = File::read(storage, Segment::snapshot(number))?;
        let mut sum = Sum { base: number, ..Sum::default() };
        sum.snapshot_bytes = u64::try_from(file.bytes.len()).unwrap_or(u64::MAX);
        let added = add_snapshot(&mut sum.replay, &file);
        sum.or_damage(added)?;
        let logs_are_there = found.segments.contains(&Segment::log(number));
        if sum.damage.is_none() || !logs_are_there {
            return Ok(sum);
        }
    }
    Ok(Sum::default())
}

fn add_snapshot(replay: &mut Replay, file: &File) -> Result<(), JournalError> {
    if file.segment.check(&file.bytes)? == Head::Torn {
        return Err(file.damaged(0, "it does not begin as a journal's snapshot does"));
    }
    let mut complete = None;
    let extent = read_frames(file.segment, &file.bytes, |entry| {
        if let Entry::Complete(tasks) = entry {
            complete = Some(tasks);
        }
        replay.apply_entry(entry);
    })?;
    if complete != Some(replay.known()) || extent.end != file.bytes.len() {
        return Err(file.damaged(extent.end, "what stands here is not what was written"));
    }
    Ok(())
}

fn damaged(segment: Segment, offset: usize, what: &'static str) -> JournalError {
    let offset = u64::try_from(offset).unwrap_or(u64::MAX);
    JournalError::Damaged { file: segment.name(), offset, what }
}
