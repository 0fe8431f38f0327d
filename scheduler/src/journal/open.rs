//! Opening: what the files add up to, and where to go on writing.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::journal::compact::write_snapshot;
use crate::journal::entry::Entry;
use crate::journal::segment::{HEAD, Kind, Segment};
use crate::journal::storage::{Storage, StoredFile};
use crate::journal::sum::{Log, Sum, add_up};
use crate::journal::writer::{EmptyLog, Length, Writer};
use crate::journal::{Damage, JournalError};
use crate::manager::Restored;

/// What opening a journal found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Opened {
    /// The journal was closed in order, or is new.
    pub clean: bool,
    /// Power may have been lost since it was open last: what was not synced
    /// then may be missing.
    pub power_lost: bool,
    /// How many bytes of a torn write were cut off.
    pub torn: u64,
    /// Bytes that were durable were given up, as [`Damage::KeepWhatPrecedes`]
    /// permits.
    pub damaged: bool,
    /// How long it took.
    pub took: Duration,
    pub(super) snapshot_bytes: u64,
}

pub(super) fn open(
    storage: &Arc<dyn Storage>,
    damage: Damage,
) -> Result<(Writer, Restored, Opened), JournalError> {
    let began = Instant::now();
    let storage = &**storage;
    let found = Found::list(storage)?;
    let mut sum = add_up(storage, &found, u64::MAX)?;
    let damaged = sum.damage.take();
    let mut writer = match (damaged.is_some(), damage) {
        (false, _) => go_on(storage, &sum)?,
        (true, Damage::KeepWhatPrecedes) => salvage(storage, &found, &sum)?,
        (true, Damage::Refuse) => return Err(damaged.unwrap_or(JournalError::Failed)),
    };
    clear_away(storage, &found, sum.base)?;
    let is_new = found.segments.is_empty();
    let clean = is_new || sum.replay.is_closed();
    let boot = storage.boot();
    let power_lost = !clean && !sum.replay.last_boot().is_certainly(boot);
    sum.replay.opened(boot);
    writer.append(&Entry::Opened(boot))?;
    writer.commit()?;
    let opened = Opened {
        clean,
        power_lost,
        torn: sum.torn(),
        damaged: damaged.is_some(),
        took: began.elapsed(),
        snapshot_bytes: sum.snapshot_bytes,
    };
    Ok((writer, sum.replay.into_restored(), opened))
}

/// Goes on at the end of the last log.
fn go_on(storage: &dyn Storage, sum: &Sum) -> Result<Writer, JournalError> {
    let [before @ .., last] = &*sum.logs else {
        return Ok(begin(empty_log(storage, Segment::log(sum.base + 1))?));
    };
    let Some(previous) = before.last() else { return end_of(storage, last) };
    if last.extent.end > HEAD {
        return end_of(storage, last);
    }
    // The last one was made and not written to: the one before it may have an
    // end that is not durable. It must be, before anything stands behind it.
    let mut file = cut(storage, previous)?;
    file.sync().map_err(JournalError::storage("syncing", &previous.segment.name()))?;
    let mut writer = end_of(storage, last)?;
    writer.begin_after(previous.end());
    Ok(writer)
}

/// Removes what a snapshot stands for, if somebody died before they did. They
/// may have died before it was durable.
fn clear_away(storage: &dyn Storage, found: &Found, base: u64) -> Result<(), JournalError> {
    if found.removable(base).next().is_none() {
        return Ok(());
    }
    if base > 0 {
        let name = Segment::snapshot(base).name();
        sync_file(storage, &name).map_err(JournalError::storage("syncing", &name))?;
    }
    found.remove_up_to(storage, base)
}

fn sync_file(storage: &dyn Storage, name: &str) -> std::io::Result<()> {
    let length = storage.read(name)?.len();
    storage.append(name, u64::try_from(length).unwrap_or(u64::MAX))?.sync()?;
    storage.sync_names()
}

