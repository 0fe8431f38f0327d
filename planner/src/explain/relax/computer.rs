//! What the computer does: a shorter manual shutdown, and less time for waking
//! up and heating. Everything that follows is derived anew for each try.

use crate::plan::Kind;
use crate::problem::Known;
use crate::timed::Limit;
use crate::units::Time;

use super::super::{Change, Number};
use super::{Turn, change, least};

impl Turn<'_, '_> {
    /// Each manual shutdown that may be in the way: shorter, or else none.
    pub(super) fn shutdowns(&self) -> Vec<Change> {
        let items = self.pass.problem.items.iter().enumerate();
        let blocks = items.filter_map(|(at, item)| match item.fate {
            Known::Block(Some(span)) if self.may_meet(span) => Some((at, span)),
            _ => None,
        });
        blocks.filter_map(|(at, span)| self.shutdown(at, span)).collect()
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

    fn shutdown(&self, at: usize, (_, to): (i64, i64)) -> Option<Change> {
        let block = &self.pass.problem.plan.activities[at];
        let Kind::ManualShutdown { shutdown, wakeup } = block.kind else { return None };
        let number = Number::Shutdown(block.id);
        let found = |by: i64| self.again(&Limit::Computer, change(number, (by, 0)));
        let most = block.duration.get() - shutdown.get() - wakeup.get();
        // It is not over by now.
        let most = most.min(to - self.pass.problem.now - 1);
        let shorter = if most > 0 { least(most, found) } else { None };
        let with = Some(block.id);
        if let Some(shorter) = shorter {
            return Some(Change { with, ..change(number, shorter) });
        }
        let without = Change { with, ..change(Number::Without, (0, 0)) };
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
