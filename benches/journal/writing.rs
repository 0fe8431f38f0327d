//! What a record costs that survives the process, or the power.

use std::cell::RefCell;
use std::fs::File;
use std::io::Write;

use faregate_scheduler::journal::{Compaction, Journal, Options};

use crate::ROW;
use crate::database::{Commit, Log};
use crate::records::{life, place};
use crate::support::{Bench, Failure, Target};

/// No entrant's own housekeeping counts here.
const ALONE: Options = Options {
    compact_above: u64::MAX,
    compaction: Compaction::Never,
    damage: faregate_scheduler::journal::Damage::Refuse,
};

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let place = place()?;
    let at = |name: &str| place.path().join(name);
    let [_, record, ..] = life(1, 0)?;
    let record = [record];
    let failed = Failed::default();

    let (mut journal, ..) = Journal::open(&at("killed"), ALONE)?;
    let mut volatile = Log::create(&at("volatile.redb"))?;
    let mut contest = bench.contest("a record, of which only kill -9 is to be survived");
    let own = contest.enter("journal, written", |n| {
        (0..n)
            .for_each(|_| failed.note(journal.append(&record[0]).and_then(|()| journal.commit())));
    });
    let peer = contest.enter("redb, not durable: does not survive it", |n| {
        (0..n).for_each(|_| failed.note(volatile.write(&record, Commit::Volatile)));
    });
    let times = contest.run();
    bench.figure(
        ROW,
        "a record that survives kill -9",
        times.of(own).median / 1e3,
        "us",
        Target::None,
    );
    bench.ratio(ROW, "journal, written / redb, not durable", &times, (own, peer), Target::None);
    bench.peers(&times);

    let (mut journal, ..) = Journal::open(&at("cut"), ALONE)?;
    let mut durable = Log::create(&at("durable.redb"))?;
    let mut quick = Log::create(&at("quick.redb"))?;
    let mut bare = File::create(at("bare"))?;
    let rounds = bench.rounds().min(1_000);
    let mut contest = bench.contest("a record that survives the loss of power").rounds(rounds);
    let own = contest.enter("journal, synced", |n| {
        (0..n).for_each(|_| failed.note(journal.append(&record[0]).and_then(|()| journal.sync())));
    });
    contest.enter("write and fdatasync of as many bytes", |n| {
        (0..n).for_each(|_| failed.note(bare.write_all(&[7; 29]).and_then(|()| bare.sync_data())));
    });
    contest.enter("redb, durable", |n| {
        (0..n).for_each(|_| failed.note(durable.write(&record, Commit::Durable)));
    });
    let peer = contest.enter("redb, durable, with quick repair", |n| {
        (0..n).for_each(|_| failed.note(quick.write(&record, Commit::QuickRepair)));
    });
    let times = contest.run();
    bench.figure(
        ROW,
        "a record that survives the loss of power",
        times.of(own).median / 1e3,
        "us",
        Target::None,
    );
    bench.ratio(ROW, "journal, synced / redb with quick repair", &times, (own, peer), Target::None);
    bench.peers(&times);
    failed.check()
}

/// Whether any operation of a contest failed: its time would then count for
/// nothing.
#[derive(Debug, Default)]
struct Failed(RefCell<Option<Failure>>);

impl Failed {
    fn note<E: Into<Failure>>(&self, result: Result<(), E>) {
        if let Err(error) = result {
            *self.0.borrow_mut() = Some(error.into());
        }
    }

    fn check(&self) -> Result<(), Failure> {
        self.0.take().map_or(Ok(()), Err)
    }
}
