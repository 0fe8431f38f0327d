//! Random histories of the books, in a world that lies late, hangs, forgets and
//! repeats itself. After each step the promises hold; after healing, the world
//! comes to rest with those valid whom an independent oracle names; after
//! everybody went home nothing is charged, taken or lost.

#![cfg(not(loom))]

mod books;

use books::step::{History, How, Limit, Step, Word};
use books::world::{Declared, GATES, Ground, Rules, Setup, World};
use proptest::prelude::*;

fn rules() -> impl Strategy<Value = Rules> {
    (
        prop::bool::weighted(0.25),
        prop::option::weighted(0.8, 6..16_u64),
        any::<bool>(),
        any::<bool>(),
    )
        .prop_map(|(exclusive, supply, categories, energy)| Rules {
            exclusive,
            supply,
            categories,
            energy,
        })
}

fn declared() -> impl Strategy<Value = Declared> {
    let draw = prop_oneof![1 => Just(0_u64), 6 => 2..8_u64];
    let categories = prop_oneof![3 => Just(0_u8), 1 => 1..4_u8];
    let bools = (any::<bool>(), prop::bool::weighted(0.2), prop::bool::weighted(0.2));
    (0..2_u8, draw, categories, 0..6_u64, 1..3_u8, bools).prop_map(
        |(agent, draw, categories, settling_ms, attempts, bools)| {
            let (safe_at_once, on_at_start, safe_unless_held) = bools;
            Declared {
                agent,
                draw,
                categories,
                settling_ms,
                attempts,
                safe_at_once,
                safe_unless_held,
                on_at_start,
            }
        },
    )
}

fn setup() -> impl Strategy<Value = Setup> {
    let agents = prop::collection::vec(rules(), 2);
    let devices = prop::collection::vec(declared(), GATES);
    (agents, devices).prop_map(|(agents, devices)| Setup { agents, devices })
}

fn priority() -> impl Strategy<Value = u8> {
    prop::sample::select(vec![0, 64, 65, 128, 255])
}

fn how() -> impl Strategy<Value = How> {
    prop_oneof![
        6 => Just(How::Well),
        1 => Just(How::Twice),
        1 => Just(How::Unreported),
        1 => Just(How::NotYet),
    ]
}

/// What holders do.
fn asked() -> impl Strategy<Value = Step> {
    let limits = vec![
        Limit::None,
        Limit::None,
        Limit::Invocations,
        Limit::Energy,
        Limit::ShortLease,
        Limit::DutyCycle,
    ];
    let gates = prop_oneof![
        3 => prop::collection::vec(any::<u8>(), 1),
        1 => prop::collection::vec(any::<u8>(), 2..4)
    ];
    let request = (gates, priority(), prop::sample::select(limits));
    let pair = || (any::<u8>(), any::<u8>());
    prop_oneof![
        8 => request.prop_map(|(gates, priority, limit)| Step::Request { gates, priority, limit }),
        3 => pair().prop_map(|(ticket, gate)| Step::Relinquish { ticket, gate }),
        1 => pair().prop_map(|(ticket, gate)| Step::Extend { ticket, gate }),
        6 => (pair(), prop::bool::weighted(0.7))
            .prop_map(|((ticket, gate), on)| Step::Command { ticket, gate, on }),
    ]
}

/// What supervisors do.
fn ordered() -> impl Strategy<Value = Step> {
    let any = any::<u8>;
    prop_oneof![
        any().prop_map(|ticket| Step::Bar { ticket }),
        any().prop_map(|seat| Step::StaleBar { seat }),
        any().prop_map(|ticket| Step::Reinstate { ticket }),
        (any(), 2..16_u64).prop_map(|(agent, supply)| Step::Supply { agent, supply }),
        (any(), priority()).prop_map(|(scope, floor)| Step::EnterSafeMode { scope, floor }),
        any().prop_map(|scope| Step::LeaveSafeMode { scope }),
        (any(), prop_oneof![Just(0_u64), 2..8_u64], 0..4_u8, 0..3_u64).prop_map(
            |(gate, draw, categories, longer_ms)| Step::Redeclare {
                gate,
                draw,
                categories,
                longer_ms
            }
        ),
        (any(), priority()).prop_map(|(ticket, floor)| Step::RevokeAllButMe { ticket, floor }),
    ]
}

/// What devices and sensors do.
fn suffered() -> impl Strategy<Value = Step> {
    let any = any::<u8>;
    let words = prop::sample::select(vec![
        Word::Prompt,
        Word::Prompt,
        Word::Late,
        Word::Late,
        Word::Unknown,
    ]);
    prop_oneof![
        4 => (0..4_u8).prop_map(|ms| Step::Pass { ms }),
        2 => (4..20_u8).prop_map(|ms| Step::Pass { ms }),
        4 => (any(), words.clone()).prop_map(|(gate, word)| Step::Measure { gate, word }),
        2 => words.prop_map(|word| Step::MeasureAll { word }),
        3 => any().prop_map(|which| Step::LateEstimate { which }),
        1 => (any(), 1..4_u8).prop_map(|(gate, times)| Step::Deaf { gate, times }),
        1 => (any(), prop::bool::weighted(0.3)).prop_map(|(gate, hung)| Step::Hang { gate, hung }),
        1 => any().prop_map(|ticket| Step::DriverFault { ticket }),
        1 => any().prop_map(|gate| Step::Reset { gate }),
        1 => any().prop_map(|gate| Step::Unbidden { gate }),
    ]
}

/// What the shell does.
fn served() -> impl Strategy<Value = Step> {
    prop_oneof![
        4 => Just(Step::Look),
        12 => how().prop_map(|how| Step::Work { how }),
        1 => any::<u8>().prop_map(|which| Step::Report { which }),
        1 => (any::<u8>(), how()).prop_map(|(which, how)| Step::LateWork { which, how }),
        6 => Just(Step::Service),
        1 => Just(Step::Settle),
    ]
}

fn history() -> impl Strategy<Value = History> {
    let step = prop_oneof![8 => asked(), 2 => ordered(), 6 => suffered(), 8 => served()];
    prop::collection::vec(step, 1..60).prop_map(History)
}

fn live_through(setup: Setup, history: &[Step]) {
    let ground = Ground::new(setup);
    let mut gates = ground.gates();
    let mut world = World::new(&ground, &mut gates);
    for step in history {
        world.apply(step);
        world.check();
    }
    world.heal_and_settle();
    world.check_chosen();
    world.go_home();
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_promises_hold_through_any_history(setup in setup(), history in history()) {
        live_through(setup, &history.0);
    }
}
