//! A journal's file that something else has written into. Whatever stands
//! there, the journal opens or says why not, and what it gives back is the same
//! the second time.
#![no_main]

use std::sync::Arc;

use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::storage::Storage;
use faregate_scheduler::journal::{Compaction, Damage, Journal, Options};

const LOG: &str = "00000001.log";
/// What goes into each checksum of that file.
const IDENTITY: u64 = 2;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((how, rest)) = bytes.split_first() else { return };
    let disk = Disk::default();
    let options = |damage| Options { compaction: Compaction::Never, damage, ..Options::default() };
    drop(Journal::open_on(Arc::new(disk.clone()), options(Damage::Refuse)));
    let changed = disk.rot(LOG, |file| match how % 3 {
        0 => file.extend_from_slice(rest),
        2 => *file = rest.to_vec(),
        _ => rest.split(|byte| *byte == b'\xFF').for_each(|payload| seal(file, payload)),
    });
    assert!(changed.is_ok(), "a new journal has a first log");
    let _ = Journal::open_on(Arc::new(disk.clone()), options(Damage::Refuse)).map(drop);
    if let Ok((journal, first, _)) =
        Journal::open_on(Arc::new(disk.clone()), options(Damage::KeepWhatPrecedes))
    {
        drop(journal);
        let again = Journal::open_on(Arc::new(disk.clone()), options(Damage::Refuse));
        let (_, second, _) = again.expect("what was opened once opens again");
        assert_eq!(first, second);
    }
    assert!(disk.names().is_ok());
});

/// A frame that is what was written, around what nobody would write.
fn seal(file: &mut Vec<u8>, payload: &[u8]) {
    let mut head = Vec::from(*b"\xF5tkt");
    head.extend_from_slice(&u32::try_from(payload.len()).unwrap_or(0).to_le_bytes());
    head.extend_from_slice(&0_u64.to_le_bytes());
    let mut sum = crc32fast::Hasher::new();
    sum.update(&IDENTITY.to_le_bytes());
    sum.update(&(file.len() as u64).to_le_bytes());
    sum.update(&head);
    sum.update(payload);
    file.extend_from_slice(&head);
    file.extend_from_slice(&sum.finalize().to_le_bytes());
    file.extend_from_slice(payload);
}
