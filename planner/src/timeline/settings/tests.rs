//! Values that are set, beside a list of the values at each instant.

use proptest::prelude::*;

use super::*;

const END: i64 = 14;

fn setter(order: usize) -> impl Strategy<Value = Setter> {
    let value = || proptest::option::of(0i64..5);
    let keep = proptest::option::of((0i64..3, 1i64..3).prop_map(|(min, n)| (min, min + n)));
    (0i64..5, value(), value(), keep).prop_map(move |(length, start, end, keep)| Setter {
        order,
        length,
        sets: [start, end],
        keep,
    })
}

fn range() -> impl Strategy<Value = Range> {
    (-1..END, 1i64..6, 0i64..4, 0i64..3).prop_map(|(from, n, min, wide)| Range {
        from,
        to: from + n,
        min,
        max: min + wide,
    })
}

/// The value at each instant.
fn values(all: &[(Setter, i64)]) -> Vec<i64> {
    let mut keys: Vec<_> = all.iter().flat_map(|&(one, start)| keys(one, start)).collect();
    keys.sort_unstable();
    let at = |at| keys.iter().rev().find(|(key, _)| key.0 <= at).map_or(1, |(_, value)| *value);
    (0..END).map(at).collect()
}

fn is_valid(old: &[i64], new: &[i64], (one, start): (Setter, i64), ranges: &[Range]) -> bool {
    let far = |value: i64, range: &Range| (range.min - value).max(value - range.max).max(0);
    let instants = (0..END).zip(old.iter().zip(new));
    instants.into_iter().all(|(at, (&old, &new))| {
        let mut now = ranges.iter().filter(|range| range.from <= at && at < range.to);
        let other_side = |range: &Range| (old < range.min) != (new < range.min);
        let worse = |range: &Range| {
            far(new, range) > 0 && (far(new, range) > far(old, range) || other_side(range))
        };
        let own = one.keep.is_none_or(|(min, max)| min <= new && new <= max);
        !now.any(worse) && (own || at < start || start + one.length <= at)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn a_start_is_bad_where_some_value_is(
        before in (setter(1), setter(2), setter(4), setter(5)),
        starts in (0..END, 0..END, 0..END, 0..END),
        one in setter(3),
        ranges in proptest::collection::vec(range(), 0..3),
    ) {
        let placed = [(before.0, starts.0), (before.1, starts.1), (before.2, starts.2), (before.3, starts.3)];
        let mut settings = Settings::new(1, END);
        for (setter, start) in placed {
            settings.insert(setter, start);
        }
        let within = (0, END - one.length);
        let mut bad = Bad::new();
        settings.bad(one, &ranges, within, &mut bad);
        for start in within.0..=within.1 {
            let mut with = placed.to_vec();
            with.push((one, start));
            let expected = is_valid(&values(&placed), &values(&with), (one, start), &ranges);
            let valid = !bad.iter().any(|&(a, b)| a <= start && start <= b);
            prop_assert_eq!(valid, expected, "start {}", start);
            prop_assert_eq!(settings.off(one, start, &ranges).next().is_none(), expected);
        }
        for (setter, start) in placed {
            settings.remove(setter, start);
        }
        prop_assert_eq!(settings, Settings::new(1, END));
    }
}
