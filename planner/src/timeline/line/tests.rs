//! The line beside a list of its values.

use proptest::prelude::*;

use super::*;

const END: i64 = 400;

/// (from, to, value, slope): some reach over both ends of the line.
fn addition() -> impl Strategy<Value = (i64, i64, i128, i128)> {
    (-20..END, 0..END, -9i128..9, -2i128..3).prop_map(|(from, n, v, k)| (from, from + n, v, k))
}

fn values(line: &Line) -> Vec<i128> {
    let pieces = line.pieces(0, END, |_, _| true);
    pieces.flat_map(|piece| (piece.from..piece.to).map(move |at| piece.at(at))).collect()
}

fn within_bounds(line: &Line) -> bool {
    line.chunks.iter().all(|chunk| {
        let (low, high) = chunk.bounds();
        let pieces = chunk.pieces.iter().map(|&piece| chunk.shifted(piece).bounds());
        pieces.clone().all(|(a, b)| low <= a && b <= high)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn it_is_the_sum_of_what_was_added(all in proptest::collection::vec(addition(), 0..300)) {
        let (mut line, mut sum) = (Line::new(0, END, 7), vec![7i128; 400]);
        for &(from, to, value, slope) in &all {
            line.add(from, from, to, Ramp { value, slope });
            for (at, entry) in (0..END).zip(&mut sum) {
                if from <= at && at < to {
                    *entry += value + slope * i128::from(at - from);
                }
            }
        }
        prop_assert_eq!(&values(&line), &sum);
        prop_assert!(within_bounds(&line));
        for &(from, to, value, slope) in all.iter().rev() {
            line.add(from, from, to, Ramp { value: -value, slope: -slope });
        }
        prop_assert_eq!(line.all(), Line::new(0, END, 7).all());
        // Nothing is left behind of what was taken away again.
        prop_assert_eq!(line.chunks.iter().map(|chunk| chunk.pieces.len()).sum::<usize>(), 1);
    }
}

#[test]
fn many_pieces_lie_in_several_chunks() {
    let mut line = Line::new(0, 10_000, 0);
    for at in 0..1_000 {
        line.add(at * 7, at * 7, at * 7 + 3, Ramp { value: 1, slope: 0 });
    }
    assert!(line.chunks.len() > 10, "{}", line.chunks.len());
    assert!(line.chunks.iter().all(|chunk| chunk.pieces.len() <= 2 * CHUNK));
    let passed = line.pieces(0, 10_000, |_, high| high > 1).count();
    assert_eq!(passed, 0, "chunks in which nothing exceeds 1 are passed over");
}
