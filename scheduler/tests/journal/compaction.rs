//! A log that has grown long is replaced by what it adds up to.

use std::sync::Arc;

use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::storage::Storage;
use faregate_scheduler::journal::{Compaction, Journal, Options, Replay};
use faregate_scheduler::manager::Record;

use crate::records;
use crate::survival::ALONE;

fn compacting(compaction: Compaction) -> Options {
    Options { compact_above: 2_000, compaction, ..ALONE }
}

/// A long history with syncs, and what it adds up to.
fn write(journal: &mut Journal, batches: u32, seed: u64) -> Replay {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut replay = Replay::default();
    for _ in 0..batches {
        let record = records::any(&mut random);
        journal.append(&record).unwrap();
        replay.apply(record);
        journal.sync().unwrap();
    }
    replay
}

#[test]
fn a_compacted_log_adds_up_to_the_same() {
    for seed in 0..20 {
        let disk = Disk::default();
        let options = compacting(Compaction::Inline);
        let (mut journal, ..) = Journal::open_on(Arc::new(disk.clone()), options).unwrap();
        let replay = write(&mut journal, 400, seed);
        assert!(journal.compactions() > 3, "{} compactions", journal.compactions());
        disk.kill_process();
        let (_, restored, _) = Journal::open_on(Arc::new(disk.clone()), options).unwrap();
        assert_eq!(restored, replay.restored());
        let kept: usize =
            disk.names().unwrap().iter().map(|name| disk.read(name).unwrap().len()).sum();
        assert!(kept < 20_000, "{kept} bytes are left of 400 records");
    }
}

/// The same on a thread, with files: the process goes on meanwhile.
#[test]
fn a_thread_compacts_while_records_are_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("journal");
    let options = compacting(Compaction::Background);
    let (mut journal, ..) = Journal::open(&path, options).unwrap();
    let mut replay = Replay::default();
    let mut random = fastrand::Rng::with_seed(1);
    let mut written = 0;
    while journal.compactions() < 3 {
        let record = records::any(&mut random);
        journal.append(&record).unwrap();
        replay.apply(record);
        journal.sync().unwrap();
        written += 1;
        assert!(written < 1_000_000, "nobody compacts");
    }
    drop(journal);
    let (_, restored, _) = Journal::open(&path, options).unwrap();
    assert_eq!(restored, replay.restored());
}

/// A snapshot that was not finished counts for nothing while its logs are
/// there; without them it is damage, and is said to be.
#[test]
fn half_a_snapshot_is_not_taken_for_a_whole_one() {
    let disk = Disk::default();
    let options = compacting(Compaction::Inline);
    let (mut journal, ..) = Journal::open_on(Arc::new(disk.clone()), options).unwrap();
    write(&mut journal, 100, 3);
    disk.kill_process();
    let names = disk.names().unwrap();
    let snapshot = names.iter().find(|name| name.ends_with(".snapshot")).expect("a snapshot");
    disk.rot(snapshot, |bytes| bytes.truncate(bytes.len() - 1)).unwrap();
    let error = Journal::open_on(Arc::new(disk.clone()), options).expect_err("half a snapshot");
    assert!(error.to_string().contains(snapshot.as_str()), "{error}");
}

/// Whatever stops the compaction, the journal goes on.
#[test]
fn a_compaction_that_fails_costs_nothing() {
    for operations in 0..12 {
        let disk = Disk::default();
        let options = compacting(Compaction::Inline);
        let (mut journal, ..) = Journal::open_on(Arc::new(disk.clone()), options).unwrap();
        let mut replay = Replay::default();
        let mut random = fastrand::Rng::with_seed(9);
        while journal.log_bytes() <= 2_000 {
            let record = records::any(&mut random);
            journal.append(&record).unwrap();
            replay.apply(record);
            journal.commit().unwrap();
        }
        disk.fail_after(operations + 1);
        let _ = journal.sync();
        disk.kill_process();
        let (_, restored, _) = Journal::open_on(Arc::new(disk.clone()), options).unwrap();
        assert_eq!(restored, replay.restored(), "stopped after {operations} operations");
    }
}

/// On a full disk what is left of the attempt would be missing to the log.
#[test]
fn a_snapshot_that_does_not_fit_leaves_the_room_to_the_log() {
    let disk = Disk::default();
    let options = compacting(Compaction::Inline);
    let (mut journal, ..) = Journal::open_on(Arc::new(disk.clone()), options).unwrap();
    let mut replay = Replay::default();
    // Nothing of this becomes less by adding it up.
    for number in 1.. {
        let record = records::accepted(records::task(number));
        journal.append(&record).unwrap();
        replay.apply(record);
        journal.commit().unwrap();
        if journal.log_bytes() > 2_000 {
            break;
        }
    }
    let used = || disk.names().unwrap().iter().map(|name| disk.read(name).unwrap().len()).sum();
    let before: usize = used();
    let mode = Record::Mode { name: "m".repeat(500), entered: true };
    disk.set_room(Some(before + 700));
    journal.sync().unwrap();
    journal.append(&mode).unwrap();
    replay.apply(mode);
    journal.sync().unwrap();
    assert_eq!(journal.compactions(), 0);
    disk.kill_process();
    let (_, restored, _) = Journal::open_on(Arc::new(disk.clone()), options).unwrap();
    assert_eq!(restored, replay.restored());
}
