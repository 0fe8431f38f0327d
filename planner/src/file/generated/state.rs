//! States drawn at random.

use std::collections::BTreeMap;

use faregate_tickets::amount::Microjoules;
use proptest::collection::{btree_set, vec};
use proptest::option;
use proptest::prelude::*;
use proptest::sample::{select, subsequence};

use super::{bits, data, name, power, span, time, zones_of};
use crate::file::words::{MODES, OUTCOMES};
use crate::parameters::Parameters;
use crate::plan::ActivityId;
use crate::state::{Ended, Running, State, Window};
use crate::units::{Span, Time};

prop_compose! {
    pub(super) fn state(parameters: Parameters)(
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
