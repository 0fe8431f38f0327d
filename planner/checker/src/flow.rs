//! The battery: what flows into it, and what it holds, in whole microjoules at
//! whole milliseconds.

use crate::steps::Steps;

/// What flows into the battery beside what the computer draws.
#[derive(Clone, Debug)]
pub(crate) struct Flow {
    net: Steps,
    capacity: i128,
}

impl Flow {
    pub(crate) const fn new(net: Steps, capacity: i128) -> Self {
        Self { net, capacity }
    }

    pub(crate) const fn capacity(&self) -> i128 {
        self.capacity
    }

    pub(crate) fn instants(&self) -> impl Iterator<Item = i64> {
        self.net.instants()
    }

    /// The charge at `to`, if it is `charge` at `from` and the computer draws
    /// `load` in between. What does not fit is lost.
    pub(crate) fn run(&self, charge: i128, from: i64, to: i64, load: i128) -> i128 {
        self.net.pieces(from, to).fold(charge, |charge, (from, to, net)| {
            (charge + (net - load) * i128::from(to - from)).min(self.capacity)
        })
    }

    /// The last instant in [from, to] at which the charge has never been above
    /// `most`, if it is above it at an instant in [from, to]: `from` if it is
    /// above it already.
    pub(crate) fn full(&self, charge: i128, from: i64, to: i64, most: i128) -> Option<i64> {
        if charge > most {
            return Some(from);
        }
        let mut charge = charge;
        for (from, to, net) in self.net.pieces(from, to) {
            let next = (charge + net * i128::from(to - from)).min(self.capacity);
            if next > most {
                let room = (most - charge) / net;
                return Some(from + i64::try_from(room).unwrap_or(i64::MAX - from));
            }
            charge = next;
        }
        None
    }
}

/// The charge over time: exact at every millisecond.
#[derive(Clone, Debug, Default)]
pub(crate) struct Curve {
    /// From each instant on, the charge there and what flows in.
    knots: Vec<(i64, i128, i128)>,
    capacity: i128,
}

impl Curve {
    /// From `charge` at the first instant of `net`, until `end`.
    pub(crate) fn new(net: &Steps, charge: i128, capacity: i128, (now, end): (i64, i64)) -> Self {
        let mut knots = Vec::new();
        let mut charge = charge.min(capacity);
        for (from, to, net) in net.pieces(now, end) {
            knots.push((from, charge, net));
            charge = (charge + net * i128::from(to - from)).min(capacity);
        }
        knots.push((end, charge, 0));
        Self { knots, capacity }
    }

    pub(crate) fn at(&self, at: i64) -> i128 {
        let i = self.knots.partition_point(|(from, ..)| *from <= at).saturating_sub(1);
        self.knots.get(i).map_or(0, |(from, charge, net)| {
            (charge + net * i128::from((at - from).max(0))).min(self.capacity)
        })
    }

    pub(crate) fn instants(&self) -> impl Iterator<Item = i64> {
        self.knots.iter().map(|(from, ..)| *from)
    }

    /// A line of given knots, that nothing fills.
    pub(crate) const fn of(knots: Vec<(i64, i128, i128)>) -> Self {
        Self { knots, capacity: i128::MAX / 4 }
    }

    /// Upside down: a maximum becomes a minimum.
    pub(crate) fn negated(&self) -> Self {
        Self::of(self.knots.iter().map(|(at, value, slope)| (*at, -value, -slope)).collect())
    }

    /// The first instant in [from, to] at which it is below `least`, and lower
    /// than on the curve `without`, where there is one: and by how much it is
    /// below.
    pub(crate) fn first_below(
        &self,
        least: i128,
        without: Option<&Self>,
        (from, to): (i64, i64),
    ) -> Option<(i64, i128)> {
        let others = without.into_iter().flat_map(Self::instants);
        let mut cuts: Vec<i64> = self.instants().chain(others).chain([from]).collect();
        cuts.retain(|at| (from..=to).contains(at));
        cuts.sort_unstable();
        cuts.dedup();
        let ends = cuts.iter().skip(1).map(|next| next - 1).chain([to]);
        cuts.iter().zip(ends).find_map(|(from, to)| {
            let at = self.below_in(*from, to, least, without)?;
            Some((at, least - self.at(at)))
        })
    }

