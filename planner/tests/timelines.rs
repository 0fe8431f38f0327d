//! Timelines beside a world of some sixty ms, in which every value at every
//! instant is worked out from the list of what is placed.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_planner::parameters::{TimelineKind, TimelineSpec};
use faregate_planner::plan::{Constraint, Effect, Impact};
use faregate_planner::state::Window;
use faregate_planner::timeline::{Claim, Timelines};
use faregate_planner::units::{Bytes, Span, Time};
use faregate_planner::{Activity, ActivityId, Parameters, Plan, State};
use faregate_tickets::amount::Milliwatts;
use proptest::prelude::*;
use proptest::sample::select;

const NOW: i64 = 4;
const END: i64 = 60;
const NAMES: [&str; 4] = ["arm", "bus", "heaters", "film"];
const KINDS: [TimelineKind; 4] =
    [TimelineKind::State, TimelineKind::Unit, TimelineKind::Renewable, TimelineKind::Consumable];

fn parameters() -> Parameters {
    let specs = NAMES.iter().zip(KINDS).map(|(name, kind)| {
        let (min, max) = if kind == TimelineKind::Consumable { (-30, 30) } else { (0, 3) };
        TimelineSpec { name: (*name).into(), kind, initial: 1, min, max }
    });
    Parameters {
        mandatory_from: 5,
        peak_limit: Milliwatts::new(10),
        engines: 3,
        timelines: specs.collect(),
        ..Parameters::default()
    }
}

fn plan() -> Plan {
    Plan { end: Time::new(END), max_delta_data: Bytes::new(12), ..Plan::default() }
}

fn state() -> State {
    let timelines = BTreeMap::from([("film".to_owned(), 3)]);
    State { now: Time::new(NOW), timelines, ..State::default() }
}

fn effect(kind: TimelineKind) -> BoxedStrategy<Effect> {
    match kind {
        TimelineKind::State => (0i64..5, any::<bool>())
            .prop_map(|(v, start)| if start { Effect::SetAtStart(v) } else { Effect::SetAtEnd(v) })
            .boxed(),
        TimelineKind::Unit | TimelineKind::Renewable => (-1i64..3).prop_map(Effect::Hold).boxed(),
        TimelineKind::Consumable => prop_oneof![
            (-9i64..9).prop_map(Effect::AddAtStart),
            (-9i64..9).prop_map(Effect::AddAtEnd),
            (-3_000i64..3_000).prop_map(Effect::Rate),
        ]
        .boxed(),
    }
}

fn impact() -> impl Strategy<Value = Impact> {
    (0usize..4).prop_flat_map(|line| {
        effect(KINDS[line]).prop_map(move |effect| Impact { timeline: NAMES[line].into(), effect })
    })
}

fn constraint() -> impl Strategy<Value = Constraint> {
    (select(&NAMES[..]), -9i64..4, 0i64..14).prop_map(|(name, min, n)| Constraint {
        timeline: name.into(),
        min,
        max: min + n,
    })
}

fn activity() -> impl Strategy<Value = Activity> {
    let some = (0i64..9, 0u64..8, 0u32..3, -6i64..7, 0u128..16, 0u32..10);
    let named = proptest::collection::vec(impact(), 0..4);
    let asked = proptest::collection::vec(constraint(), 0..2);
    (some, named, asked).prop_map(
        |((length, peak, engines, data, bits, priority), impacts, constraints)| {
            let mut one = Activity::new(ActivityId::new(1).expect("not 0"), Span::new(length));
            (one.peak, one.engines, one.data) = (Milliwatts::new(peak), engines, Bytes::new(data));
            (one.resources, one.priority) = (Categories::from_mask(bits & (bits >> 1)), priority);
            (one.impacts, one.constraints) = (impacts, constraints);
            one
        },
    )
}

/// Everything that is placed, and when.
type Placed = Vec<(Activity, i64)>;

fn placed() -> impl Strategy<Value = Placed> {
    let all = proptest::collection::vec((activity(), NOW..END - 8), 0..9);
    all.prop_map(|mut all| {
        for (number, (one, _)) in (2..).zip(&mut all) {
            one.id = ActivityId::new(number).expect("not 0");
        }
        all
    })
}

/// The claim of the activity whose place in the plan is its number.
fn claim(one: &Activity) -> Claim {
    let order = usize::try_from(one.id.get()).expect("fits");
    Claim::of(one, order, one.duration, &parameters()).expect("it knows its timelines")
}

fn filled(all: &Placed) -> Timelines {
    let mut timelines = Timelines::new(&plan(), &parameters(), &state());
    for (one, start) in all {
        timelines.insert(&claim(one), Time::new(*start));
    }
    timelines
}

fn runs((one, start): &(Activity, i64), at: i64) -> bool {
    *start <= at && at < *start + one.duration.get()
}

