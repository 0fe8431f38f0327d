//! The manager on a disk that loses power, or in a process that is killed, at
//! any operation, again and again, until the schedule is over: no accepted task
//! is lost, and none is begun twice.
//!
//! What really began is kept apart from the journal, as a camera keeps its
//! pictures.

#[path = "power_loss/life.rs"]
mod life;
#[path = "power_loss/truth.rs"]
mod truth;

use std::sync::Arc;

use faregate_scheduler::journal::memory::Disk;
use faregate_scheduler::journal::{Compaction, Damage, Journal, Options};
use faregate_scheduler::task::{Body, Restart, Task, TaskId, TaskPriority, When, Window};
use faregate_scheduler::time::Duration;

use life::{End, Life};
use truth::Truth;

/// How a life may end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Death {
    /// What was written stays.
    Kill,
    /// What was not synced goes, in any part.
    PowerLoss,
    /// Either.
    Any,
}

const ALONE: Options =
    Options { compact_above: u64::MAX, compaction: Compaction::Never, damage: Damage::Refuse };

/// What many histories came to.
#[derive(Debug, Default)]
struct Tally {
    lives: u64,
    starts: usize,
    interrupted: u64,
    may_have_started: u64,
}

/// A whole history: lives on one disk until the schedule is over.
fn history(seed: u64, death: Death, tally: &mut Tally) -> (Truth, Disk) {
    let mut random = fastrand::Rng::with_seed(seed);
    let disk = Disk::default();
    let mut truth = Truth::new((1..=random.u32(2..12)).map(|id| any_task(id, &mut random)));
    for lives in 0.. {
        assert!(lives < 400, "the schedule does not come to its end");
        // Longer and longer, so that it ends.
        disk.fail_after(random.u64(0..(20 + lives * 3)));
        let end = Life::begin(&disk, &mut truth, &mut random).and_then(Life::go_on);
        tally.lives += 1;
        match end {
            Ok(End::Over) => break,
            Ok(End::Dead) | Err(_) => {}
        }
        if death == Death::Kill || (death == Death::Any && random.bool()) {
            disk.kill_process();
        } else {
            disk.cut_power(&mut |below| random.usize(..below));
            truth.power_was_lost = true;
        }
        truth.everybody_dies();
        truth.wait(Duration::from_millis(random.u64(0..8_000)));
    }
    tally.starts += truth.starts();
    tally.interrupted += truth.interrupted;
    tally.may_have_started += truth.may_have_started;
    (truth, disk)
}

fn any_task(number: u32, random: &mut fastrand::Rng) -> Task {
    let id = TaskId::new(number).expect("not 0");
    let opens = match random.u8(0..4) {
        0 => When::Unrestricted,
        _ => When::AfterLoad(Duration::from_millis(random.u64(0..200) * 100)),
    };
    let restart = if random.bool() {
        Restart::Never
    } else {
        Restart::OnFailure { limit: 1_000, back_off: Duration::from_secs(1) }
    };
    Task {
        windows: vec![Window { opens, closes: When::Unrestricted }],
        duration: Duration::from_millis(random.u64(0..50) * 100),
        categories: faregate_agents::Categories::from_mask(random.u128(0..4)),
        priority: TaskPriority::new(random.u8(0..3)).expect("a task's"),
        restart,
        ..Task::new(id, Body::Process { program: "true".into(), arguments: Vec::new() })
    }
}

fn histories(death: Death) -> Tally {
    let mut tally = Tally::default();
    for seed in 0..400 {
        let name = format!("{death:?}, seed {seed}");
        let (truth, disk) = history(seed, death, &mut tally);
        disk.kill_process();
        let told = Journal::open_on(Arc::new(disk), ALONE).expect("the power is on").1;
        truth.check_at_the_end(&told, &name);
    }
    tally
}

#[test]
fn a_manager_that_is_killed_loses_no_task_and_begins_none_twice() {
    let tally = histories(Death::Kill);
    assert_eq!(tally.may_have_started, 0, "what was written was doubted");
    assert!(
        tally.interrupted > 100 && tally.lives > 1_000,
        "nothing was put to the test: {tally:?}"
    );
}

#[test]
fn power_that_is_lost_costs_no_task_and_begins_none_twice() {
    let tally = histories(Death::PowerLoss);
    assert!(tally.may_have_started > 20 && tally.interrupted > 100, "{tally:?}");
}

#[test]
fn kills_and_losses_of_power_mixed_cost_no_task_and_begin_none_twice() {
    let tally = histories(Death::Any);
    assert!(tally.may_have_started > 10 && tally.interrupted > 100, "{tally:?}");
}
