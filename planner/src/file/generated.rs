//! Documents drawn at random, each one that can be loaded.

use std::collections::{BTreeMap, BTreeSet};

use faregate_agents::Categories;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use proptest::collection::{btree_set, vec};
use proptest::option;
use proptest::prelude::*;
use proptest::sample::{select, subsequence};

use crate::file::words::{MODES, OUTCOMES, STATUSES, TIMELINES, VARIABLES};
use crate::parameters::*;
use crate::plan::*;
use crate::state::*;
use crate::units::{Bytes, Ppm, Span, Time};

/// What all three of a set are.
pub(super) type Three = (Parameters, Plan, State);

pub(super) fn three() -> impl Strategy<Value = Three> {
    parameters().prop_flat_map(|parameters| {
        let (plan, state) = (plan(&parameters), state(parameters.clone()));
        (Just(parameters), plan, state)
    })
}

/// With everything that has to be escaped, and spaces where they hurt.
fn name() -> impl Strategy<Value = String> + Clone {
    "[a-z<>&\"'é;#\u{a0}🚀 ]{1,9}"
        .prop_filter("a name shows something", |name| !name.trim().is_empty())
}

fn names() -> impl Strategy<Value = Vec<String>> {
    btree_set(name(), 1..5).prop_map(|names| names.into_iter().collect())
}

fn time() -> impl Strategy<Value = Time> + Clone {
    prop_oneof![-9_i64..9, -200_000_000_i64..900_000_000, Just(60_000)].prop_map(Time::new)
}

fn span(from: i64) -> impl Strategy<Value = Span> + Clone {
    prop_oneof![from..9_999_999, (from..500).prop_map(move |min| (min * 60_000).max(from))]
        .prop_map(Span::new)
}

fn power() -> impl Strategy<Value = Milliwatts> + Clone {
    prop_oneof![Just(0), 0_u64..2_000_000, (0_u64..300).prop_map(|w| w * 1_000)]
        .prop_map(Milliwatts::new)
}

fn data() -> impl Strategy<Value = Bytes> + Clone {
    prop_oneof![Just(0), -99_999_999_i64..99_999_999, (-50_i64..50).prop_map(|mb| mb * 1_000_000)]
        .prop_map(Bytes::new)
}

fn fraction() -> impl Strategy<Value = Ppm> {
    prop_oneof![0_i64..=1_000_000, (0_i64..=100).prop_map(|of| of * 10_000)].prop_map(Ppm::new)
}

fn load() -> impl Strategy<Value = Load> {
    (power(), power()).prop_map(|(marginal, peak)| Load { marginal, peak })
}

fn phase() -> impl Strategy<Value = Phase> {
    (span(0), load()).prop_map(|(duration, load)| Phase { duration, load })
}

/// A smallest and a largest value; often none.
fn limits() -> impl Strategy<Value = (i64, i64)> + Clone {
    let end = prop_oneof![Just(i64::MIN), Just(i64::MAX), -99_i64..99, any::<i64>()];
    (end.clone(), end).prop_map(|(one, other)| (one.min(other), one.max(other)))
}

fn bits() -> impl Strategy<Value = Categories> {
    prop_oneof![
        Just(Categories::NONE),
        btree_set(0_u8..128, 0..5).prop_map(|bits| {
            Categories::from_mask(bits.into_iter().fold(0, |mask, bit| mask | 1 << bit))
        }),
    ]
}

fn zone(name: String, day: Span) -> impl Strategy<Value = Zone> {
    (load(), btree_set(1..day.get(), 0..4), vec(span(0), 4)).prop_map(
        move |(load, froms, spans)| {
            let froms = [0].into_iter().chain(froms);
            let row = |(from, duration)| PreheatRow { from: Span::new(from), duration };
            Zone { name: name.clone(), load, table: froms.zip(spans).map(row).collect() }
        },
    )
}