/// The end of this log, with what was torn cut off for good: a frame of a write
/// that was given up must not stand where the next one happens to end. A log
/// without anything is made anew: its name may not be durable.
fn end_of(storage: &dyn Storage, log: &Log) -> Result<Writer, JournalError> {
    if log.is_untouched() {
        return Ok(begin(empty_log(storage, log.segment)?));
    }
    let mut file = cut(storage, log)?;
    let mut durable = u64::try_from(log.extent.durable).unwrap_or(0);
    if log.torn() > 0 {
        file.sync().map_err(JournalError::storage("syncing", &log.segment.name()))?;
        durable = log.end();
    }
    Ok(Writer::new(log.segment, file, Length { written: log.end(), durable }))
}

fn cut(storage: &dyn Storage, log: &Log) -> Result<Box<dyn StoredFile>, JournalError> {
    let name = log.segment.name();
    storage.append(&name, log.end()).map_err(JournalError::storage("opening", &name))
}

/// Makes what precedes the damage a snapshot, and keeps the damaged files under
/// other names.
fn salvage(storage: &dyn Storage, found: &Found, sum: &Sum) -> Result<Writer, JournalError> {
    for segment in &found.segments {
        copy(storage, &segment.name(), &format!("{}.damaged", segment.name()))?;
    }
    let last = found.segments.iter().map(|segment| segment.number).max().unwrap_or(0) + 1;
    write_snapshot(storage, Segment::snapshot(last), sum.replay.entries())?;
    let writer = begin(empty_log(storage, Segment::log(last + 1))?);
    found.remove_up_to(storage, last)?;
    Ok(writer)
}

fn copy(storage: &dyn Storage, from: &str, to: &str) -> Result<(), JournalError> {
    let bytes = storage.read(from).map_err(JournalError::storage("reading", from))?;
    let mut file = storage.create(to).map_err(JournalError::storage("making", to))?;
    file.write(&bytes).map_err(JournalError::storage("writing", to))?;
    file.sync().map_err(JournalError::storage("syncing", to))
}

fn begin(log: EmptyLog) -> Writer {
    let start = u64::try_from(HEAD).unwrap_or(u64::MAX);
    Writer::new(log.segment, log.file, Length { written: start, durable: start })
}

/// Makes a log with nothing in it, durable with its name.
pub(super) fn empty_log(storage: &dyn Storage, segment: Segment) -> Result<EmptyLog, JournalError> {
    let name = segment.name();
    let mut file = storage.create(&name).map_err(JournalError::storage("making", &name))?;
    file.write(&segment.head()).map_err(JournalError::storage("writing", &name))?;
    file.sync().map_err(JournalError::storage("syncing", &name))?;
    storage.sync_names().map_err(JournalError::storage("syncing the name of", &name))?;
    Ok(EmptyLog { segment, file })
}

/// The files of a journal, in order.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) segments: Vec<Segment>,
}

impl Found {
    pub(super) fn list(storage: &dyn Storage) -> Result<Self, JournalError> {
        let names = storage.names().map_err(JournalError::storage("listing", "(all)"))?;
        let mut segments: Vec<_> = names.iter().filter_map(|name| Segment::of_name(name)).collect();
        segments.sort();
        Ok(Self { segments })
    }

    /// The numbers of the files of this kind, in order.
    pub(super) fn numbers(&self, kind: Kind) -> impl DoubleEndedIterator<Item = u64> {
        let of_kind = move |segment: &&Segment| segment.kind == kind;
        self.segments.iter().filter(of_kind).map(|segment| segment.number)
    }

    pub(super) fn last_log(&self) -> Option<u64> {
        self.numbers(Kind::Log).next_back()
    }

    fn removable(&self, base: u64) -> impl Iterator<Item = Segment> {
        let old = move |segment: &Segment| match segment.kind {
            Kind::Log => segment.number <= base,
            Kind::Snapshot => segment.number != base,
        };
        self.segments.iter().copied().filter(old)
    }

    /// Removes what the snapshot of this number stands for, the oldest first,
    /// and snapshots that were never completed.
    pub(super) fn remove_up_to(
        &self,
        storage: &dyn Storage,
        base: u64,
    ) -> Result<(), JournalError> {
        for segment in self.removable(base) {
            let name = segment.name();
            storage.remove(&name).map_err(JournalError::storage("removing", &name))?;
        }
        Ok(())
    }
}
