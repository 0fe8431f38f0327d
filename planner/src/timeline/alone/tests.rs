//! What is broken by itself, beside what every instant says.

use proptest::prelude::*;

use super::super::line::Ramp;
use super::super::settings::{Setter, Settings};
use super::*;
use crate::parameters::TimelineKind;

const END: i64 = 20;

fn range() -> impl Strategy<Value = Range> {
    (-1..END, 1..END, -3_i64..2, 0_i64..5).prop_map(|(from, n, min, wide)| Range {
        from,
        to: from + n,
        min,
        max: min + wide,
    })
}

/// The first instant at which one of the ranges is left, and how far at most.
fn tried(values: &[i128], ranges: &[Range]) -> Option<Off> {
    values.iter().zip(0..).find_map(|(&value, at)| {
        let here = ranges.iter().filter(|range| range.from <= at && at < range.to);
        let off = here.map(|range| {
            let range = keep(*range);
            (range.min - value).max(value - range.max)
        });
        off.filter(|by| *by > 0).max().map(|by| (at, by))
    })
}

fn first(off: Vec<Off>) -> Option<Off> {
    off.into_iter().min_by_key(|&(at, by)| (at, core::cmp::Reverse(by)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn a_sum_is_off_when_its_value_first_is(
        ramps in proptest::collection::vec((0..END, 1..END, -3_000_i128..4_000, -900_i128..900), 0..4),
        ranges in proptest::collection::vec(range(), 0..3),
    ) {
        let mut line = Line::new(0, END, 0);
        for (from, n, value, slope) in ramps {
            line.add(from, from, from + n, Ramp { value, slope });
        }
        let pieces = line.all();
        let at = |at: i64| pieces.iter().find(|it| it.from <= at && at < it.to).unwrap().at(at);
        let values: Vec<i128> = (0..END).map(at).collect();
        prop_assert_eq!(first(sum_off(&line, &ranges, 0)), tried(&values, &ranges));
    }

    #[test]
    fn a_state_is_off_when_its_value_first_is(
        sets in proptest::collection::vec((0..END, -4_i64..6), 0..4),
        ranges in proptest::collection::vec(range(), 0..3),
    ) {
        let mut settings = Settings::new(0, END);
        for (order, (start, value)) in sets.iter().enumerate() {
            let sets = [Some(*value), None];
            settings.insert(Setter { order, length: 1, sets, keep: None }, *start);
        }
        let value = |at: i64| {
            let set = sets.iter().enumerate().filter(|(_, (start, _))| *start <= at);
            set.max_by_key(|(order, (start, _))| (*start, *order)).map_or(0, |(_, (_, value))| *value)
        };
        let values: Vec<i128> = (0..END).map(|at| i128::from(value(at)) * FINE).collect();
        let points: Vec<_> =
            settings.points(0).into_iter().map(|(at, value)| (at.get(), value)).collect();
        prop_assert_eq!(first(set_off(&points, &ranges, END)), tried(&values, &ranges));
    }
}

#[test]
fn a_unit_with_two_users_is_one_too_many() {
    let mut holders = Line::new(0, END, 0);
    for (from, to) in [(2, 9), (5, 7)] {
        holders.add(from, from, to, Ramp { value: 1, slope: 0 });
    }
    let spec = crate::parameters::TimelineSpec {
        name: "bus".into(),
        kind: TimelineKind::Unit,
        initial: 0,
        min: 0,
        max: 1,
    };
    let (plan, state) = (crate::Plan::default(), crate::State::default());
    let mut named = Named::new(&spec, &plan, &state, (0, END));
    assert_eq!(named.out_of_range(0, END), None);
    named.holders = Some(holders);
    assert_eq!(named.out_of_range(0, END), Some((5, FINE)));
}
