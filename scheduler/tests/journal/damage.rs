//! Torn ends are cut off; damage is an error that says where; nothing panics.

use std::sync::Arc;

use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::storage::Storage;
use faregate_scheduler::journal::{Damage, Journal, JournalError, Options, replay};
use faregate_scheduler::manager::Restored;

use crate::records::{accepted, task};
use crate::survival::{ALONE, open};

const LOG: &str = "00000001.log";

/// A log of these many batches, each synced, that was killed. Answers its
/// length after each.
fn written(batches: u32) -> (Disk, Vec<usize>) {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    let mut lengths = Vec::new();
    for number in 1..=batches {
        journal.append(&accepted(task(number))).unwrap();
        journal.sync().unwrap();
        lengths.push(usize::try_from(journal.log_bytes()).unwrap());
    }
    disk.kill_process();
    (disk, lengths)
}

fn first(batches: u32) -> Restored {
    replay((1..=batches).map(|number| accepted(task(number))))
}

fn try_open(disk: &Disk) -> Result<Restored, JournalError> {
    Journal::open_on(Arc::new(disk.clone()), ALONE).map(|(_, restored, _)| restored)
}

/// The file ends anywhere: what precedes the last whole frame is there.
#[test]
fn a_log_that_ends_anywhere_is_read_as_far_as_it_goes() {
    let (_, lengths) = written(3);
    for length in 0..=lengths[2] {
        let (disk, _) = written(3);
        disk.rot(LOG, |bytes| bytes.truncate(length)).unwrap();
        let whole = lengths.iter().filter(|end| **end <= length).count();
        let restored = try_open(&disk).expect("a torn end is no damage");
        assert_eq!(restored, first(u32::try_from(whole).unwrap()), "cut after {length}");
    }
}

/// Each byte that a later frame witnesses to have been durable, changed in each
/// bit: always an error, never another schedule.
#[test]
fn a_changed_byte_before_a_witness_is_damage() {
    // The third batch was written when the second was durable.
    let (_, lengths) = written(3);
    for at in 0..lengths[1] {
        let (disk, _) = written(3);
        disk.rot(LOG, |bytes| bytes[at] ^= 1 << (at % 8)).unwrap();
        let error = try_open(&disk).expect_err("damage was not seen");
        assert!(matches!(error, JournalError::Damaged { .. }), "byte {at}: {error}");
    }
}

/// Without a witness it passes for torn: what was read before is there.
#[test]
fn a_changed_byte_behind_all_witnesses_ends_the_log_there() {
    let (_, lengths) = written(3);
    for at in lengths[1]..lengths[2] {
        let (disk, _) = written(3);
        disk.rot(LOG, |bytes| bytes[at] ^= 0x40).unwrap();
        assert_eq!(try_open(&disk).expect("no witness"), first(2), "byte {at}");
    }
}

#[test]
fn damage_says_where_and_what_to_do() {
    let (disk, lengths) = written(3);
    disk.rot(LOG, |bytes| bytes[lengths[0] + 30] ^= 1).unwrap();
    let text = try_open(&disk).expect_err("damage").to_string();
    assert!(text.contains(LOG) && text.contains(&format!("byte {}", lengths[0])), "{text}");
    assert!(text.contains("Restore") && text.contains("keeping what precedes"), "{text}");
}

/// Who asks for it gets what precedes the damage, and a copy of all of it.
#[test]
fn what_precedes_damage_can_be_kept() {
    let (disk, lengths) = written(3);
    disk.rot(LOG, |bytes| bytes[lengths[0] + 30] ^= 1).unwrap();
    let damaged = disk.read(LOG).unwrap();
    let options = Options { damage: Damage::KeepWhatPrecedes, ..ALONE };
    let (mut journal, restored, opened) =
        Journal::open_on(Arc::new(disk.clone()), options).unwrap();
    assert!(opened.damaged);
    assert_eq!(restored, first(1));
    assert_eq!(disk.read("00000001.log.damaged").unwrap(), damaged);

    journal.append(&accepted(task(2))).unwrap();
    journal.sync().unwrap();
    disk.cut_power(&mut |_| 2);
    assert_eq!(try_open(&disk).expect("it is whole again"), first(2));
}

#[test]
fn a_log_of_another_version_is_not_read() {
    let (disk, _) = written(1);
    disk.rot(LOG, |bytes| {
        bytes[8] += 1;
        let sum = crc32fast::hash(&bytes[..20]);
        bytes[20..24].copy_from_slice(&sum.to_le_bytes());
    })
    .unwrap();
    let error = try_open(&disk).expect_err("another version");
    let JournalError::Version { found, known, .. } = error else { panic!("{error}") };
    assert_eq!(found, known + 1);
}

#[test]
fn a_log_under_another_name_is_not_read() {
    let (disk, _) = written(1);
    let bytes = disk.read(LOG).unwrap();
    disk.create("00000002.log").unwrap().write(&bytes).unwrap();
    assert!(matches!(try_open(&disk), Err(JournalError::Damaged { .. })));
}

#[test]
fn files_of_others_are_left_alone() {
    let (disk, _) = written(1);
    for name in ["notes.txt", "1.log", "00000001.log.damaged", "00000000.log", "x.snapshot"] {
        disk.create(name).unwrap().write(b"not a journal").unwrap();
    }
    assert_eq!(try_open(&disk).unwrap(), first(1));
    assert_eq!(disk.read("notes.txt").unwrap(), b"not a journal");
}

/// Any bytes for files: an answer or an error, never a panic.
#[test]
fn garbage_never_panics() {
    let mut random = fastrand::Rng::with_seed(7);
    let (mut errors, mut answers) = (0, 0);
    for _ in 0..2_000 {
        let (disk, lengths) = written(3);
        disk.rot(LOG, |bytes| {
            for _ in 0..random.u32(1..6) {
                let at = random.usize(..bytes.len());
                match random.u8(0..3) {
                    0 => bytes[at] = random.u8(..),
                    1 => bytes.truncate(at.max(1)),
                    _ => drop(bytes.splice(at..at, (0..random.u8(1..40)).map(|_| 0xF5))),
                }
            }
        })
        .unwrap();
        match try_open(&disk) {
            Ok(restored) => {
                let prefix = (0..=3).any(|batches| restored == first(batches));
                assert!(prefix, "read what was never written: {restored:?} ({lengths:?})");
                answers += 1;
            }
            Err(_) => errors += 1,
        }
    }
    assert!(errors > 100 && answers > 100, "{errors} errors, {answers} answers");
}
