//! Power goes at any operation, with any of what was not synced, again and
//! again: what is restored is always what some beginning of the history adds up
//! to, and never a shorter one than was synced.

use std::sync::Arc;

use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::storage::{Boot, Storage};
use faregate_scheduler::journal::{Compaction, Damage, Journal, Options, Replay};
use faregate_scheduler::manager::Restored;

use crate::records;

/// What may be on the disk, by what it adds up to. Which of these it is may
/// stay hidden for long: each goes on by itself.
#[derive(Default)]
struct Model {
    /// After a loss of power: no less than what was synced.
    after_cut: Vec<Replay>,
    /// After the death of the process: no less than what was committed.
    after_kill: Vec<Replay>,
}

impl Model {
    fn new() -> Self {
        // Nothing was lost of a journal that is new.
        let mut new = Replay::default();
        new.closed();
        Self { after_cut: vec![new.clone()], after_kill: vec![new] }
    }

    fn power_was_cut(&mut self) {
        self.after_kill.clone_from(&self.after_cut);
    }

    /// The journal was opened, and gave this back.
    fn opened(&mut self, boot: Boot, restored: &Restored) {
        let reads = |replay: &Replay| opened(replay, boot).restored() == *restored;
        self.after_kill.retain(reads);
        assert!(!self.after_kill.is_empty(), "no beginning of the history adds up to {restored:?}");
        self.after_kill = self.after_kill.iter().map(|replay| opened(replay, boot)).collect();
        // That it was opened is not synced.
        self.after_cut.extend(self.after_kill.iter().cloned());
        self.forget_twins();
    }

    /// Nobody knows whether the journal noted that it was opened.
    fn perhaps_opened(&mut self, boot: Boot) {
        let noted: Vec<_> = self.after_kill.iter().map(|replay| opened(replay, boot)).collect();
        self.after_kill.extend(noted);
        self.after_cut.extend(self.after_kill.iter().cloned());
        self.forget_twins();
    }

    fn wrote(&mut self, latest: &[Replay], how: Wrote) {
        match how {
            Wrote::Synced => self.after_cut = latest.to_vec(),
            Wrote::Committed | Wrote::Failed => self.after_cut.extend_from_slice(latest),
        }
        match how {
            Wrote::Failed => self.after_kill.extend_from_slice(latest),
            Wrote::Committed | Wrote::Synced => self.after_kill = latest.to_vec(),
        }
    }

    fn forget_twins(&mut self) {
        for replays in [&mut self.after_cut, &mut self.after_kill] {
            let mut single: Vec<Replay> = Vec::new();
            for replay in replays.drain(..) {
                if !single.contains(&replay) {
                    single.push(replay);
                }
            }
            *replays = single;
        }
    }
}

#[derive(Clone, Copy)]
enum Wrote {
    Synced,
    Committed,
    Failed,
}

fn opened(replay: &Replay, boot: Boot) -> Replay {
    let mut replay = replay.clone();
    replay.opened(boot);
    replay
}

/// One life of a manager on this disk, until the power goes or it is content.
/// Answers how often it compacted; none: the power went while it opened.
fn live(disk: &Disk, model: &mut Model, random: &mut fastrand::Rng) -> Option<u64> {
    let options =
        Options { compact_above: 600, compaction: Compaction::Inline, damage: Damage::Refuse };
    let journal = Journal::open_on(Arc::new(disk.clone()), options);
    let (mut journal, restored, _) = match journal {
        Ok(opened) => opened,
        Err(error) => {
            assert!(error.to_string().contains("power is off"), "{error}");
            model.perhaps_opened(disk.boot());
            return None;
        }
    };
    model.opened(disk.boot(), &restored);
    let mut latest = model.after_kill.clone();
    for _ in 0..random.u32(1..40) {
        for _ in 0..random.u32(1..4) {
            let record = records::any(random);
            journal.append(&record).expect("a batch is not long");
            latest.iter_mut().for_each(|replay| replay.apply(record.clone()));
        }
        let sync = random.bool();
        let written = if sync { journal.sync() } else { journal.commit() };
        match (written, sync) {
            (Err(_), _) => {
                model.wrote(&latest, Wrote::Failed);
                break;
            }
            (Ok(()), true) => model.wrote(&latest, Wrote::Synced),
            (Ok(()), false) => model.wrote(&latest, Wrote::Committed),
        }
    }
    Some(journal.compactions())
}

#[test]
fn any_loss_of_power_leaves_a_beginning_of_the_history() {
    let (mut cuts_while_opening, mut compactions) = (0, 0);
    for seed in 0..600 {
        let mut random = fastrand::Rng::with_seed(seed);
        let disk = Disk::default();
        let mut model = Model::new();
        for _ in 0..6 {
            disk.fail_after(random.u64(0..60));
            match live(&disk, &mut model, &mut random) {
                Some(done) => compactions += done,
                None => cuts_while_opening += 1,
            }
            if random.u8(0..3) == 0 {
                disk.kill_process();
            } else {
                disk.cut_power(&mut |below| random.usize(..below));
                model.power_was_cut();
            }
        }
        let last = live(&disk, &mut model, &mut random);
        assert!(last.is_some(), "with power it opens");
    }
    assert!(
        cuts_while_opening > 100 && compactions > 100,
        "{cuts_while_opening} cuts while opening, {compactions} compactions"
    );
}
