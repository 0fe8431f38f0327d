//! The projection beside a world that is stepped ms by ms.

use std::collections::BTreeMap;

use faregate_planner::parameters::{Load, Phase, TimelineKind, TimelineSpec, Zone};
use faregate_planner::plan::{Effect, Impact, Kind, StartRange};
use faregate_planner::state::{Mode, Running, Window};
use faregate_planner::timed::{AwakePhase, Fate, Line, Preheat, Row, Slot};
use faregate_planner::units::{Bytes, Span, Time};
use faregate_planner::{Activity, ActivityId, Parameters, Plan, State, TimedPlan, project};
use faregate_tickets::amount::{Microjoules, Milliwatts};
use proptest::prelude::*;

const NOW: i64 = 3;
const END: i64 = 60;

const fn load(marginal: u64, peak: u64) -> Load {
    Load { marginal: Milliwatts::new(marginal), peak: Milliwatts::new(peak) }
}

fn parameters() -> Parameters {
    let film = TimelineSpec {
        name: "film".into(),
        kind: TimelineKind::Consumable,
        initial: 9,
        min: i64::MIN / 4,
        max: i64::MAX / 4,
    };
    Parameters {
        rtg: Milliwatts::new(11),
        base: Milliwatts::new(4),
        awake: load(6, 20),
        wakeup: Phase { duration: Span::new(2), load: load(9, 30) },
        shutdown: Phase { duration: Span::new(3), load: load(5, 10) },
        zones: vec![Zone { name: "wheels".into(), load: load(3, 40), table: Vec::new() }],
        timelines: vec![film],
        ..Parameters::default()
    }
}

/// What the world of one case is made of.
#[derive(Clone, Debug)]
struct Case {
    slots: Vec<(i64, i64, u64, i64)>,
    phases: Vec<i64>,
    heated: Option<(i64, i64)>,
    window: (i64, i64),
    charge: u64,
    paused: bool,
    shutting_down: bool,
    manual: bool,
}

fn case() -> impl Strategy<Value = Case> {
    let slots = proptest::collection::vec((NOW..50, 1i64..10, 0u64..9, -5i64..9), 1..6);
    let heated = proptest::option::of((NOW..40, 41i64..60));
    let parts = (slots, proptest::collection::vec(1i64..9, 0..9), heated, (0i64..40, 41i64..70));
    (parts, 0u64..130, any::<[bool; 3]>()).prop_map(
        |((slots, phases, heated, window), charge, flags)| Case {
            slots,
            phases,
            heated,
            window,
            charge,
            paused: flags[0],
            shutting_down: flags[1],
            manual: flags[2],
        },
    )
}

fn id(number: usize) -> ActivityId {
    ActivityId::new(u32::try_from(number + 1).expect("small")).expect("not 0")
}

/// Of the activities the first one runs already; a manual shutdown comes last.
fn plan(case: &Case) -> Plan {
    let activities = case.slots.iter().enumerate().map(|(number, &(_, length, power, data))| {
        let mut activity = Activity::new(id(number), Span::new(length));
        (activity.marginal, activity.peak) = (Milliwatts::new(power), Milliwatts::new(2 * power));
        (activity.data, activity.engines) = (Bytes::new(data), 1);
        activity.impacts =
            vec![Impact { timeline: "film".into(), effect: Effect::Rate(data * 500) }];
        activity
    });
    let mut activities: Vec<_> = activities.collect();
    if case.manual {
        let mut manual = Activity::new(id(case.slots.len()), Span::new(12));
        manual.kind = Kind::ManualShutdown { shutdown: Span::new(3), wakeup: Span::new(2) };
        manual.starts =
            vec![StartRange { from: Time::new(20), to: Time::new(20), cutoff: Time::new(32) }];
        activities.push(manual);
    }
    Plan { end: Time::new(END), activities, ..Plan::default() }
}

fn state(case: &Case) -> State {
    let running = Running {
        id: id(0),
        started: Time::new(0),
        ends: Time::new(case.slots[0].0 + case.slots[0].1),
        cutoff: Time::new(END),
        paused: case.paused.then_some(Time::new(2)),
        data: Bytes::new(2),
    };
    let window = Window {
        name: "orbiter".into(),
        start: Time::new(case.window.0),
        end: Time::new(case.window.1),
        awake: false,
        marginal: Milliwatts::new(2),
        peak: Milliwatts::new(7),
        data: Bytes::new(-4),
        engines: 2,
        resources: faregate_agents::Categories::NONE,
    };
    State {
        now: Time::new(NOW),
        mode: if case.shutting_down { Mode::ShuttingDown } else { Mode::Asleep },
        mode_since: Time::new(2),
        charge: Microjoules::new(case.charge),
        capacity: Microjoules::new(130),
        running: vec![running],
        windows: vec![window],
        ..State::default()
    }
}

/// Phases lie one after the other, each of wakeup, awake and shutdown.
fn timed(case: &Case) -> TimedPlan {
    let mut awake = Vec::new();
    let mut at = NOW + 3;
    for lengths in case.phases.chunks_exact(3) {
        let ends =
            [at, at + lengths[0], at + lengths[0] + lengths[1], at + lengths.iter().sum::<i64>()];
        let [wakeup, up, down, asleep] = ends.map(Time::new);
        awake.push(AwakePhase { wakeup, up, down, asleep });
        at = ends[3] + 1;
    }
    let rows = case.slots.iter().enumerate().map(|(number, &(start, length, ..))| {
        let (start, end) = (Time::new(start), Time::new(start + length));
        let started = Time::new(0);
        let fate = match number {
            0 => Fate::Running(Slot { start: started, end, range: 0 }),
            _ => Fate::Scheduled(Slot { start, end, range: 0 }),
        };
        Row { id: id(number), fate }
    });
    let mut rows: Vec<_> = rows.collect();
    if case.manual {
        let slot = Slot { start: Time::new(20), end: Time::new(32), range: 0 };
        rows.push(Row { id: id(case.slots.len()), fate: Fate::Scheduled(slot) });
    }
    let preheats = case.heated.map(|(start, end)| Preheat {
        zone: "wheels".into(),
        start: Time::new(start),
        end: Time::new(end),
    });
    TimedPlan { rows, awake, preheats: preheats.into_iter().collect(), ..TimedPlan::default() }
}

