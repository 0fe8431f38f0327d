//! The format is what the version says: a log that was written earlier is read.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::storage::Storage;
use faregate_scheduler::journal::{Compaction, Journal, Options, replay};
use faregate_scheduler::manager::Record;

use crate::records;
use crate::survival::{ALONE, open};

const LOG: &str = "00000001.log";
const SNAPSHOT: &str = "00000001.snapshot";

/// Where a file of this version is. Written anew with `FAREGATE_BLESS=1`: for
/// a version that was never released, or together with a new one.
fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/journal").join(name)
}

/// What was written earlier, after it was written anew if that is wanted.
fn kept(name: &str, written: &[u8]) -> Vec<u8> {
    if std::env::var_os("FAREGATE_BLESS").is_some() {
        std::fs::write(fixture(name), written).unwrap();
    }
    let kept = std::fs::read(fixture(name)).expect("what was written earlier");
    assert!(kept == written, "{name}: the same records are written otherwise than they were");
    kept
}

/// Every kind of record, many times.
fn history() -> Vec<Record> {
    let mut random = fastrand::Rng::with_seed(1);
    (0..300).map(|_| records::any(&mut random)).collect()
}

fn written() -> Vec<u8> {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    for records in history().chunks(7) {
        records.iter().for_each(|record| journal.append(record).unwrap());
        journal.sync().unwrap();
    }
    disk.read(LOG).unwrap()
}

/// When this fails, what stands in the log has changed: the version has to.
#[test]
fn a_log_of_this_version_is_read_and_written_as_ever() {
    let kept = kept("version-1.log", &written());
    let disk = Disk::default();
    disk.create(LOG).unwrap().write(&kept).unwrap();
    let (_, restored, _) = Journal::open_on(Arc::new(disk), ALONE).unwrap();
    assert_eq!(restored, replay(history()));
}

/// A snapshot is made of other things than a log.
#[test]
fn a_snapshot_of_this_version_is_read_and_written_as_ever() {
    let disk = Disk::default();
    let options = Options { compact_above: 4_000, compaction: Compaction::Inline, ..ALONE };
    let (mut journal, ..) = Journal::open_on(Arc::new(disk.clone()), options).unwrap();
    for record in history() {
        journal.append(&record).unwrap();
        journal.commit().unwrap();
    }
    journal.sync().unwrap();
    journal.sync().unwrap();
    assert_eq!(journal.compactions(), 1);
    let kept = kept("version-1.snapshot", &disk.read(SNAPSHOT).unwrap());
    let disk = Disk::default();
    disk.create(SNAPSHOT).unwrap().write(&kept).unwrap();
    // Its log was made, and nothing written to it.
    drop(disk.create("00000002.log").unwrap());
    let (_, restored, _) = Journal::open_on(Arc::new(disk), options).unwrap();
    assert_eq!(restored, replay(history()));
}