fn timeline(name: String) -> impl Strategy<Value = TimelineSpec> {
    let kind = select(TIMELINES.map(|(_, kind)| kind).to_vec());
    (kind, limits(), any::<i64>()).prop_map(move |(kind, (min, max), initial)| TimelineSpec {
        name: name.clone(),
        kind,
        initial: initial.clamp(min, max),
        min,
        max,
    })
}

prop_compose! {
    fn parameters()(
        (zones, timelines, resources) in (names(), names(), names()),
        length in prop_oneof![Just(Day::SOL.length), (3_600_000_i64..90_000_000).prop_map(Span::new)],
    )(
        zones in zones.into_iter().map(|name| zone(name, length)).collect::<Vec<_>>(),
        timelines in timelines.into_iter().map(timeline).collect::<Vec<_>>(),
        bits in subsequence((0..128_u8).collect::<Vec<_>>(), resources.len()).prop_shuffle(),
        resources in Just(resources),
        mut soc in [fraction(), fraction(), fraction()],
        powers in [power(), power(), power()],
        spans in [span(0), span(0), span(0), span(0), span(0)],
        (awake, wakeup, shutdown) in (load(), phase(), phase()),
        midnight in time(),
        length in Just(length),
        (mandatory_from, engines, soft_samples) in (any::<u32>(), any::<u32>(), 1_u32..99),
    ) -> Parameters {
        soc.sort_unstable();
        let [hard_min_soc, soft_min_soc, max_soc] = soc;
        let [peak_limit, rtg, base] = powers;
        let [min_awake, min_sleep, commit, expansion_grace, handover_tolerance] = spans;
        Parameters {
            mandatory_from, soft_min_soc, hard_min_soc, max_soc, peak_limit, engines, rtg, base,
            awake, wakeup, shutdown, min_awake, min_sleep, day: Day { length, midnight }, zones,
            timelines, resources: resources.into_iter().zip(bits).collect(), commit,
            expansion_grace, handover_tolerance, soft_samples,
        }
    }
}

fn plan(parameters: &Parameters) -> impl Strategy<Value = Plan> + use<> {
    let ids = btree_set(1..=u32::MAX, 0..6).prop_map(|ids| ids.into_iter().collect::<Vec<_>>());
    let parameters = parameters.clone();
    let activities = ids.prop_shuffle().prop_flat_map(move |ids| {
        let ids: Vec<_> = ids.into_iter().filter_map(ActivityId::new).collect();
        let one = |at| activity(ids[at], ids[..at].to_vec(), at, parameters.clone()).boxed();
        (0..ids.len()).map(one).collect::<Vec<_>>()
    });
    let ends = (time(), time()).prop_map(|(one, other)| (one.min(other), one.max(other)));
    let head = (name(), ends, fraction(), data(), option::of(name()));
    (head, activities).prop_map(|((name, (handover, end), soc, data, next_plan), activities)| {
        Plan {
            name,
            handover,
            handover_min_soc: soc,
            end,
            max_delta_data: data,
            next_plan,
            activities,
        }
    })
}

/// The kinds of activities, of this duration, where there are such priors.
fn kind(duration: i64, priors: usize) -> BoxedStrategy<Kind> {
    let manual = (0..=duration).prop_flat_map(move |shutdown| {
        let wakeup = (0..=duration - shutdown).prop_map(Span::new);
        wakeup
            .prop_map(move |wakeup| Kind::ManualShutdown { shutdown: Span::new(shutdown), wakeup })
    });
    let expanding = (1..=duration).prop_map(|ms| Kind::Expanding { minimum: Span::new(ms) });
    let others = prop_oneof![Just(Kind::Generic), Just(Kind::StayAwake), expanding, manual];
    if priors == 0 {
        others.boxed()
    } else {
        prop_oneof![4 => others, 1 => Just(Kind::Cleanup)].boxed()
    }
}

