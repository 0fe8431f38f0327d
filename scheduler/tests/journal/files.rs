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

/// A child that a killed manager was forking has the lock for a moment longer:
/// here one that is our own, and signed by somebody who is no more.
#[test]
fn the_lock_of_a_dead_manager_is_waited_for() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("journal");
    drop(Journal::open(&path, ALONE).unwrap());
    let dead = std::process::Command::new("true").spawn().and_then(|mut child| {
        let number = child.id();
        child.wait().map(|_| number)
    });
    let lock = path.join("lock");
    std::fs::write(&lock, format!("process {} (true)\n", dead.unwrap())).unwrap();
    let held = std::fs::File::open(&lock).unwrap();
    held.lock().unwrap();
    std::thread::scope(|scope| {
        let opening = scope.spawn(|| Journal::open(&path, ALONE).map(|_| ()));
        while descriptors_of(&lock) < 2 && !opening.is_finished() {
            std::thread::yield_now();
        }
        drop(held);
        opening.join().unwrap().expect("it waited");
    });
}

/// How many descriptors of this process are of this file.
fn descriptors_of(file: &std::path::Path) -> usize {
    let descriptors = std::fs::read_dir("/proc/self/fd").unwrap();
    let target = |entry: std::fs::DirEntry| std::fs::read_link(entry.path()).ok();
    descriptors.filter_map(|entry| target(entry.ok()?)).filter(|target| target == file).count()
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