/// All values at an instant, in thousandths, with what they must not exceed.
fn values(all: &Placed, at: i64) -> BTreeMap<String, i128> {
    let mut values = BTreeMap::new();
    let mut add = |name: String, amount: i64| {
        *values.entry(name).or_insert(0) += i128::from(amount) * 1_000;
    };
    for one in all.iter().filter(|one| runs(one, at)) {
        add("peak".into(), i64::try_from(one.0.peak.get()).expect("small"));
        add("engines".into(), one.0.engines.into());
        (0..8)
            .filter(|bit| one.0.resources.mask() >> bit & 1 == 1)
            .for_each(|bit| add(format!("bit {bit}"), 1));
    }
    for (one, start) in all {
        let data = one.data.get();
        let from = if data < 0 { start + one.duration.get() } else { *start };
        add("data".into(), if from <= at { data } else { 0 });
    }
    for (name, kind) in NAMES.iter().zip(KINDS) {
        values.insert((*name).into(), named(all, name, kind, at));
        if kind == TimelineKind::Unit {
            let held = all.iter().filter(|one| runs(one, at));
            let held = held.filter(|(one, _)| one.impacts.iter().any(|i| i.timeline == *name));
            values.insert("holders".into(), i128::try_from(held.count() * 1_000).expect("small"));
        }
    }
    values
}

fn named(all: &Placed, name: &str, kind: TimelineKind, at: i64) -> i128 {
    let initial = if name == "film" { 3_000 } else { 1_000 };
    let impacts = all.iter().flat_map(|placed| {
        let impacts = placed.0.impacts.iter().filter(|impact| impact.timeline == name);
        impacts.map(move |impact| (placed, impact.effect))
    });
    if kind == TimelineKind::State {
        let sets = impacts.filter_map(|((one, start), effect)| match effect {
            Effect::SetAtStart(value) => Some((*start, 1, one.id, value)),
            Effect::SetAtEnd(value) => Some((*start + one.duration.get(), 0, one.id, value)),
            _ => None,
        });
        let sets: Vec<_> = sets.filter(|set| set.0 <= at).collect();
        let last = sets.iter().map(|set| (set.0, set.1, set.2)).max();
        let last = sets.iter().rev().find(|set| Some((set.0, set.1, set.2)) == last);
        return last.map_or(initial, |set| i128::from(set.3) * 1_000);
    }
    let amounts = impacts.map(|(placed, effect)| {
        let (from, to) = (placed.1, placed.1 + placed.0.duration.get());
        i128::from(match effect {
            Effect::Hold(x) if runs(placed, at) => x * 1_000,
            Effect::AddAtStart(x) if from <= at => x * 1_000,
            Effect::AddAtEnd(x) if to <= at => x * 1_000,
            Effect::Rate(x) if from <= at => x * (at.min(to) - from),
            _ => 0,
        })
    });
    initial + amounts.sum::<i128>()
}

/// By name: the smallest and the largest value that something may have.
fn limits(optional_data: bool) -> BTreeMap<String, (i128, i128)> {
    let mut limits = BTreeMap::new();
    let most = |max| (i128::MIN, max);
    limits.insert("peak".to_owned(), most(10_000));
    limits.insert("engines".to_owned(), most(3_000));
    limits.insert("holders".to_owned(), most(1_000));
    limits.extend((0..8).map(|bit| (format!("bit {bit}"), most(1_000))));
    for spec in parameters().timelines {
        limits.insert(spec.name, (i128::from(spec.min) * 1_000, i128::from(spec.max) * 1_000));
    }
    if optional_data {
        limits.insert("data".to_owned(), most(12_000));
    }
    limits
}

fn past(value: i128, (min, max): (i128, i128)) -> i128 {
    if value < min { value - min } else { (value - max).max(0) }
}

