//! Parameters drawn at random.

use proptest::collection::{btree_set, vec};
use proptest::prelude::*;
use proptest::sample::select;

use super::{bit, fraction, limits, load, names, phase, power, span, time};
use crate::file::words::TIMELINES;
use crate::parameters::{Day, Parameters, PreheatRow, TimelineSpec, Zone};
use crate::units::Span;

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
    pub(super) fn parameters()(
        (zones, timelines, resources) in (names(), names(), names()),
        length in prop_oneof![Just(Day::SOL.length), (3_600_000_i64..90_000_000).prop_map(Span::new)],
    )(
        zones in zones.into_iter().map(|name| zone(name, length)).collect::<Vec<_>>(),
        timelines in timelines.into_iter().map(timeline).collect::<Vec<_>>(),
        bits in btree_set(bit(), resources.len()).prop_map(Vec::from_iter).prop_shuffle(),
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
