//! The format is what the version says: a log that was written earlier is read.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::storage::Storage;
use faregate_scheduler::journal::{Journal, replay};
use faregate_scheduler::manager::Record;

use crate::records;
use crate::survival::{ALONE, open};

const LOG: &str = "00000001.log";

/// Where the log of this version is. Written anew with `FAREGATE_BLESS=1`: for
/// a version that was never released, or together with a new one.
fn fixture() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/journal/version-1.log")
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
    let written = written();
    if std::env::var_os("FAREGATE_BLESS").is_some() {
        std::fs::write(fixture(), &written).unwrap();
    }
    let kept = std::fs::read(fixture()).expect("the log that was written earlier");
    assert!(kept == written, "the same records are written otherwise than they were");
    let disk = Disk::default();
    disk.create(LOG).unwrap().write(&kept).unwrap();
    let (_, restored, _) = Journal::open_on(Arc::new(disk), ALONE).unwrap();
    assert_eq!(restored, replay(history()));
}