prop_compose! {
    fn activity(id: ActivityId, priors: Vec<ActivityId>, at: usize, parameters: Parameters)(
        duration in span(1),
        names in (option::of(name()), option::of(name()), option::of(select(vec!["a group", "<b>"]))),
        numbers in (any::<u32>(), option::of(any::<u64>()), prop_oneof![Just(0), any::<u32>()]),
    )(
        kind in kind(duration.get(), priors.len()),
        starts in vec((time(), span(0), span(0)), 1..4),
        after in after(priors.clone()),
        powers in (power(), power(), option::of(-100_i64..=100)),
        (data, resources, pausable) in (data(), bits(), any::<bool>()),
        zones in subsequence(zones_of(&parameters), 0..=parameters.zones.len()).prop_shuffle(),
        conditions in vec(condition(), 0..3),
        impacts in vec(impact(&parameters), 0..3),
        constraints in vec(constraint(&parameters), 0..3),
        duration in Just(duration),
        names in Just(names),
        numbers in Just(numbers),
        priors in Just(priors.clone()),
    ) -> Activity {
        let manual = matches!(kind, Kind::ManualShutdown { .. });
        let mut activity = Activity { kind, ..Activity::new(id, duration) };
        let placed = activity.placed();
        activity.starts = starts.into_iter().map(|(from, wide, late)| {
            // One after the other: manual shutdowns never overlap.
            let from = if manual { Time::new(40_000_000 * i64::try_from(at).unwrap()) } else { from };
            StartRange { from, to: from.after(wide), cutoff: from.after(placed).after(late) }
        }).collect();
        activity.after = after;
        if kind == Kind::Cleanup {
            let statuses = vec![Status::Aborted, Status::Failed];
            activity.after.push(Dependency { prior: priors[0], statuses });
        }
        let (marginal, peak, beside) = powers;
        let product = i64::try_from(marginal.get()).unwrap() * duration.get();
        // At most one part of a hundred beside it.
        activity.energy = beside.map(|part| Microjoules::new((product + product / 10_000 * part).unsigned_abs()));
        (activity.name, activity.sequence) = (names.0, names.1);
        activity.group = names.2.map(str::to_owned);
        (activity.priority, activity.value, activity.engines) = numbers;
        Activity { marginal, peak, data, resources, zones, conditions, impacts, constraints, pausable, ..activity }
    }
}

fn zones_of(parameters: &Parameters) -> Vec<String> {
    parameters.zones.iter().map(|zone| zone.name.clone()).collect()
}

fn after(priors: Vec<ActivityId>) -> BoxedStrategy<Vec<Dependency>> {
    if priors.is_empty() {
        return Just(Vec::new()).boxed();
    }
    let statuses = subsequence(STATUSES.map(|(_, status)| status).to_vec(), 1..=5).prop_shuffle();
    let one =
        (select(priors), statuses).prop_map(|(prior, statuses)| Dependency { prior, statuses });
    vec(one, 0..3).boxed()
}

fn condition() -> impl Strategy<Value = Condition> {
    let kind = select(VARIABLES.map(|(_, kind)| kind).to_vec());
    (kind, name(), limits()).prop_map(|(kind, name, (min, max))| Condition { kind, name, min, max })
}

fn impact(parameters: &Parameters) -> impl Strategy<Value = Impact> + use<> {
    let effects = |kind: TimelineKind| -> Vec<fn(i64) -> Effect> {
        match kind {
            TimelineKind::State => vec![Effect::SetAtStart, Effect::SetAtEnd],
            TimelineKind::Unit | TimelineKind::Renewable => {
                vec![|amount| Effect::Hold(amount.saturating_abs().max(1))]
            }
            TimelineKind::Consumable => vec![Effect::AddAtStart, Effect::AddAtEnd, Effect::Rate],
        }
    };
    let all = parameters.timelines.iter();
    let all: Vec<_> = all
        .flat_map(|one| effects(one.kind).into_iter().map(|effect| (one.name.clone(), effect)))
        .collect();
    let amount = prop_oneof![-99_i64..99, any::<i64>()];
    (select(all), amount)
        .prop_map(|((timeline, effect), amount)| Impact { timeline, effect: effect(amount) })
}

