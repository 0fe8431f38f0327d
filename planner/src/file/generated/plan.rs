//! Plans drawn at random.

use faregate_tickets::amount::Microjoules;
use proptest::collection::{btree_set, vec};
use proptest::option;
use proptest::prelude::*;
use proptest::sample::{select, subsequence};

use super::{bits, data, fraction, limits, name, power, span, time, zones_of};
use crate::file::words::{STATUSES, VARIABLES};
use crate::parameters::{Parameters, TimelineKind};
use crate::plan::{
    Activity, ActivityId, Condition, Constraint, Dependency, Effect, Impact, Kind, Plan,
    StartRange, Status,
};
use crate::units::{Span, Time};

pub(super) fn plan(parameters: &Parameters) -> impl Strategy<Value = Plan> + use<> {
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
