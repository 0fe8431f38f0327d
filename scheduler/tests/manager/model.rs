//! The manager after any history: agents and bodies that answer when they
//! like, tickets that somebody outside takes, and a reference that looks at
//! every pair of tasks.

mod agents;
mod bench;
mod reference;

use core::fmt;

use faregate_agents::Categories;
use faregate_scheduler::task::{CheckpointSignal, Preemption, Task};
use faregate_tickets::amount::Milliwatts;
use proptest::prelude::*;
use proptest_state_machine::{ReferenceStateMachine, StateMachineTest, prop_state_machine};

use crate::model::bench::Bench;
use crate::world::{With, seconds, task};

/// What can happen. Numbers choose among those that are there.
#[derive(Clone, Debug)]
pub(crate) enum Transition {
    Add(Spec),
    Second,
    /// A body ends by itself.
    Exit(usize, bool),
    Hold(usize),
    Resume(usize),
    Priority(usize, u8),
    Remove(usize),
    /// Somebody outside takes tickets, and keeps them from being granted.
    Bar(usize),
    Unbar,
    /// From now on agents and bodies keep what they have to say to themselves.
    Slow,
    /// They say it, and everything comes to rest.
    Quick,
}

/// A task that is added, told in a line. Its id is the number of its addition.
#[derive(Clone)]
pub(crate) struct Spec(pub(crate) Box<Task>);

impl fmt::Debug for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Task { priority, categories, peak_draw, memory, gap, .. } = &*self.0;
        let (window, interval) = (self.0.windows[0], self.0.interval);
        write!(f, "p{} c{categories} {peak_draw} {memory}B gap {gap}", priority.level())?;
        write!(f, " {:?} {window:?} every {interval:?}", self.0.preemption)
    }
}

/// Any history is possible.
#[derive(Clone, Debug, Default)]
pub(crate) struct Histories;

fn preemption() -> impl Strategy<Value = Preemption> {
    let signal = CheckpointSignal::User1;
    prop_oneof![
        4 => Just(Preemption::Pause),
        2 => Just(Preemption::Wait),
        2 => Just(Preemption::Kill { grace: seconds(1.0) }),
        1 => Just(Preemption::Checkpoint { grace: seconds(1.0), signal }),
    ]
}

fn tasks() -> impl Strategy<Value = Spec> {
    let times = (0..4_u8, proptest::option::of(0..6_u8), proptest::option::of(1..5_u8));
    let needs = (0..8_u128, 0..3_u32, 0..3_u64, 0..3_u8);
    (0..3_u8, times, needs, preemption()).prop_map(
        move |(
            priority,
            (opens, closes, interval),
            (categories, draw, memory, gap),
            preemption,
        )| {
            let opens = f64::from(opens);
            let task = task(1, 0.0).priority(priority).at(opens).with(|task| {
                task.categories = Categories::from_mask(categories);
                task.peak_draw = Milliwatts::from_watts(draw);
                task.memory = memory;
                task.gap = seconds(f64::from(gap.saturating_sub(1)));
                task.preemption = preemption;
                task.interval = interval.map(|interval| seconds(f64::from(interval) * 2.0));
            });
            Spec(Box::new(match closes {
                Some(closes) => task.closes(opens + f64::from(closes)),
                None => task,
            }))
        },
    )
}

impl ReferenceStateMachine for Histories {
    type State = Self;
    type Transition = Transition;

    fn init_state() -> BoxedStrategy<Self> {
        Just(Self).boxed()
    }

    fn transitions(_: &Self) -> BoxedStrategy<Transition> {
        let which = 0..8_usize;
        prop_oneof![
            6 => tasks().prop_map(Transition::Add),
            6 => Just(Transition::Second),
            6 => (which.clone(), any::<bool>()).prop_map(|(n, ok)| Transition::Exit(n, ok)),
            1 => which.clone().prop_map(Transition::Hold),
            1 => which.clone().prop_map(Transition::Resume),
            1 => (which.clone(), 0..3_u8).prop_map(|(n, p)| Transition::Priority(n, p)),
            1 => which.clone().prop_map(Transition::Remove),
            1 => which.prop_map(Transition::Bar),
            1 => Just(Transition::Unbar),
            1 => Just(Transition::Slow),
            2 => Just(Transition::Quick),
        ]
        .boxed()
    }

    fn apply(state: Self, _: &Transition) -> Self {
        state
    }
}

struct Checked;

impl StateMachineTest for Checked {
    type SystemUnderTest = Bench;
    type Reference = Histories;

    fn init_test(_: &Histories) -> Bench {
        Bench::new()
    }

    fn apply(mut bench: Bench, _: &Histories, transition: Transition) -> Bench {
        bench.apply(transition);
        bench
    }

    fn teardown(bench: Bench, _: Histories) {
        bench.finish();
    }
}

prop_state_machine! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn after_any_history_who_runs_is_who_should_and_nothing_is_lost(
        sequential 1..60 => Checked
    );
}
