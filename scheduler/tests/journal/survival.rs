//! Who survives what.

use std::sync::Arc;

use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::{Compaction, Journal, JournalError, Opened, Options, replay};
use faregate_scheduler::manager::Restored;
use faregate_scheduler::task::Outcome;

use crate::records::{accepted, armed, ended, over, starting, task};

pub(crate) const ALONE: Options = Options {
    compact_above: u64::MAX,
    compaction: Compaction::Never,
    damage: faregate_scheduler::journal::Damage::Refuse,
};

pub(crate) fn open(disk: &Disk) -> (Journal, Restored, Opened) {
    Journal::open_on(Arc::new(disk.clone()), ALONE).expect("the journal opens")
}

/// Everything that was not synced goes.
fn lose_all(_: usize) -> usize {
    2
}

#[test]
fn a_new_journal_is_clean_and_empty() {
    let (_, restored, opened) = open(&Disk::default());
    assert!(opened.clean && !opened.power_lost);
    assert_eq!(restored, Restored::default());
}

#[test]
fn what_was_committed_survives_the_process() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    journal.append(&accepted(task(1))).unwrap();
    journal.commit().unwrap();
    journal.append(&accepted(task(2))).unwrap();
    disk.kill_process();

    let (_, restored, opened) = open(&disk);
    assert_eq!(restored, replay([accepted(task(1))]), "2 was not committed");
    assert!(!opened.clean && !opened.power_lost);
}

#[test]
fn what_was_synced_survives_the_power() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    journal.append(&accepted(task(1))).unwrap();
    journal.sync().unwrap();
    journal.append(&accepted(task(2))).unwrap();
    journal.commit().unwrap();
    disk.cut_power(&mut lose_all);

    let (_, restored, opened) = open(&disk);
    assert_eq!(restored, replay([accepted(task(1))]), "2 was not synced");
    assert!(!opened.clean && opened.power_lost);
}

#[test]
fn a_journal_that_was_closed_lost_nothing() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    journal.append(&accepted(task(1))).unwrap();
    journal.close().unwrap();
    disk.cut_power(&mut lose_all);

    let (_, restored, opened) = open(&disk);
    assert_eq!(restored, replay([accepted(task(1))]));
    assert!(opened.clean && !opened.power_lost);
}

/// Two records of one batch are there together or not at all, wherever its
/// write is torn.
#[test]
fn a_batch_survives_whole_or_not_at_all() {
    for torn in 0..400 {
        let disk = Disk::default();
        let (mut journal, ..) = open(&disk);
        journal.append(&accepted(task(1))).unwrap();
        journal.append(&accepted(task(2))).unwrap();
        journal.commit().unwrap();
        let tear = [1, torn];
        let mut tear = tear.into_iter();
        // The first record is the journal's own, that it was opened.
        let mut own = [0].into_iter();
        disk.cut_power(&mut |below| match own.next() {
            Some(choice) => choice,
            None => tear.next().unwrap_or(0).min(below - 1),
        });
        let (_, restored, _) = open(&disk);
        let whole = replay([accepted(task(1)), accepted(task(2))]);
        assert!(restored == Restored::default() || restored == whole, "torn after {torn}");
    }
}

#[test]
fn an_attempt_that_began_and_is_not_over_is_interrupted() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    for record in [accepted(task(1)), starting(1), accepted(task(2)), starting(2), over(2)] {
        journal.append(&record).unwrap();
    }
    journal.commit().unwrap();
    disk.kill_process();

    let (_, restored, _) = open(&disk);
    let interrupted: Vec<_> = restored.tasks.iter().map(|task| task.interrupted).collect();
    assert_eq!(interrupted, [Some(crate::records::attempt(1, 1)), None]);
}

/// Armed and not begun: after the death of the process it certainly did not
/// start; after a loss of power nobody knows, until it is dealt with.
#[test]
fn only_after_a_loss_of_power_may_an_armed_task_have_started() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    journal.append(&accepted(task(1))).unwrap();
    journal.append(&armed(1)).unwrap();
    journal.sync().unwrap();
    journal.append(&starting(1)).unwrap();
    journal.commit().unwrap();
    disk.kill_process();
    let (_, restored, _) = open(&disk);
    assert!(restored.tasks[0].interrupted.is_some() && !restored.tasks[0].may_have_started);

    disk.cut_power(&mut lose_all);
    let (_, restored, _) = open(&disk);
    assert!(restored.tasks[0].interrupted.is_none() && restored.tasks[0].may_have_started);

    // The next manager died before it wrote what it made of that.
    disk.kill_process();
    let (mut journal, restored, _) = open(&disk);
    assert!(restored.tasks[0].may_have_started);
    journal.append(&ended(1, Outcome::Failed)).unwrap();
    journal.commit().unwrap();
    disk.kill_process();
    let (_, restored, _) = open(&disk);
    assert!(restored.tasks[0].over && !restored.tasks[0].may_have_started);
}

#[test]
fn an_armed_task_of_a_killed_manager_was_not_started() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    journal.append(&accepted(task(1))).unwrap();
    journal.append(&armed(1)).unwrap();
    journal.sync().unwrap();
    disk.kill_process();
    let (_, restored, _) = open(&disk);
    assert!(!restored.tasks[0].may_have_started);
}

/// Of two writes the first was lost and the second was not: the second is cut
/// off, for good. It does not come back with the next loss of power, when what
/// was written in place of the first one happens to be as long.
#[test]
fn what_was_cut_off_never_comes_back() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    journal.append(&accepted(task(1))).unwrap();
    journal.commit().unwrap();
    // The first write is the note that the journal was opened.
    let mut fates = [2, 0].into_iter();
    disk.cut_power(&mut |_| fates.next().expect("two writes"));
    let (_, restored, opened) = open(&disk);
    assert!(restored.tasks.is_empty() && opened.torn > 0);

    // The cut, were it not durable, and the same note once more.
    let mut fates = [2, 0].into_iter();
    disk.cut_power(&mut |_| fates.next().expect("at most two"));
    let (_, restored, _) = open(&disk);
    assert!(restored.tasks.is_empty(), "it came back");
}

/// A full disk: the batch waits, nothing of it stands in the way, and when
/// there is room again it is written.
#[test]
fn a_full_disk_is_an_error_that_passes() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    journal.append(&accepted(task(1))).unwrap();
    journal.sync().unwrap();
    let used = usize::try_from(journal.log_bytes()).unwrap();
    disk.set_room(Some(used + 10));
    journal.append(&accepted(task(2))).unwrap();
    let refused = journal.commit();
    assert!(matches!(refused, Err(JournalError::Storage { .. })), "{refused:?}");
    assert!(journal.sync().is_err(), "a sync does not forget what waits");
    disk.set_room(None);
    journal.commit().unwrap();
    disk.kill_process();
    let (_, restored, opened) = open(&disk);
    assert_eq!(restored, replay([accepted(task(1)), accepted(task(2))]));
    assert_eq!(opened.torn, 0);
}

#[test]
fn nothing_is_accepted_after_a_failed_sync() {
    let disk = Disk::default();
    let (mut journal, ..) = open(&disk);
    journal.append(&accepted(task(1))).unwrap();
    journal.commit().unwrap();
    disk.fail_after(0);
    assert!(matches!(journal.sync(), Err(JournalError::Storage { .. })));
    disk.fail_after(1_000);
    assert!(matches!(journal.sync(), Err(JournalError::Failed)), "the second sync knows less");
    journal.append(&accepted(task(2))).unwrap();
    assert!(matches!(journal.commit(), Err(JournalError::Failed)));
}
