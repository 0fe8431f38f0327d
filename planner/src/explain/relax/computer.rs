//! What the computer does: a manual shutdown that is shorter, or at another
//! time, and less time for waking up and heating. Everything that follows is
//! derived anew for each try.

use crate::plan::{Activity, Kind};
use crate::problem::Known;
use crate::timed::Limit;
use crate::timeline::Intervals;
use crate::units::Time;

use super::super::{Change, Number};
use super::{Turn, change, halved, least};

impl Turn<'_, '_> {
    /// Each manual shutdown that may be in the way: shorter, or at another time,
    /// or else none.
    pub(super) fn shutdowns(&self) -> Vec<Change> {
        let items = self.pass.problem.items.iter().enumerate();
        let blocks = items.filter_map(|(at, item)| match item.fate {
            Known::Block(Some(span)) if self.may_meet(span) => Some((at, span)),
            _ => None,
        });
        blocks.flat_map(|(at, span)| self.shutdown(at, span)).collect()
    }

    /// Whether it, or what is heated for it, lies in it at some start.
    fn may_meet(&self, (from, to): (i64, i64)) -> bool {
        let problem = self.pass.problem;
        let item = &problem.items[self.item];
        let rows = item.zones.iter().flat_map(|&zone| problem.zones[zone].table.iter());
        let heats = rows.map(|row| row.duration.get()).max().unwrap_or(0);
        let mut left = self.left.iter();
        left.any(|(first, last)| {
            first.get() - heats < to && from < last.get() + item.shortest.max(1)
        })
    }

    fn shutdown(&self, at: usize, span: (i64, i64)) -> Vec<Change> {
        let block = &self.pass.problem.plan.activities[at];
        let helps = [self.shorter(block, span), self.moved(at, span)];
        let helps: Vec<_> = helps.into_iter().flatten().collect();
        let helps =
            if helps.is_empty() { self.without(block).into_iter().collect() } else { helps };
        helps.into_iter().map(|change| Change { with: Some(block.id), ..change }).collect()
    }

    fn shorter(&self, block: &Activity, (_, to): (i64, i64)) -> Option<Change> {
        let Kind::ManualShutdown { shutdown, wakeup } = block.kind else { return None };
        let number = Number::Shutdown(block.id);
        let found = |by: i64| self.again(&Limit::Computer, change(number, (by, 0)));
        let most = block.duration.get() - shutdown.get() - wakeup.get();
        // It is not over by now.
        let most = most.min(to - self.pass.problem.now - 1);
        let shorter = if most > 0 { least(most, found) } else { None };
        shorter.map(|shorter| change(number, shorter))
    }

    /// Not one that has begun, and not to where something is that needs the
    /// computer.
    fn moved(&self, at: usize, (from, to): (i64, i64)) -> Option<Change> {
        let problem = self.pass.problem;
        let id = problem.plan.activities[at].id;
        let taken = self.pass.needs_computer();
        // By so much earlier or later it would meet what is there.
        let earlier = taken.iter().map(|need| (from - need.1 + 1, to - need.0 - 1));
        let later = taken.iter().map(|need| (need.0 - to + 1, need.1 - from - 1));
        let both = [
            (Number::Earlier(id), free(earlier, from - problem.now)),
            (Number::Later(id), free(later, problem.end - to)),
        ];
        let moves = both.into_iter().filter(|_| from > problem.now);
        let moves = moves.filter_map(|(number, free)| {
            let found = |by: i64| self.again_beside(at, change(number, (by, 0)));
            let found = free.iter().find_map(|(a, b)| least_within(a.get(), b.get(), found));
            found.map(|found| change(number, found))
        });
        moves.min_by_key(|it| (it.by, it.start))
    }

    /// Its turn once more after a manual shutdown was moved, if everything that
    /// is placed is out of that and still keeps every limit.
    fn again_beside(&self, at: usize, change: Change) -> Option<i64> {
        let problem = self.changed(&Limit::Computer, change)?;
        let mut again = self.pass.again(&problem);
        let is_apart = again.is_apart_from_blocks() && again.is_free_for(at);
        let keeps = is_apart && again.keeps_by_itself();
        let slot = if keeps { again.find(self.item).ok()? } else { return None };
        Some(slot.start.get())
    }

    fn without(&self, block: &Activity) -> Option<Change> {
        let without = Change { with: Some(block.id), ..change(Number::Without, (0, 0)) };
        let start = self.again(&Limit::Computer, without)?;
        Some(Change { start: Time::new(start), ..without })
    }

    /// The smallest of what takes time before it.
    pub(super) fn lead(&self) -> impl Iterator<Item = Change> {
        let is_short = self.blocks.contains_key(&Limit::Lead);
        let numbers = if is_short { self.times() } else { Vec::new() };
        let changes = numbers.into_iter().filter_map(|(number, most)| {
            let found = |by: i64| self.again(&Limit::Lead, change(number, (by, 0)));
            let shorter = if most > 0 { least(most, found) } else { None };
            shorter.map(|shorter| change(number, shorter))
        });
        changes.min_by_key(|it| (it.by, it.start)).into_iter()
    }

    fn times(&self) -> Vec<(Number, i64)> {
        let problem = self.pass.problem;
        let heating = problem.items[self.item].zones.iter().flat_map(|&zone| {
            let rows = problem.zones[zone].table.iter().enumerate();
            rows.map(move |(row, it)| (Number::Heating(zone, row), it.duration.get()))
        });
        let wakeup = (Number::Wakeup, problem.computer.wakeup_time);
        let sleep = (Number::MinSleep, problem.computer.min_sleep);
        heating.chain([wakeup, sleep]).collect()
    }
}

/// The changes from 1 to `most` that are in none of these.
fn free(taken: impl Iterator<Item = (i64, i64)>, most: i64) -> Intervals {
    let taken = taken.map(|(first, last)| (Time::new(first), Time::new(last)));
    Intervals::between(Time::new(1), Time::new(most)).without(&Intervals::of(taken))
}

/// The smallest change between two with which something is found: tried from the
/// first one on in steps that double, since too far can be as wrong as not far
/// enough, and at the last one.
fn least_within(first: i64, last: i64, found: impl Fn(i64) -> Option<i64>) -> Option<(i64, i64)> {
    let steps = (0..63).map(|power| (1_i64 << power) - 1).take_while(|step| first + step < last);
    let mut tries = steps.map(|step| first + step).chain([last]);
    let enough = tries.find_map(|by| Some((by, found(by)?)))?;
    let past = |by: i64| if by < first { None } else { found(by) };
    Some(halved(enough, past))
}