    /// The first instant in [from, to] at which it is above `most`: and by how
    /// much.
    pub(crate) fn first_above(&self, most: i128, within: (i64, i64)) -> Option<(i64, i128)> {
        // What cannot hold more than that is never above it; and where it is
        // above it, being full does not matter.
        let at = self.negated().first_below(-most, None, within).filter(|_| most < self.capacity);
        at.map(|(at, _)| (at, self.at(at) - most))
    }

    /// The first such instant in [from, to], in which neither rate changes
    /// other than by a battery being full.
    fn below_in(&self, from: i64, to: i64, least: i128, without: Option<&Self>) -> Option<i64> {
        let ours = self.line(from);
        let scarce = negative((ours.0 - least, ours.1), to - from)?;
        let fewer = match without.map(|without| without.line(from)) {
            // A battery that is full elsewhere holds more than one that is
            // below a minimum here, so its line may go on beyond full.
            Some(theirs) => negative((ours.0 - theirs.0, ours.1 - theirs.1), to - from)?,
            None => (0, to - from),
        };
        let first = scarce.0.max(fewer.0);
        (first <= scarce.1.min(fewer.1)).then_some(from + first)
    }

    /// Value and slope at an instant, before anything is full.
    fn line(&self, at: i64) -> (i128, i128) {
        let i = self.knots.partition_point(|(from, ..)| *from <= at).saturating_sub(1);
        let slope = self.knots.get(i).map_or(0, |(.., slope)| *slope);
        (self.at(at), slope)
    }
}

/// The integers x in [0, length] for which value + slope * x < 0.
fn negative((value, slope): (i128, i128), length: i64) -> Option<(i64, i64)> {
    let length = i128::from(length);
    let (first, last) = match slope.signum() {
        0 if value < 0 => (0, length),
        0 => return None,
        // value + slope * x <= -1
        1 => (0, (-1 - value).div_euclid(slope).min(length)),
        _ => ((value.div_euclid(-slope) + 1).max(0), length),
    };
    if first > last {
        return None;
    }
    i64::try_from(first).ok().zip(i64::try_from(last).ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::steps::Changes;

    fn steps(changes: &[(i64, i64, i128)]) -> Steps {
        let mut all = Changes::default();
        for (start, end, amount) in changes {
            all.add_over(*start, *end, *amount);
        }
        all.from(0)
    }

    #[test]
    fn a_full_battery_loses_what_comes_and_starts_to_empty_from_full() {
        let curve = Curve::new(&steps(&[(0, 10, 5), (10, 20, -3)]), 80, 100, (0, 20));
        assert_eq!([0, 4, 5, 10, 11, 20].map(|at| curve.at(at)), [80, 100, 100, 100, 97, 70]);
    }

    #[test]
    fn the_first_instant_below_is_found_as_by_looking_at_every_one() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut found = 0;
        for _ in 0..2_000 {
            let mut line = || {
                let mut piece = || (random.i64(0..30), random.i64(0..30), random.i128(-9..9));
                let net = [piece(), piece(), piece()];
                Curve::new(&steps(&net), random.i128(0..=60), 60, (0, 30))
            };
            let (ours, theirs) = (line(), line());
            let slow = (0..=30).find(|at| ours.at(*at) < 25 && ours.at(*at) < theirs.at(*at));
            let fast = ours.first_below(25, Some(&theirs), (0, 30));
            assert_eq!(fast, slow.map(|at| (at, 25 - ours.at(at))), "{ours:?} {theirs:?}");
            found += usize::from(slow.is_some());
        }
        assert!((200..1_800).contains(&found), "{found}");
    }

    #[test]
    fn it_is_full_at_the_last_instant_before_it_is_too_full() {
        let flow = Flow::new(steps(&[(0, 10, 3), (10, 20, -1), (20, 40, 2)]), 100);
        assert_eq!(flow.full(50, 0, 40, 200), None);
        assert_eq!(flow.full(50, 0, 40, 80), Some(25));
        assert_eq!(flow.full(50, 0, 25, 80), None);
        assert_eq!(flow.full(50, 0, 40, 76), Some(8));
        assert_eq!(flow.full(50, 0, 40, 49), Some(0));
    }
}
