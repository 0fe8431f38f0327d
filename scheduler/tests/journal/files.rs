//! On the host's own files.

use std::os::unix::fs::PermissionsExt;

use faregate_scheduler::journal::{Journal, JournalError, replay};

use crate::records::{accepted, task};
use crate::survival::ALONE;

#[test]
fn two_managers_never_share_a_journal() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("journal");
    let (first, ..) = Journal::open(&path, ALONE).unwrap();
    let error = Journal::open(&path, ALONE).expect_err("the journal is in use");
    assert!(matches!(error, JournalError::InUse { .. }));
    let who = format!("process {}", std::process::id());
    assert!(error.to_string().contains(&who), "{error}");
    drop(first);
    Journal::open(&path, ALONE).expect("nobody has it any more");
}

#[test]
fn only_its_owner_reads_a_journal() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("journal");
    let (_journal, ..) = Journal::open(&path, ALONE).unwrap();
    let mode = |path: &std::path::Path| path.metadata().unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&path), 0o700);
    for file in std::fs::read_dir(&path).unwrap() {
        assert_eq!(mode(&file.unwrap().path()), 0o600);
    }
}

#[test]
fn a_path_that_cannot_be_a_journal_is_an_error() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("file");
    std::fs::write(&file, "text").unwrap();
    for path in [file.clone(), file.join("below"), directory.path().join("a").join("b")] {
        let error = Journal::open(&path, ALONE).expect_err("no directory can be here");
        assert!(matches!(error, JournalError::Storage { .. }), "{error}");
    }
}

#[test]
fn a_journal_on_files_gives_back_what_was_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("journal");
    let (mut journal, ..) = Journal::open(&path, ALONE).unwrap();
    journal.append(&accepted(task(1))).unwrap();
    journal.sync().unwrap();
    journal.append(&accepted(task(2))).unwrap();
    journal.commit().unwrap();
    journal.append(&accepted(task(3))).unwrap();
    drop(journal);

    let (journal, restored, opened) = Journal::open(&path, ALONE).unwrap();
    assert_eq!(restored, replay([accepted(task(1)), accepted(task(2))]));
    assert!(!opened.clean && !opened.power_lost, "the host was not started meanwhile");
    journal.close().unwrap();
    let (_, _, opened) = Journal::open(&path, ALONE).unwrap();
    assert!(opened.clean);
}
