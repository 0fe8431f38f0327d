//! Opening a journal of 10 000 tasks after an unclean end.

use std::path::Path;
use std::time::{Duration, Instant};

use faregate_scheduler::journal::{Compaction, Damage, Journal, Options, replay};
use faregate_scheduler::manager::{Record, Restored};

use crate::ROW;
use crate::database::{Commit, Log};
use crate::records::{accepted, life, place};
use crate::support::{Bench, Failure, Quantiles, Target};

const TASKS: u32 = 10_000;
const ROUNDS: u32 = 30;
/// What a resumed manager may take from exec to its first decision.
const RESUME_MS: f64 = 100.0;

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let place = place()?;
    let records = history()?;
    let expected = replay(records.iter().cloned());
    let [log, snapshot, database] =
        ["log", "snapshot", "tasks.redb"].map(|name| place.path().join(name));
    write(&log, &records, Compaction::Never)?;
    write(&snapshot, &records, Compaction::Inline)?;
    let mut peer = Log::create(&database)?;
    for batch in records.chunks(100) {
        peer.write(batch, Commit::QuickRepair)?;
    }
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..bench.rounds().min(ROUNDS) {
        times[0].push(journal(&log, &expected)?);
        times[1].push(journal(&snapshot, &expected)?);
        times[2].push(repaired(&database, &place.path().join("copy.redb"), &expected)?);
    }
    let [log, snapshot, peer] = times.map(|times| {
        Quantiles::of(times.iter().map(Duration::as_secs_f64).map(|s| s * 1e3).collect())
    });
    let figures = [
        ("opening 10 000 tasks, unclean, from a log", log, Target::AtMost(RESUME_MS)),
        ("opening 10 000 tasks, unclean, compacted", snapshot, Target::AtMost(RESUME_MS)),
        ("the same records from redb, quick repair", peer, Target::None),
    ];
    for (name, times, target) in figures {
        bench.figure(ROW, &format!("{name}, 5th percentile"), times.p5, "ms", Target::None);
        bench.figure(ROW, &format!("{name}, median"), times.median, "ms", target);
    }
    Ok(())
}

/// All tasks accepted in one load, and a fifth of them run.
fn history() -> Result<Vec<Record>, Failure> {
    let mut records = (1..=TASKS).map(accepted).collect::<Result<Vec<_>, _>>()?;
    for number in 1..=TASKS / 5 {
        records.extend(life(number, 0)?);
    }
    Ok(records)
}

/// Left as by a process that dies: dropped, not closed.
fn write(path: &Path, records: &[Record], compaction: Compaction) -> Result<(), Failure> {
    let options = Options { compact_above: 0, compaction, damage: Damage::Refuse };
    let (mut journal, ..) = Journal::open(path, options)?;
    for batch in records.chunks(100) {
        batch.iter().try_for_each(|record| journal.append(record))?;
        journal.commit()?;
    }
    // The next log is made, then the long one is added up, then that is found.
    (0..3).try_for_each(|_| journal.sync())?;
    let compacted = u64::from(compaction == Compaction::Inline);
    if journal.compactions() < compacted {
        return Err("the journal was not compacted".into());
    }
    Ok(())
}

fn journal(path: &Path, expected: &Restored) -> Result<Duration, Failure> {
    let began = Instant::now();
    let (_journal, restored, opened) = Journal::open(path, Options::default())?;
    let took = began.elapsed();
    if opened.clean || restored != *expected {
        return Err("the journal does not give back what was written".into());
    }
    Ok(took)
}

/// A copy of a database that is open is one whose process died.
fn repaired(from: &Path, copy: &Path, expected: &Restored) -> Result<Duration, Failure> {
    std::fs::copy(from, copy)?;
    let began = Instant::now();
    let restored = replay(Log::create(copy)?.read()?);
    let took = began.elapsed();
    if restored != *expected {
        return Err("the database does not give back what was written".into());
    }
    Ok(took)
}
