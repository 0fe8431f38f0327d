//! The smallest change of each limit.

use crate::plan::ActivityId;
use crate::schedule::Pass;
use crate::schedule::place::Trial;
use crate::search::Effort;
use crate::timed::{Limit, Reason};
use crate::timeline::Intervals;
use crate::units::{Ppm, Time};

use super::{Change, Relaxation};

/// A candidate at its turn.
struct Turn<'a, 'p> {
    pass: &'a Pass<'p>,
    item: usize,
    /// Starts that its ranges and what it depends on leave.
    left: Intervals,
    /// The first limit in the way, if it is one that starts break.
    blocks: Option<Limit>,
}

pub(super) fn all(pass: &Pass<'_>, item: usize) -> Vec<Relaxation> {
    let after = pass.after(item);
    let left = after.as_ref().map_or_else(|_| Intervals::none(), |&from| pass.left(item, from));
    let blocks = left.first().and_then(|first| match pass.in_the_way(item, first.get()) {
        Reason::Limit { limit, .. } => Some(limit),
        _ => None,
    });
    let turn = Turn { pass, item, left, blocks };
    let mut all = Vec::new();
    let mut may = |limit: Limit, change: Option<Change>| {
        if change.is_some() || turn.blocks.as_ref() == Some(&limit) {
            all.push(Relaxation { limit, change });
        }
    };
    may(Limit::SoftMinimum, turn.soft());
    may(Limit::Handover, turn.handover());
    may(Limit::Data, turn.raised(&Limit::Data, turn.data()));
    may(Limit::Peak, turn.peak());
    may(Limit::Engines, turn.raised(&Limit::Engines, turn.engines()));
    let (held, change) = turn.resources();
    may(held, change);
    if let Some(limit) = turn.other() {
        may(limit, None);
    }
    may(Limit::Range, turn.range());
    may(Limit::Dependency, turn.dependency());
    all
}

/// The smallest change up to `most` with which something is found. Each
/// larger one finds it, too.
fn least(most: i64, found: impl Fn(i64) -> Option<i64>) -> Option<(i64, i64)> {
    let mut start = found(most)?;
    let (mut few, mut enough) = (0, most);
    while enough - few > 1 {
        let middle = few + (enough - few) / 2;
        match found(middle) {
            Some(at) => (enough, start) = (middle, at),
            None => few = middle,
        }
    }
    Some((enough, start))
}

const fn change((by, start): (i64, i64)) -> Change {
    Change { by, start: Time::new(start), with: None, range: None }
}

impl Turn<'_, '_> {
    fn fits(&self, trial: &Trial<'_>, starts: &Intervals) -> Option<i64> {
        self.pass.first_fit(trial, starts, &mut Effort::default())
    }

    fn soft(&self) -> Option<Change> {
        let soft = self.pass.problem.parameters.soft_min_soc.get();
        let found = |by: i64| {
            let problem = self.pass.problem.clone().with_soft(Ppm::new(soft - by));
            self.fits(&Trial { problem: &problem, ..self.pass.trial(self.item) }, &self.left)
        };
        least(soft, found).map(change)
    }

    fn handover(&self) -> Option<Change> {
        let min = self.pass.problem.plan.handover_min_soc.get();
        let found = |by: i64| {
            let problem = self.pass.problem.clone().with_handover(Ppm::new(min - by));
            self.fits(&Trial { problem: &problem, ..self.pass.trial(self.item) }, &self.left)
        };
        least(min, found).map(change)
    }

    fn raised(&self, limit: &Limit, most: i64) -> Option<Change> {
        let found = |by: i64| {
            let timelines = self.pass.timelines.clone().raised(limit, by);
            self.fits(&Trial { timelines: &timelines, ..self.pass.trial(self.item) }, &self.left)
        };
        least(most, found).map(change)
    }

    fn peak(&self) -> Option<Change> {
        let found = |by: i64| {
            let timelines = self.pass.timelines.clone().raised(&Limit::Peak, by);
            let mut problem = self.pass.problem.clone();
            problem.peak_limit += by;
            let trial = self.pass.trial(self.item);
            self.fits(&Trial { timelines: &timelines, problem: &problem, ..trial }, &self.left)
        };
        let all = self.pass.world.peak + self.draw_of_everything();
        least(all, found).map(change)
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

    /// Without the bits that are held at the first start that is left.
    fn resources(&self) -> (Limit, Option<Change>) {
        let trial = self.pass.trial(self.item);
        let mut free = trial.claim.clone();
        free.bits = 0;
        let start = self.fits(&Trial { claim: &free, ..trial }, &self.left);
        let with = self.left.first().and_then(|at| trial.timelines.conflict(trial.claim, at));
        let with = with.filter(|it| matches!(it.limit, Limit::Resources(_)));
        let limit = with.as_ref().map_or(Limit::Resources(trial.claim.bits), |it| it.limit.clone());
        let with = with.and_then(|it| it.with);
        (limit, start.map(|start| Change { with, ..change((0, start)) }))
    }

    /// A limit that is none of those that can be relaxed by a number.
    fn other(&self) -> Option<Limit> {
        self.blocks
            .clone()
            .filter(|limit| matches!(limit, Limit::Timeline(_) | Limit::Computer | Limit::Lead))
    }

    /// A start range that opens earlier, closes later, or may last longer.
    fn range(&self) -> Option<Change> {
        let problem = self.pass.problem;
        let after = self.pass.after(self.item).ok()?;
        let from = if problem.items[self.item].cleanup { problem.now } else { self.pass.from };
        let first = after.max(from);
        let last = problem.end - problem.items[self.item].shortest;
        let trial = self.pass.trial(self.item);
        let starts = |a: i64, b: i64| Intervals::between(Time::new(a), Time::new(b));
        let shortest = problem.items[self.item].shortest;
        let ranges = problem.plan.activities[self.item].starts.iter().enumerate();
        let options = ranges.flat_map(|(at, range)| {
            let (opens, closes) = (range.from.get().max(first), range.to.get());
            let cutoff = range.cutoff.get().saturating_sub(shortest);
            let to = |to: i64, cutoff: i64| to.min(cutoff).min(last);
            let earlier = |by: i64| starts((opens - by).max(first), to(closes, cutoff));
            let later = |by: i64| starts(opens, to(closes.saturating_add(by), cutoff));
            let longer = |by: i64| starts(opens, to(closes, cutoff.saturating_add(by)));
            let options = [
                least(opens - first, |by| self.fits(&trial, &earlier(by))),
                least(last.saturating_sub(closes).max(0), |by| self.fits(&trial, &later(by))),
                least(last.saturating_sub(cutoff).max(0), |by| self.fits(&trial, &longer(by))),
            ];
            let options: Vec<_> = options.into_iter().flatten().filter(|it| it.0 > 0).collect();
            options.into_iter().map(move |it| (it, at))
        });
        let (it, at) = options.min_by_key(|((by, start), at)| (*by, *start, *at))?;
        Some(Change { range: Some(at), ..change(it) })
    }

    /// Without waiting for anything.
    fn dependency(&self) -> Option<Change> {
        let problem = self.pass.problem;
        let with: Option<ActivityId> = problem.items[self.item].after.first().map(|on| on.1.prior);
        with?;
        let starts = self.pass.left(self.item, i64::MIN);
        let start = self.fits(&self.pass.trial(self.item), &starts)?;
        Some(Change { with, ..change((0, start)) })
    }
}
