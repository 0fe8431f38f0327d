//! What is decided before the pass begins: windows, manual shutdowns, what
//! runs, and what an incumbent starts within the commit window.

use crate::derive::{Placed, Placement, World};
use crate::plan::Activity;
use crate::problem::{Known, Problem};
use crate::search::Effort;
use crate::timed::{Fate, Slot, TimedPlan};
use crate::timeline::{Claim, Timelines};
use crate::units::{Span, Time};

use super::Pass;
use super::lean::Leaning;

impl<'a> Pass<'a> {
    pub(crate) fn new(problem: &'a Problem, incumbent: Option<&TimedPlan>) -> Self {
        let count = problem.items.len();
        let placed = Placed::first(problem);
        let timelines = Timelines::new(&problem.plan, &problem.parameters, &problem.state);
        let groups = problem.items.iter().filter_map(|item| item.group).max();
        let mut pass = Self {
            problem,
            world: World::default(),
            placed,
            timelines,
            claims: claims(problem),
            slots: vec![None; count],
            reasons: vec![None; count],
            groups: vec![None; groups.map_or(0, |last| last + 1)],
            committed: vec![false; count],
            from: problem.now,
            excess: Vec::new(),
            unavoidable: Vec::new(),
            version: 1,
            failed: vec![0; count],
            plain: false,
            leanings: vec![Leaning::Earliest; count],
            says_why: true,
            effort: Effort::default(),
        };
        pass.windows();
        pass.known();
        if let Some(incumbent) = incumbent {
            pass.commit(incumbent);
        }
        pass.world = World::of(problem, &pass.placed);
        pass.unavoidable = super::unavoidable::unavoidable(&pass);
        pass
    }

    fn windows(&mut self) {
        let first = self.claims.len();
        for (at, window) in self.problem.state.windows.iter().enumerate() {
            if window.end.get() > self.problem.now {
                self.timelines.insert(&Claim::window(window, first + at), window.start);
            }
        }
    }

    /// What runs, has ended, or is at the ground's own times.
    fn known(&mut self) {
        let now = Time::new(self.problem.now);
        for (at, item) in self.problem.items.iter().enumerate() {
            let taken = match item.fate {
                Known::Open | Known::Block(None) => false,
                Known::Ended { used, .. } => used.is_some(),
                Known::Block(Some((start, end))) => {
                    let (start, end) = (Time::new(start), Time::new(end));
                    self.timelines.insert(&self.claims[at], start);
                    self.slots[at] = Some(Slot { start, end, range: 0 });
                    true
                }
                Known::Running { start, end, .. } => {
                    self.timelines.insert(&self.claims[at], now);
                    let activity = &self.problem.plan.activities[at];
                    let (start, end) = (Time::new(start), Time::new(end));
                    let range = range(activity, start);
                    self.slots[at] = Some(Slot { start, end, range });
                    true
                }
            };
            if let Some(group) = item.group.filter(|_| taken) {
                self.groups[group].get_or_insert(at);
            }
        }
    }

    fn commit(&mut self, incumbent: &TimedPlan) {
        self.from = self.problem.now + self.problem.commit;
        let ids = self.problem.plan.activities.iter().map(|activity| activity.id);
        let index: std::collections::BTreeMap<_, _> = ids.zip(0_usize..).collect();
        for row in &incumbent.rows {
            let Fate::Scheduled(slot) = row.fate else { continue };
            let Some(&item) = index.get(&row.id) else { continue };
            let begins = (self.problem.now..self.from).contains(&slot.start.get());
            if !begins || !self.problem.items[item].is_candidate() || self.slots[item].is_some() {
                continue;
            }
            self.decide(item, slot);
            self.committed[item] = true;
        }
    }

    /// Everything that is decided so far, with other numbers: of a problem of
    /// the same activities. What follows from it is derived anew.
    pub(crate) fn again<'b>(&self, problem: &'b Problem) -> Pass<'b> {
        let mut again = Pass::new(problem, None);
        again.from = self.from;
        for (item, slot) in self.slots.iter().enumerate() {
            if let Some(slot) = *slot
                && problem.items[item].is_candidate()
            {
                again.decide(item, slot);
            }
        }
        again.world = World::of(problem, &again.placed);
        again
    }

    /// The world is not derived again.
    fn decide(&mut self, item: usize, slot: Slot) {
        self.claims[item] = claim(self.problem, item, slot.length());
        let (start, end) = (slot.start.get(), slot.end.get());
        self.placed.insert(self.problem, Placement { item, start, end });
        self.timelines.insert(&self.claims[item], slot.start);
        self.slots[item] = Some(slot);
        if let Some(group) = self.problem.items[item].group {
            self.groups[group].get_or_insert(item);
        }
    }
}

/// The range that it started in.
fn range(activity: &Activity, start: Time) -> usize {
    let holds = |range: &crate::plan::StartRange| range.from <= start && start <= range.to;
    activity.starts.iter().position(holds).unwrap_or(0)
}

fn claims(problem: &Problem) -> Vec<Claim> {
    (0..problem.items.len()).map(|item| claim(problem, item, length(problem, item))).collect()
}

fn length(problem: &Problem, item: usize) -> Span {
    match problem.items[item].fate {
        Known::Block(Some((start, end))) => Span::new(end - start),
        _ => Span::new(problem.items[item].shortest),
    }
}

/// What an activity of this length claims; one that runs, from now on.
pub(super) fn claim(problem: &Problem, item: usize, length: Span) -> Claim {
    let activity = &problem.plan.activities[item];
    let parameters = &problem.parameters;
    let running = problem.state.running.iter().find(|running| running.id == activity.id);
    let claim = match (running, problem.items[item].fate) {
        (Some(running), Known::Running { end, .. }) => {
            let rest = (Time::new(problem.now), Time::new(end));
            Claim::rest(activity, item, running, rest, parameters)
        }
        _ => Claim::of(activity, item, length, parameters),
    };
    // Names were checked when the problem was made.
    claim.unwrap_or_else(|_| Claim::window(&nothing(), item))
}

fn nothing() -> crate::state::Window {
    crate::state::Window {
        name: String::new(),
        start: Time::ZERO,
        end: Time::ZERO,
        awake: false,
        marginal: Default::default(),
        peak: Default::default(),
        data: Default::default(),
        engines: 0,
        resources: Default::default(),
    }
}