/// Whether the candidate can start then, instant by instant.
fn is_valid(all: &Placed, candidate: &Activity, start: i64) -> bool {
    let mut with = all.clone();
    with.push((candidate.clone(), start));
    let limits = limits(candidate.priority < 5 && candidate.data.get() > 0);
    (NOW..=END).all(|at| {
        let (old, new) = (values(all, at), values(&with, at));
        let get =
            |values: &BTreeMap<String, i128>, name: &String| values.get(name).copied().unwrap_or(0);
        let worse = |name: &String, range| {
            let (old, new) = (past(get(&old, name), range), past(get(&new, name), range));
            new != 0 && (new.abs() > old.abs() || new.signum() != old.signum())
        };
        let asked = |one: &Activity| -> Vec<(String, (i128, i128))> {
            let asked = one.constraints.iter();
            asked
                .map(|c| {
                    (c.timeline.clone(), (i128::from(c.min) * 1_000, i128::from(c.max) * 1_000))
                })
                .collect()
        };
        let others = all.iter().filter(|one| runs(one, at));
        let fits = others.flat_map(|one| asked(&one.0)).all(|(name, range)| !worse(&name, range));
        let own = !runs(&(candidate.clone(), start), at)
            || asked(candidate).iter().all(|(name, range)| past(get(&new, name), *range) == 0);
        fits && own && limits.iter().all(|(name, range)| !worse(name, *range))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn a_start_is_valid_where_no_instant_is_wrong(all in placed(), candidate in activity()) {
        let timelines = filled(&all);
        let claim = claim(&candidate);
        let last = END - candidate.duration.get();
        let valid = timelines.valid_starts(&claim, (Time::new(NOW), Time::new(last)));
        for start in NOW..=last {
            let expected = is_valid(&all, &candidate, start);
            prop_assert_eq!(valid.contains(Time::new(start)), expected, "start {}", start);
            let conflict = timelines.conflict(&claim, Time::new(start));
            prop_assert_eq!(conflict.is_none(), expected, "start {}: {:?}", start, conflict);
            if let Some(conflict) = conflict {
                prop_assert!(conflict.amount > 0, "{:?}", conflict);
                prop_assert!(conflict.at.get() >= start && conflict.at.get() <= END, "{:?}", conflict);
                prop_assert!(conflict.at <= conflict.worst && conflict.worst.get() <= END);
            }
        }
    }

    #[test]
    fn a_part_of_the_starts_is_a_part_of_the_answer(all in placed(), candidate in activity(),
        from in NOW..END, n in 0i64..20) {
        let timelines = filled(&all);
        let claim = claim(&candidate);
        let whole = timelines.valid_starts(&claim, (Time::new(NOW), Time::new(END)));
        let within = (Time::new(from), Time::new((from + n).min(END)));
        let part = timelines.valid_starts(&claim, within);
        for start in (NOW..=END).map(Time::new) {
            let expected = within.0 <= start && start <= within.1 && whole.contains(start);
            prop_assert_eq!(part.contains(start), expected, "start {}", start);
        }
    }

    #[test]
    fn incremental_is_full(all in placed(), gone in proptest::collection::vec(any::<bool>(), 9)) {
        let mut timelines = filled(&all);
        let mut left = all.clone();
        for ((one, start), gone) in all.iter().zip(gone) {
            if gone {
                timelines.remove(&claim(one), Time::new(*start));
                left.retain(|(other, _)| other.id != one.id);
            }
        }
        prop_assert_eq!(&timelines, &filled(&left));
        prop_assert_eq!(&timelines.full(&plan(), &parameters(), &state()), &timelines);
    }
}

#[test]
fn half_open_spans_may_touch_and_a_limit_may_be_met() {
    let mut timelines = Timelines::new(&plan(), &parameters(), &state());
    let mut one = Activity::new(ActivityId::new(2).expect("not 0"), Span::new(10));
    (one.resources, one.engines) = (Categories::from_mask(1 << 100), 3);
    timelines.insert(&claim(&one), Time::new(20));
    one.id = ActivityId::new(3).expect("not 0");
    let starts = timelines.valid_starts(&claim(&one), (Time::new(NOW), Time::new(50)));
    let starts: Vec<_> = starts.iter().map(|(a, b)| (a.get(), b.get())).collect();
    assert_eq!(starts, [(NOW, 10), (30, 50)]);
    let conflict = timelines.conflict(&claim(&one), Time::new(25)).expect("both are in the way");
    assert_eq!((conflict.amount, conflict.with), (3, ActivityId::new(2)), "engines come first");
}

#[test]
fn a_window_in_progress_counts_what_is_left_of_it() {
    let mut timelines = Timelines::new(&plan(), &parameters(), &state());
    let window = Window {
        name: "orbiter".into(),
        start: Time::new(0),
        end: Time::new(9),
        awake: false,
        marginal: Milliwatts::ZERO,
        peak: Milliwatts::new(8),
        data: Bytes::new(-5),
        engines: 1,
        resources: Categories::from_mask(1),
    };
    let empty = timelines.clone();
    timelines.insert(&Claim::window(&window, 1_000), window.start);
    let peaks: Vec<_> = timelines.peaks(Time::ZERO, Time::new(END)).collect();
    assert_eq!(peaks, [(Time::new(NOW), 8), (Time::new(9), 0)]);
    let volumes: Vec<_> = timelines.volumes(Time::new(NOW)).collect();
    assert_eq!(volumes, [(Time::new(NOW), 0), (Time::new(9), -5)]);
    timelines.remove(&Claim::window(&window, 1_000), window.start);
    assert_eq!(timelines, empty);
    let over = Window { end: Time::new(NOW), ..window };
    timelines.insert(&Claim::window(&over, 1_000), over.start);
    assert_eq!(timelines, empty, "one that is over counts nothing");
}
