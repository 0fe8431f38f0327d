//! The smallest change of each number.

mod computer;
mod held;
mod named;
mod ranges;

use core::mem::discriminant;
use std::collections::BTreeMap;

use crate::Problem;
use crate::plan::ActivityId;
use crate::schedule::Pass;
use crate::schedule::place::Trial;
use crate::search::Effort;
use crate::timed::{Limit, Reason};
use crate::timeline::Intervals;
use crate::units::{Ppm, Time};

use super::{Change, Number, Relaxation};

/// A candidate at its turn.
struct Turn<'a, 'p> {
    pass: &'a Pass<'p>,
    item: usize,
    id: ActivityId,
    /// Starts that its ranges and what it depends on leave.
    left: Intervals,
    /// What is in the way of the first of them.
    blocks: BTreeMap<Limit, Reason>,
}

pub(super) fn all(pass: &Pass<'_>, item: usize, reason: &Reason) -> Vec<Relaxation> {
    let after = pass.after(item);
    let left = after.as_ref().map_or_else(|_| Intervals::none(), |&from| pass.left(item, from));
    let first = left.first().map(Time::get);
    let mut blocks = first.map(|first| pass.all_in_the_way(item, first)).unwrap_or_default();
    let other = match reason {
        Reason::NoRangeLeft | Reason::Committed => Some(Limit::Range),
        Reason::PriorOut(_) | Reason::PriorEnded(..) | Reason::WaitsForOutcome(_) => {
            Some(Limit::Dependency)
        }
        _ => None,
    };
    blocks.extend(other.map(|limit| (limit, reason.clone())));
    Turn { pass, item, id: pass.id(item), left, blocks }.all()
}

/// The smallest change up to `most` with which something is found; one unit
/// less, and nothing is.
fn least(most: i64, found: impl Fn(i64) -> Option<i64>) -> Option<(i64, i64)> {
    let start = found(most)?;
    Some(halved((most, start), found))
}

/// The same, where `enough` is known to be.
fn halved((mut enough, mut start): (i64, i64), found: impl Fn(i64) -> Option<i64>) -> (i64, i64) {
    let mut few = 0;
    while enough - few > 1 {
        let middle = few + (enough - few) / 2;
        match found(middle) {
            Some(at) => (enough, start) = (middle, at),
            None => few = middle,
        }
    }
    (enough, start)
}

const fn change(number: Number, (by, start): (i64, i64)) -> Change {
    Change { number, by, start: Time::new(start), with: None, until: None }
}

impl Turn<'_, '_> {
    fn all(&self) -> Vec<Relaxation> {
        let mut all = Vec::new();
        self.own(Limit::SoftMinimum, self.soft(), &mut all);
        self.own(Limit::Handover, self.handover(), &mut all);
        self.own(Limit::Data, self.raised(&Limit::Data, self.data()), &mut all);
        self.own(Limit::Peak, self.peak(), &mut all);
        self.own(Limit::Engines, self.raised(&Limit::Engines, self.engines()), &mut all);
        self.helps(Limit::Resources(0), self.resources(), &mut all);
        for (name, changes) in self.named() {
            let changes = changes.into_iter();
            let name = Limit::Timeline(name);
            self.helps(name.clone(), changes.map(|it| (name.clone(), it)), &mut all);
        }
        let of = |limit: Limit| move |change| (limit.clone(), change);
        self.helps(
            Limit::Computer,
            self.shutdowns().into_iter().map(of(Limit::Computer)),
            &mut all,
        );
        self.helps(Limit::Lead, self.lead().map(of(Limit::Lead)), &mut all);
        self.helps(Limit::Range, self.ranges().map(of(Limit::Range)), &mut all);
        let dependencies = self.dependencies().into_iter();
        self.helps(Limit::Dependency, dependencies.map(of(Limit::Dependency)), &mut all);
        all
    }

    /// A limit that has one number.
    fn own(&self, limit: Limit, found: Option<(i64, i64)>, all: &mut Vec<Relaxation>) {
        let found = found.map(|found| (limit.clone(), change(Number::Limit, found)));
        self.helps(limit, found, all);
    }

