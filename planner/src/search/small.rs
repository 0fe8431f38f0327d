//! Random plans in worlds of a few hundred milliseconds, in which every start
//! can be tried.

use faregate_tickets::amount::{Microjoules, Milliwatts};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::parameters::{Day, Load, Parameters, Phase, PreheatRow, Zone};
use crate::plan::{Activity, ActivityId, Kind, Plan, StartRange};
use crate::state::{Mode, Running, State, Window};
use crate::units::{Ppm, Span, Time};

/// A plan with its parameters and its state.
pub(crate) type Small = (Plan, Parameters, State);

fn load(power: u64) -> Load {
    Load { marginal: Milliwatts::new(power), peak: Milliwatts::new(power + power / 2) }
}

fn phase((duration, power): (i64, u64)) -> Phase {
    Phase { duration: Span::new(duration), load: load(power) }
}

prop_compose! {
    fn zone(name: &'static str)(
        power in 0_u64..30,
        rows in vec((0_i64..12, 0_i64..20), 0..4),
    ) -> Zone {
        let mut from = 0;
        let rows = rows.into_iter().map(|(duration, gap)| {
            let row = PreheatRow { from: Span::new(from), duration: Span::new(duration) };
            from += gap + 1;
            row
        });
        Zone { name: name.into(), load: load(power), table: rows.collect() }
    }
}

prop_compose! {
    fn parameters()(
        soft in 0_i64..500_000, max in 300_000_i64..=1_000_000,
        peak in 60_u64..250, rtg in 0_u64..70, base in 0_u64..25, awake in 0_u64..70,
        wakeup in (0_i64..8, 0_u64..60), shutdown in (0_i64..8, 0_u64..60),
        min_awake in 0_i64..25, min_sleep in 0_i64..25, midnight in 0_i64..70,
        first in zone("a"), second in zone("b"), mandatory_from in 0_u32..4,
    ) -> Parameters {
        Parameters {
            mandatory_from,
            soft_min_soc: Ppm::new(soft), max_soc: Ppm::new(max),
            peak_limit: Milliwatts::new(peak), engines: 3,
            rtg: Milliwatts::new(rtg), base: Milliwatts::new(base),
            awake: load(awake), wakeup: phase(wakeup), shutdown: phase(shutdown),
            min_awake: Span::new(min_awake), min_sleep: Span::new(min_sleep),
            day: Day { length: Span::new(80), midnight: Time::new(midnight) },
            zones: vec![first, second],
            ..Parameters::default()
        }
    }
}

prop_compose! {
    fn activity()(
        length in 0_i64..40, longer in 0_i64..30, expands in proptest::bool::weighted(0.2),
        power in 0_u64..60, from in 0_i64..150, width in 0_i64..200, slack in 0_i64..60,
        zones in 0_usize..4, priority in 0_u32..4, bits in 0_u128..16,
    ) -> Activity {
        let mut it = Activity::new(ActivityId::new(1).unwrap(), Span::new(length));
        if expands {
            it.kind = Kind::Expanding { minimum: Span::new(length) };
            it.duration = Span::new(length + longer);
        }
        (it.marginal, it.peak) = (load(power).marginal, load(power).peak);
        it.priority = priority;
        let (from, to) = (Time::new(from), Time::new(from + width));
        it.starts = vec![StartRange { from, to, cutoff: to.after(Span::new(length + slack)) }];
        it.zones = [(1, "a"), (2, "b")].iter().filter(|zone| zones & zone.0 != 0)
            .map(|zone| zone.1.to_string()).collect();
        // Few bits, so that many run side by side.
        it.resources = faregate_agents::Categories::from_mask(bits & (bits >> 1));
        it
    }
}

prop_compose! {
    fn window()(
        start in 0_i64..280, length in 0_i64..20, awake in any::<bool>(), power in 0_u64..40,
    ) -> Window {
        Window {
            name: "w".into(), start: Time::new(start), end: Time::new(start + length), awake,
            marginal: load(power).marginal, peak: load(power).peak,
            data: Default::default(), engines: 0, resources: Default::default(),
        }
    }
}

fn mode() -> impl Strategy<Value = Mode> {
    prop_oneof![
        3 => Just(Mode::Asleep), 2 => Just(Mode::Awake),
        1 => Just(Mode::WakingUp), 1 => Just(Mode::ShuttingDown),
    ]
}

/// A manual shutdown: when, how long, and the parts of it.
fn block() -> impl Strategy<Value = Option<(i64, i64, i64, i64)>> {
    proptest::option::weighted(0.3, (0_i64..250, 10_i64..50, 0_i64..5, 0_i64..5))
}

prop_compose! {
    pub(crate) fn small()(
        parameters in parameters(), activities in vec(activity(), 1..9),
        windows in vec(window(), 0..3), block in block(), mode in mode(), since in 0_i64..40,
        capacity in 300_u64..6_000, charge in 0_u64..100, end in 60_i64..300,
        handover in 0_i64..300, minimum in 0_i64..900_000,
        heating in proptest::option::of(0_i64..20), running in proptest::option::weighted(0.3, 1_i64..60),
        ended in proptest::option::weighted(0.3, 1_i64..30),
    ) -> Small {
        let now = 30;
        let end = end + now;
        let mut activities = activities;
        if let Some((from, length, shutdown, wakeup)) = block {
            let mut it = Activity::new(ActivityId::new(1).unwrap(), Span::new(length));
            it.kind = Kind::ManualShutdown { shutdown: Span::new(shutdown), wakeup: Span::new(wakeup) };
            it.starts[0].from = Time::new(from);
            activities.push(it);
        }
        for (activity, number) in activities.iter_mut().zip(1..) {
            activity.id = ActivityId::new(number).unwrap();
        }
        let mut state = State {
            now: Time::new(now), mode, mode_since: Time::new(now - since),
            charge: Microjoules::new(capacity * charge / 100), capacity: Microjoules::new(capacity),
            windows, ..State::default()
        };
        if let Some(since) = heating {
            state.heating.insert("a".into(), Time::new(now - since));
        }
        if let Some(ends) = running && activities.len() > 1 {
            state.running.push(Running {
                id: activities[0].id, started: Time::new(now - 10), ends: Time::new(now + ends - 5),
                cutoff: Time::new(end), paused: (ends % 3 == 0).then_some(Time::new(now)),
                data: Default::default(),
            });
        }
        if let Some(ago) = ended && activities.len() > 2 {
            state.ended.push(crate::state::Ended {
                id: activities[1].id, outcome: crate::plan::Outcome::Succeeded,
                started: Some(Time::new(now - ago - 9)), ended: Time::new(now - ago),
                data: Default::default(),
            });
        }
        let plan = Plan {
            name: "small".into(), end: Time::new(end), handover: Time::new(handover.clamp(now, end)),
            handover_min_soc: Ppm::new(minimum), max_delta_data: crate::units::Bytes::new(1 << 40),
            next_plan: None, activities,
        };
        (plan, parameters, state)
    }
}
