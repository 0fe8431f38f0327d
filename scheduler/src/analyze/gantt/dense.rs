//! Spans that are too many to be told apart: how much of each stretch they
//! cover.

use crate::analyze::gantt::rows::Span;
use crate::analyze::gantt::scale::Scale;

/// A stretch of the scale, and which part of it is covered, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub(super) from: f64,
    pub(super) until: f64,
    pub(super) covered: f64,
}

/// Pixels of a stretch.
const WIDE: f64 = 3.0;
/// How many shades are told apart.
const SHADES: f64 = 8.0;

/// Whether so many spans cannot be told apart, or would make a huge file.
pub(super) fn is_crowded(spans: usize, scale: &Scale) -> bool {
    f64::from(u32::try_from(spans).unwrap_or(u32::MAX)) * 4.0 > scale.right - scale.left
}

/// Where something is covered, and how much; neighbours of one shade together.
pub(super) fn stretches(spans: impl Iterator<Item = Span>, scale: &Scale) -> Vec<Stretch> {
    let mut covered = vec![0.0_f64; count(scale)];
    for (from, until) in spans {
        cover(&mut covered, scale.place(from) - scale.left, scale.place(until) - scale.left);
    }
    let mut joined: Vec<Stretch> = Vec::new();
    let mut from = scale.left;
    for covered in covered {
        let until = (from + WIDE).min(scale.right);
        let shade = ((covered / WIDE).min(1.0) * SHADES).ceil() / SHADES;
        match joined.last_mut() {
            Some(last) if last.covered == shade => last.until = until,
            _ => joined.push(Stretch { from, until, covered: shade }),
        }
        from = until;
    }
    joined.retain(|stretch| stretch.covered > 0.0);
    joined
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a few thousand pixels"
)]
fn count(scale: &Scale) -> usize {
    ((scale.right - scale.left) / WIDE).ceil().max(1.0) as usize
}

/// Adds the pixels between two places. What is thinner than can be seen counts
/// as much as can be seen.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the scale")]
fn cover(covered: &mut [f64], from: f64, until: f64) {
    let until = until.max(from + 0.05);
    let mut at = from;
    let mut index = (from / WIDE).floor().max(0.0) as usize;
    while at < until {
        let Some(part) = covered.get_mut(index) else { return };
        index = index.saturating_add(1);
        let end = until.min(f64::from(u32::try_from(index).unwrap_or(u32::MAX)) * WIDE);
        *part += end - at;
        at = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Duration;

    #[test]
    fn a_routine_task_that_runs_a_third_of_the_time_is_one_stretch_of_a_third() {
        let scale = Scale::new(Duration::from_secs(86_400), 100.0, 1_000.0);
        let runs = (0..1_440).map(|minute| {
            let from = Duration::from_secs(minute * 60);
            (from, from.saturating_add(Duration::from_secs(20)))
        });
        let stretches = stretches(runs, &scale);
        assert!(stretches.len() < 100, "{}", stretches.len());
        for stretch in stretches {
            assert!((0.2..0.6).contains(&stretch.covered), "{stretch:?}");
        }
    }

    #[test]
    fn a_gap_is_not_covered_and_a_whole_stretch_is() {
        let scale = Scale::new(Duration::from_secs(90), 0.0, 900.0);
        let at = Duration::from_secs;
        let found = stretches([(at(0), at(30)), (at(60), at(90))].into_iter(), &scale);
        let found: Vec<_> = found.iter().map(|s| (s.from, s.until, s.covered)).collect();
        assert_eq!(found, [(0.0, 300.0, 1.0), (600.0, 900.0, 1.0)]);
    }
}