fn constraint(parameters: &Parameters) -> impl Strategy<Value = Constraint> + use<> {
    let names: Vec<_> = parameters.timelines.iter().map(|one| one.name.clone()).collect();
    (select(names), limits()).prop_map(|(timeline, (min, max))| Constraint { timeline, min, max })
}

prop_compose! {
    fn state(parameters: Parameters)(
        now in time(),
        ids in btree_set(1..=u32::MAX, 0..6),
    )(
        mode in select(MODES.map(|(_, mode)| mode).to_vec()),
        (mode_since, since) in (span(0), span(0)),
        (charge, capacity) in (0_u64..9_000_000_000_000, 1_u64..9_000_000_000_000),
        warm in subsequence(zones_of(&parameters), 0..=parameters.zones.len()),
        cold in subsequence(zones_of(&parameters), 0..=parameters.zones.len()).prop_shuffle(),
        variables in proptest::collection::btree_map(name(), any::<i64>(), 0..3),
        timelines in subsequence(parameters.timelines.clone(), 0..=parameters.timelines.len()),
        ended in vec(ended(now), ids.len() / 2),
        running in vec(running(now), ids.len() - ids.len() / 2),
        windows in vec(window(), 0..3),
        (now, ids) in (Just(now), Just(ids)),
    ) -> State {
        let ids: Vec<_> = ids.into_iter().filter_map(ActivityId::new).collect();
        let (first, last) = ids.split_at(ids.len() / 2);
        State {
            now,
            mode,
            mode_since: now.before(mode_since),
            charge: Microjoules::new(charge.min(capacity)),
            capacity: Microjoules::new(capacity),
            heating: warm.into_iter().map(|zone| (zone, now.before(since))).collect(),
            cold,
            variables,
            timelines: timelines.into_iter().map(|one| (one.name, one.initial)).collect::<BTreeMap<_, _>>(),
            ended: first.iter().zip(ended).map(|(id, one)| Ended { id: *id, ..one }).collect(),
            running: last.iter().zip(running).map(|(id, one)| Running { id: *id, ..one }).collect(),
            windows,
        }
    }
}

fn ended(now: Time) -> impl Strategy<Value = Ended> {
    let outcome = select(OUTCOMES.map(|(_, outcome)| outcome).to_vec());
    (outcome, span(0), option::of(span(0)), data()).prop_map(move |(outcome, ago, took, data)| {
        let ended = now.before(ago);
        Ended {
            id: ActivityId::FIRST,
            outcome,
            started: took.map(|took| ended.before(took)),
            ended,
            data,
        }
    })
}

fn running(now: Time) -> impl Strategy<Value = Running> {
    (span(0), span(0), time(), any::<bool>(), data()).prop_map(
        move |(ago, takes, cutoff, paused, data)| {
            let started = now.before(ago);
            let paused = paused.then_some(now.before(Span::new(ago.get() / 2)));
            Running {
                id: ActivityId::FIRST,
                started,
                ends: started.after(takes),
                cutoff,
                paused,
                data,
            }
        },
    )
}

fn window() -> impl Strategy<Value = Window> {
    let first = (name(), time(), span(0), any::<bool>());
    let second = (power(), power(), data(), prop_oneof![Just(0), any::<u32>()], bits());
    (first, second).prop_map(
        |((name, start, length, awake), (marginal, peak, data, engines, resources))| Window {
            name,
            start,
            end: start.after(length),
            awake,
            marginal,
            peak,
            data,
            engines,
            resources,
        },
    )
}

/// Each attribute that occurs in a text, with its element, and each word that
/// stands for a value of a list.
pub(super) fn occur(element: &super::xml::Element<'_>, root: &str, seen: &mut BTreeSet<String>) {
    for one in &element.attributes {
        seen.insert(format!("{root} {} {}", element.name, one.name));
        if ["type", "kind", "status", "mode", "outcome"].contains(&&*one.name) {
            seen.extend(one.value.split(' ').map(str::to_owned));
        }
    }
    element.children.iter().for_each(|child| occur(child, root, seen));
}