/// What is drawn on average and at most over one ms, and how many engines.
fn drawn(case: &Case, at: i64) -> (i128, i64, i64) {
    let mut all: Vec<(i64, i64, u64, u64, i64)> = Vec::new();
    for (number, &(start, length, power, _)) in case.slots.iter().enumerate() {
        let from = if number == 0 { 0 } else { start };
        let average = if number == 0 && case.paused { 0 } else { power };
        all.push((from, start + length, average, 2 * power, 1));
    }
    for phase in timed(case).awake {
        all.push((phase.wakeup.get(), phase.up.get(), 9, 30, 0));
        all.push((phase.up.get(), phase.down.get(), 6, 20, 0));
        all.push((phase.down.get(), phase.asleep.get(), 5, 10, 0));
    }
    all.extend(case.heated.map(|(from, to)| (from, to, 3, 40, 0)));
    all.push((case.window.0, case.window.1, 2, 7, 2));
    if case.shutting_down {
        all.push((NOW, 5, 5, 10, 0));
    }
    if case.manual {
        all.extend([(20, 23, 5, 10, 0), (30, 32, 9, 30, 0)]);
    }
    all.retain(|&(from, to, ..)| from <= at && at < to);
    let average: u64 = all.iter().map(|one| one.2).sum();
    let peak: u64 = all.iter().map(|one| one.3).sum();
    (
        7 - i128::from(average),
        i64::try_from(peak).expect("small"),
        all.iter().map(|one| one.4).sum(),
    )
}

/// The value of a line at an instant.
fn at(line: &Line, at: i64) -> i64 {
    let (before, after): (Vec<_>, Vec<_>) =
        line.points.iter().partition(|(time, _)| time.get() <= at);
    let (from, value) = *before.last().expect("it begins now");
    match after.first() {
        Some((to, next)) if !line.steps => {
            value + (next - value) * (at - from.get()) / (to.get() - from.get())
        }
        _ => value,
    }
}

fn data(case: &Case, at: i64) -> i64 {
    let later = case.slots.iter().skip(1).map(|&(start, length, _, data)| {
        let from = if data < 0 { start + length } else { start };
        if from <= at { data } else { 0 }
    });
    let freed = if case.window.1 <= at { -4 } else { 0 };
    let (start, length, _, runs) = case.slots[0];
    // A running downlink has sent what it was to send when it ends.
    let now = if runs < 0 && start + length <= at { runs } else { runs.max(2) };
    now + later.sum::<i64>() + freed
}

/// In thousandths.
fn film(case: &Case, at: i64) -> i64 {
    let all = case.slots.iter().enumerate().map(|(number, &(start, length, _, data))| {
        let from = if number == 0 { NOW } else { start };
        let rate = if number == 0 && case.paused { 0 } else { data * 500 };
        rate * (at.min(start + length) - from).max(0)
    });
    9_000 + all.sum::<i64>()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(800))]

    #[test]
    fn each_ms_is_as_it_is_stepped(case in case()) {
        let (plan, state, timed) = (plan(&case), state(&case), timed(&case));
        let projection = project(&plan, &parameters(), &state, &timed).expect("it knows its timelines");
        let lines: BTreeMap<_, _> = projection.lines.iter().map(|line| (line.name.as_str(), line)).collect();
        let names: Vec<_> = projection.lines.iter().map(|line| line.name.as_str()).collect();
        prop_assert_eq!(names, ["charge", "peak", "data", "engines", "awake", "film"]);
        for line in lines.values() {
            prop_assert_eq!(line.points[0].0.get(), NOW);
            prop_assert!(line.points.windows(2).all(|pair| pair[0].0 <= pair[1].0), "{:?}", line);
            prop_assert!(line.points.iter().all(|point| point.0.get() <= END), "{:?}", line);
        }
        let mut charge = i128::from(case.charge);
        for now in NOW..END {
            let (net, peak, engines) = drawn(&case, now);
            prop_assert_eq!(at(lines["peak"], now), peak, "peak at {}", now);
            prop_assert_eq!(at(lines["engines"], now), engines, "engines at {}", now);
            prop_assert_eq!(at(lines["data"], now), data(&case, now), "data at {}", now);
            let up = timed.awake.iter().any(|phase| phase.up.get() <= now && now < phase.down.get());
            prop_assert_eq!(at(lines["awake"], now), i64::from(up), "awake at {}", now);
            prop_assert_eq!(i128::from(at(lines["charge"], now)), charge, "charge at {}", now);
            charge = (charge + net).min(130);
        }
        let last = lines["charge"].points.last().expect("it ends");
        prop_assert_eq!((last.0.get(), i128::from(last.1)), (END, charge));
        for (time, value) in &lines["film"].points {
            let expected = film(&case, time.get()).div_euclid(1_000);
            prop_assert_eq!(*value, expected, "film at {}", time);
        }
    }
}
