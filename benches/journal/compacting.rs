//! Whether a compaction delays those who write meanwhile.

use std::time::Instant;

use faregate_scheduler::journal::{Compaction, Damage, Journal, Options};

use crate::ROW;
use crate::records::{accepted, life, place};
use crate::support::{Bench, Failure, Quantiles, Target};

const TASKS: u32 = 10_000;
/// Often, so that most records are written while one goes on.
const COMPACT_ABOVE: u64 = 64 << 10;

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let records = bench.rounds().saturating_mul(10);
    let never = commits(Compaction::Never, records)?;
    let meanwhile = commits(Compaction::Background, records)?;
    for (name, times) in [("not compacting", never), ("compacting", meanwhile)] {
        let Quantiles { median, p999, .. } = times;
        bench.figure(ROW, &format!("a record written, {name}, median"), median, "us", Target::None);
        bench.figure(ROW, &format!("a record written, {name}, p99.9"), p999, "us", Target::None);
    }
    Ok(())
}

/// How long commits take, in microseconds, with 10 000 tasks in the schedule.
fn commits(compaction: Compaction, records: u32) -> Result<Quantiles, Failure> {
    let place = place()?;
    let options = Options { compact_above: COMPACT_ABOVE, compaction, damage: Damage::Refuse };
    let (mut journal, ..) = Journal::open(&place.path().join("journal"), options)?;
    for number in 1..=TASKS {
        journal.append(&accepted(number)?)?;
    }
    journal.sync()?;
    let mut times = Vec::new();
    for number in 0..records {
        for record in life(1 + number % TASKS, u64::from(number / TASKS))? {
            journal.append(&record)?;
            let began = Instant::now();
            journal.commit()?;
            times.push(began.elapsed().as_secs_f64() * 1e6);
        }
        if number % 10 == 0 {
            journal.sync()?;
        }
    }
    Ok(Quantiles::of(times))
}