    /// What helps, or that nothing does, where the limit is in the way.
    fn helps(
        &self,
        limit: Limit,
        changes: impl IntoIterator<Item = (Limit, Change)>,
        all: &mut Vec<Relaxation>,
    ) {
        let before = all.len();
        let some = changes.into_iter();
        all.extend(some.map(|(limit, it)| Relaxation { limit, change: Some(it) }));
        let is_it = |other: &&Limit| match (&limit, other) {
            (Limit::Timeline(name), Limit::Timeline(other)) => name == other,
            (one, other) => discriminant(one) == discriminant(other),
        };
        if all.len() == before
            && let Some(limit) = self.blocks.keys().find(is_it)
        {
            all.push(Relaxation { limit: limit.clone(), change: None });
        }
    }

    fn fits(&self, trial: &Trial<'_>, starts: &Intervals) -> Option<i64> {
        self.pass.first_fit(trial, starts, &mut Effort::default())
    }

    /// Its turn once more, after a change of what the ground wrote.
    fn again(&self, limit: &Limit, change: Change) -> Option<i64> {
        let problem = self.changed(limit, change)?;
        let slot = self.pass.again(&problem).find(self.item).ok()?;
        Some(slot.start.get())
    }

    fn changed(&self, limit: &Limit, change: Change) -> Option<Problem> {
        let old = self.pass.problem;
        let (mut plan, mut parameters) = (old.plan().clone(), old.parameters().clone());
        let relaxation = Relaxation { limit: limit.clone(), change: Some(change) };
        relaxation.apply(self.id, &mut plan, &mut parameters);
        Problem::new(&plan, &parameters, old.state()).ok()
    }

    fn soft(&self) -> Option<(i64, i64)> {
        let soft = self.pass.problem.parameters.soft_min_soc.get();
        let found = |by: i64| {
            let problem = self.pass.problem.clone().with_soft(Ppm::new(soft - by));
            self.fits(&Trial { problem: &problem, ..self.pass.trial(self.item) }, &self.left)
        };
        least(soft, found)
    }

    fn handover(&self) -> Option<(i64, i64)> {
        let min = self.pass.problem.plan.handover_min_soc.get();
        let found = |by: i64| {
            let problem = self.pass.problem.clone().with_handover(Ppm::new(min - by));
            self.fits(&Trial { problem: &problem, ..self.pass.trial(self.item) }, &self.left)
        };
        least(min, found)
    }

    fn raised(&self, limit: &Limit, most: i64) -> Option<(i64, i64)> {
        let found = |by: i64| {
            let timelines = self.pass.timelines.clone().raised(limit, by);
            self.fits(&Trial { timelines: &timelines, ..self.pass.trial(self.item) }, &self.left)
        };
        least(most, found)
    }

    fn peak(&self) -> Option<(i64, i64)> {
        let found = |by: i64| {
            let timelines = self.pass.timelines.clone().raised(&Limit::Peak, by);
            let mut problem = self.pass.problem.clone();
            problem.peak_limit += by;
            let trial = self.pass.trial(self.item);
            self.fits(&Trial { timelines: &timelines, problem: &problem, ..trial }, &self.left)
        };
        let all = self.pass.world.peak + self.draw_of_everything();
        least(all, found)
    }

    /// More than it and all that is heated and awake for it can draw.
    fn draw_of_everything(&self) -> i64 {
        let problem = self.pass.problem;
        let computer = problem.computer;
        let own =
            [computer.awake, computer.wakeup, computer.shutdown, problem.items[self.item].draw];
        let zones = problem.zones.iter().map(|zone| zone.draw);
        own.into_iter().chain(zones).map(|draw| draw.peak).sum()
    }

    fn data(&self) -> i64 {
        let most = self.pass.timelines.volumes(Time::new(self.pass.problem.now));
        let most = most.map(|(_, total)| total).max().unwrap_or(0);
        let own = self.pass.problem.plan.activities[self.item].data.get();
        (most - self.pass.problem.plan.max_delta_data.get()).max(0) + own.max(0)
    }

    fn engines(&self) -> i64 {
        let all = self.pass.problem.plan.activities.iter().map(|it| i64::from(it.engines));
        let windows = self.pass.problem.state.windows.iter().map(|it| i64::from(it.engines));
        all.chain(windows).sum()
    }
}
