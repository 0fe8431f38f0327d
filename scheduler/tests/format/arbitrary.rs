//! Random tasks, each of which some file can say.

use std::collections::BTreeSet;

use faregate_agents::Categories;
use faregate_scheduler::manager::limits::{GRACE, SHORTEST_INTERVAL};
use faregate_scheduler::task::{
    Body, BuiltIn, CheckpointSignal, Dependency, Overrun, Preemption, Restart, Spread, Status,
    Step, TaskPriority, When, Window,
};
use faregate_scheduler::time::{Duration, UnixTime};
use faregate_scheduler::{Task, TaskId};
use faregate_tickets::amount::Milliwatts;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use proptest::sample::select;

/// From 1970 to the end of the year 9999, the last that TOML can say.
fn time() -> impl Strategy<Value = UnixTime> {
    (1..253_402_300_799_999_999_i64).prop_map(UnixTime::from_micros)
}

pub(crate) fn duration() -> impl Strategy<Value = Duration> {
    prop_oneof![
        3 => (0..100_000_u64).prop_map(Duration::from_secs),
        2 => (0..100_000_000_u64).prop_map(Duration::from_millis),
        1 => any::<u64>().prop_map(Duration::from_micros),
    ]
}

fn when() -> impl Strategy<Value = When> {
    prop_oneof![
        Just(When::Unrestricted),
        duration().prop_map(When::AfterLoad),
        time().prop_map(When::At),
    ]
}

pub(crate) fn is_before(earlier: When, later: When) -> bool {
    match (earlier, later) {
        (When::AfterLoad(earlier), When::AfterLoad(later)) => earlier < later,
        (When::At(earlier), When::At(later)) => earlier < later,
        _ => false,
    }
}

fn window() -> impl Strategy<Value = Window> {
    (when(), when()).prop_map(|(opens, closes)| match is_before(closes, opens) {
        true => Window { opens: closes, closes: opens },
        false => Window { opens, closes },
    })
}

/// Anything that people or programs put into arguments.
pub(crate) fn word() -> impl Strategy<Value = String> {
    prop_oneof!["[a-z]{1,8}", "[ -~]{0,12}", "[^\0]{0,6}"]
}

pub(crate) fn name() -> impl Strategy<Value = String> {
    prop_oneof!["[a-z]{1,8}", "[^\0]{1,6}"]
}

fn id() -> impl Strategy<Value = TaskId> {
    (1..=u32::MAX).prop_filter_map("0", TaskId::new)
}

fn built_in() -> impl Strategy<Value = BuiltIn> {
    prop_oneof![
        any::<bool>().prop_map(|all| BuiltIn::Clear { all }),
        vec(id(), 1..4).prop_map(BuiltIn::Remove),
        name().prop_map(BuiltIn::Load),
        name().prop_map(BuiltIn::EnterMode),
        name().prop_map(BuiltIn::LeaveMode),
    ]
}

fn step() -> impl Strategy<Value = Step> {
    (duration(), name(), name(), vec(word(), 0..3), any::<bool>()).prop_map(
        |(offset, gate, command, arguments, continues)| Step {
            offset,
            gate,
            command,
            arguments,
            continues,
        },
    )
}

fn body() -> impl Strategy<Value = Body> {
    prop_oneof![
        4 => (name(), vec(word(), 0..4))
            .prop_map(|(program, arguments)| Body::Process { program, arguments }),
        1 => (16..=u16::MAX, vec(word(), 0..4))
            .prop_map(|(number, arguments)| Body::Function { number, arguments }),
        1 => vec(step(), 1..4).prop_map(Body::Sequence),
        1 => Just(Body::Hold),
        1 => built_in().prop_map(Body::BuiltIn),
    ]
}

fn pre_emption() -> impl Strategy<Value = Preemption> {
    let signal = select(vec![
        CheckpointSignal::User1,
        CheckpointSignal::User2,
        CheckpointSignal::Terminate,
        CheckpointSignal::HangUp,
        CheckpointSignal::Interrupt,
    ]);
    let grace = prop_oneof![Just(GRACE), duration()].boxed();
    prop_oneof![
        Just(Preemption::Wait),
        Just(Preemption::Pause),
        (grace.clone(), signal)
            .prop_map(|(grace, signal)| Preemption::Checkpoint { grace, signal }),
        grace.prop_map(|grace| Preemption::Kill { grace }),
    ]
}

fn dependency() -> impl Strategy<Value = Dependency> {
    use Status::{Aborted, Completed, Failed, Finished, Missed, Succeeded};
    let status = select(vec![Succeeded, Failed, Aborted, Missed, Completed, Finished]);
    (id(), status).prop_map(|(task, status)| Dependency { task, status })
}

