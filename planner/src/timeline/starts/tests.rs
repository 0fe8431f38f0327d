//! Starts that are solved for, beside starts that are tried.

use proptest::prelude::*;

use super::super::line::Ramp;
use super::*;

const END: i64 = 30;

fn ramp() -> impl Strategy<Value = (i64, i64, Ramp)> {
    (0..END, 1..END, -6i128..7, -3i128..4)
        .prop_map(|(from, n, value, slope)| (from, from + n, Ramp { value, slope }))
}

fn part() -> impl Strategy<Value = Part> {
    (0i64..4, 1i64..9, -9i128..10, -4i128..5, any::<bool>()).prop_map(
        |(from, n, value, slope, stays)| match stays {
            true => Part { from, to: FOREVER, value, slope: 0 },
            false => Part { from, to: from + n, value, slope },
        },
    )
}

fn range() -> impl Strategy<Value = Keep> {
    (-2..END, 1..END, -12i128..6, 0i128..14, any::<bool>()).prop_map(
        |(from, n, min, wide, open)| {
            let min_or_none = if open { i128::MIN } else { min };
            Keep { from, to: from + n, min: min_or_none, max: min + wide }
        },
    )
}

fn adds(part: Part, age: i64) -> Option<i128> {
    let inside = part.from <= age && (age < part.to || part.to == FOREVER);
    inside.then(|| part.value + part.slope * i128::from(age - part.from))
}

/// How far off the range the value is with the part, where that is to be told.
fn off(value: i128, part: Part, keep: Keep, (at, start): (i64, i64), worse: bool) -> Option<i128> {
    let added = adds(part, at - start)?;
    let sum = value + added;
    let inside = keep.from <= at && at < keep.to;
    match () {
        () if inside && sum > keep.max && (added > 0 || !worse) => Some(sum - keep.max),
        () if inside && sum < keep.min && (added < 0 || !worse) => Some(keep.min - sum),
        () => None,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn what_is_solved_for_is_what_is_found_by_trying(
        ramps in proptest::collection::vec(ramp(), 0..4),
        part in part(),
        keep in range(),
        within in (-3..END, 0..END),
        only_worse in any::<bool>(),
    ) {
        let mut line = Line::new(0, END, 0);
        for (from, to, ramp) in ramps {
            line.add(from, from, to, ramp);
        }
        let values: Vec<_> = line.all().into_iter()
            .flat_map(|piece| (piece.from..piece.to).map(move |at| piece.at(at))).collect();
        let within = (within.0, within.0 + within.1);
        let mut bad = Bad::new();
        let fill = if only_worse { worse } else { outside };
        fill(&line, &[part], keep, within, &mut bad);
        prop_assert!(bad.iter().all(|(a, b)| within.0 <= *a && a <= b && *b <= within.1));
        for start in within.0..=within.1 {
            let tried: Vec<(i64, i128)> = (0..END).zip(&values).filter_map(|(at, &value)| {
                Some((at, off(value, part, keep, (at, start), only_worse)?))
            }).collect();
            let solved = bad.iter().any(|&(a, b)| a <= start && start <= b);
            prop_assert_eq!(solved, !tried.is_empty(), "start {}: {:?}", start, &tried);
            let most = tried.iter().map(|(at, by)| (*by, core::cmp::Reverse(*at))).max();
            let expected = tried.first().zip(most).map(|((first, _), (by, worst))| {
                Breach { first: *first, worst: worst.0, by }
            });
            prop_assert_eq!(broken(&line, &[part], keep, start, only_worse), expected);
        }
    }
}
