//! The same world some time later, when a part of its plan was executed: never
//! quite as planned.

use faregate_planner::plan::{Kind, Outcome};
use faregate_planner::state::{Ended, Mode, Running};
use faregate_planner::timed::{Fate, Slot, TimedPlan};
use faregate_planner::units::{Bytes, Span, Time};
use faregate_planner::{Activity, State};
use faregate_tickets::amount::Microjoules;
use fastrand::Rng;

use super::World;

/// What has become of a world while its plan was executed.
pub(crate) fn later(world: &World, timed: &TimedPlan, seed: u64) -> World {
    let mut rng = Rng::with_seed(seed ^ 0x1a7e4);
    let mut later = world.clone();
    let now = instant(world, timed, &mut rng);
    computer(&mut later.state, timed, now);
    later.state.heating.clear();
    for heated in timed.preheats.iter().filter(|one| one.start <= now && now < one.end) {
        later.state.heating.insert(heated.zone.clone(), heated.start);
    }
    later.state.running.clear();
    for (activity, row) in world.plan.activities.iter().zip(&timed.rows) {
        match row.fate {
            Fate::Scheduled(slot) if slot.start < now && !is_manual(activity) => {
                begun(&mut later.state, activity, slot, now, &mut rng);
            }
            Fate::Running(slot) => begun(&mut later.state, activity, slot, now, &mut rng),
            _ => {}
        }
    }
    let fuel = world.parameters.timelines.iter().find(|line| line.name == "fuel");
    disturb(&mut later.state, fuel.map_or(0, |line| line.max), &mut rng);
    later.state.now = now;
    later
}

/// Some instant; often shortly before something starts, so that it is in the
/// commit window.
fn instant(world: &World, timed: &TimedPlan, rng: &mut Rng) -> Time {
    let (first, last) = (world.state.now.get(), world.plan.end.get() - 1);
    let starts = timed.rows.iter().filter_map(|row| timed.slot(row.id));
    let starts: Vec<i64> = starts.map(|slot| slot.start.get()).collect();
    let some = match rng.choice(&starts) {
        Some(start) if rng.bool() => {
            start - rng.i64(0..=world.parameters.commit.get() + last / 100)
        }
        _ => rng.i64(first..=last),
    };
    Time::new(some.clamp(first, last))
}

fn is_manual(activity: &Activity) -> bool {
    matches!(activity.kind, Kind::ManualShutdown { .. })
}

/// What the computer does then, if it does what was planned.
fn computer(state: &mut State, timed: &TimedPlan, now: Time) {
    for phase in timed.awake.iter().filter(|phase| phase.wakeup <= now) {
        // What the plan found begun goes on since when it had begun.
        let begun = |mode| phase.wakeup == state.now && state.mode == mode;
        (state.mode, state.mode_since) = match () {
            () if now < phase.up && begun(Mode::WakingUp) => (Mode::WakingUp, state.mode_since),
            () if now < phase.up => (Mode::WakingUp, phase.wakeup),
            () if now < phase.down && begun(Mode::Awake) => (Mode::Awake, state.mode_since),
            () if now < phase.down => (Mode::Awake, phase.up),
            () if now < phase.asleep => (Mode::ShuttingDown, phase.down),
            () => (Mode::Asleep, phase.asleep),
        };
    }
}

/// It was started; it runs, or has ended, a little otherwise than planned.
fn begun(state: &mut State, activity: &Activity, slot: Slot, now: Time, rng: &mut Rng) {
    let (id, started) = (activity.id, slot.start);
    if started < now && rng.u8(0..10) == 0 {
        // It waits for tickets, or was refused: nobody has started it.
        return;
    }
    let length = slot.length().get();
    let early = if rng.u8(0..4) == 0 { rng.i64(0..=length / 2) } else { 0 };
    let ended = slot.end.before(Span::new(early));
    if ended <= now && rng.u8(0..8) > 0 {
        let all = [Outcome::Succeeded, Outcome::Succeeded, Outcome::Failed, Outcome::Aborted];
        let outcome = all[rng.usize(0..all.len())];
        let (started, data) = (Some(started), activity.data);
        state.ended.push(Ended { id, outcome, started, ended, data });
    } else {
        let cutoff = activity.starts.get(slot.range).map_or(slot.end, |range| range.cutoff);
        let paused = (rng.u8(0..12) == 0).then_some(now);
        let data = Bytes::new(activity.data.get().max(0) / 2);
        state.running.push(Running { id, started, ends: slot.end, cutoff, paused, data });
    }
}

/// What nobody planned.
fn disturb(state: &mut State, fuel: i64, rng: &mut Rng) {
    let share = rng.u64(25..=100);
    if rng.bool() {
        state.charge = Microjoules::new(state.capacity.get() / 100 * share);
    }
    if rng.u8(0..6) == 0 {
        state.windows.pop();
    }
    if rng.u8(0..8) == 0 {
        state.cold = vec!["arm".into()];
    }
    if rng.u8(0..6) == 0 {
        state.timelines.insert("mode".into(), rng.i64(0..=3));
        state.timelines.insert("fuel".into(), rng.i64(0..=fuel));
    }
}