pub(crate) fn categories() -> impl Strategy<Value = Categories> {
    prop_oneof![
        Just(0),
        (0..128_u32).prop_map(|bit| 1 << bit),
        (0..256_u128),
        any::<u128>(),
        Just(u128::MAX),
    ]
    .prop_map(Categories::from_mask)
}

fn times(task: Task) -> impl Strategy<Value = Task> {
    let spread = option::of((0..1_000_u64, 0..1_000_u64));
    (vec(window(), 1..3), when(), duration(), spread, option::of(duration()), duration()).prop_map(
        move |(windows, cutoff, dur, spread, interval, gap)| {
            let mut task = task.clone();
            let early = windows.iter().all(|window| is_before(cutoff, window.opens));
            task.cutoff = if early { When::Unrestricted } else { cutoff };
            task.spread = spread.filter(|_| !dur.is_zero()).map(|(less, more)| Spread {
                shortest: dur.saturating_sub(Duration::from_micros(less)),
                longest: dur.saturating_add(Duration::from_micros(more)),
            });
            task.interval = interval.filter(|interval| *interval >= SHORTEST_INTERVAL);
            (task.windows, task.duration, task.gap) = (windows, dur, gap);
            task
        },
    )
}

fn needs(task: Task) -> impl Strategy<Value = Task> {
    let bytes = || prop_oneof![Just(0), 0..1_u64 << 40, any::<u64>()];
    let draws =
        prop_oneof![Just((0, 0)), (0..100_000_u64, 0..=100_u64), (any::<u64>(), 0..=100_u64)];
    let gates = prop_oneof![Just(None), vec(name(), 0..3).prop_map(Some)];
    (categories(), bytes(), bytes(), 0..=100_u8, draws, bytes(), gates).prop_map(
        move |(categories, memory, storage, battery, (peak, percent), data, gates)| {
            let mut task = task.clone();
            (task.categories, task.memory, task.storage) = (categories, memory, storage);
            (task.battery, task.data) = (battery, data);
            task.peak_draw = Milliwatts::new(peak);
            task.average_draw = Milliwatts::new(peak / 100 * percent);
            let mut all: Vec<String> = gates.into_iter().flatten().collect();
            if let Body::Sequence(steps) = &task.body {
                all.extend(steps.iter().map(|step| step.gate.clone()));
            }
            let mut seen = BTreeSet::new();
            all.retain(|gate| seen.insert(gate.clone()));
            task.gates = all;
            task
        },
    )
}

fn policies(task: Task) -> impl Strategy<Value = Task> {
    let restart = option::of((any::<u32>(), duration()));
    let overrun = select(vec![Overrun::Report, Overrun::Abort, Overrun::AbortAndRestart]);
    let heartbeat = option::of(duration());
    let others = (option::of(name()), 0..=239_u8, any::<bool>(), option::of(id()));
    (pre_emption(), restart, overrun, heartbeat, vec(dependency(), 0..3), others).prop_map(
        move |(
            preemption,
            restart,
            overrun,
            heartbeat,
            after,
            (name, priority, mandatory, cleanup),
        )| {
            let mut task = task.clone();
            let suits = match (&task.body, preemption) {
                (Body::Function { .. }, Preemption::Checkpoint { .. }) => true,
                (Body::Function { .. } | Body::BuiltIn(_), _) => false,
                _ => true,
            };
            task.preemption = if suits { preemption } else { task.preemption };
            task.restart = restart
                .map_or(Restart::Never, |(limit, back_off)| Restart::OnFailure { limit, back_off });
            task.overrun = overrun;
            task.heartbeat = heartbeat.filter(|heartbeat| !heartbeat.is_zero());
            (task.after, task.name, task.mandatory) = (after, name, mandatory);
            task.priority = TaskPriority::new(priority).unwrap_or_default();
            task.cleanup = cleanup;
            task
        },
    )
}

/// Any task that makes sense by itself.
pub(crate) fn task() -> impl Strategy<Value = Task> {
    (id(), body())
        .prop_map(|(id, body)| Task::new(id, body))
        .prop_flat_map(times)
        .prop_flat_map(needs)
        .prop_flat_map(policies)
}

/// Tasks with ids of their own.
pub(crate) fn tasks() -> impl Strategy<Value = Vec<Task>> {
    vec(task(), 0..6).prop_map(|mut tasks| {
        let mut seen = BTreeSet::new();
        tasks.retain(|task| seen.insert(task.id));
        tasks
    })
}
