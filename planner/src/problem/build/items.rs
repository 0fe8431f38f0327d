//! Activities, as the planner counts with them.

use std::collections::BTreeMap;

use crate::parameters::Parameters;
use crate::plan::{Activity, Kind, Plan};
use crate::problem::{Block, Draw, Item, Known, Range, is_expanding};
use crate::state::{Running, State};

use super::{FAR, Index, small};

pub(super) fn index(plan: &Plan) -> Index {
    plan.activities.iter().enumerate().map(|(at, activity)| (activity.id, at)).collect()
}

pub(super) fn items(plan: &Plan, parameters: &Parameters, state: &State) -> Vec<Item> {
    let index = index(plan);
    let zones = parameters.zones.iter().enumerate().map(|(at, zone)| (zone.name.as_str(), at));
    let names = Names {
        index: &index,
        zones: zones.collect(),
        groups: groups(plan),
        end: plan.end.get().max(state.now.get()),
    };
    let mut items: Vec<Item> =
        plan.activities.iter().map(|activity| names.item(activity, parameters, state)).collect();
    for ended in &state.ended {
        if let Some(&at) = index.get(&ended.id) {
            let used = ended.started.map(|started| (started.get(), ended.ended.get()));
            items[at].fate = Known::Ended { outcome: ended.outcome, used };
        }
    }
    for running in &state.running {
        if let Some(&at) = index.get(&running.id) {
            items[at].fate = in_progress(running, parameters, state);
        }
    }
    items
}

/// Past its planned end, it is looked at again after the commit window, and a
/// second at least.
fn in_progress(running: &Running, parameters: &Parameters, state: &State) -> Known {
    let now = state.now.get();
    let again = now + parameters.commit.get().max(1_000);
    let end = if running.ends.get() <= now { again } else { running.ends.get() };
    Known::Running { start: running.started.get(), end, paused: running.paused.is_some() }
}

fn groups(plan: &Plan) -> BTreeMap<&str, usize> {
    let mut groups = BTreeMap::new();
    for group in plan.activities.iter().filter_map(|activity| activity.group.as_deref()) {
        let next = groups.len();
        groups.entry(group).or_insert(next);
    }
    groups
}

struct Names<'a> {
    index: &'a Index,
    zones: BTreeMap<&'a str, usize>,
    groups: BTreeMap<&'a str, usize>,
    end: i64,
}

impl Names<'_> {
    fn item(&self, activity: &Activity, parameters: &Parameters, state: &State) -> Item {
        let after = activity.after.iter();
        let after = after.filter_map(|on| Some((*self.index.get(&on.prior)?, on.clone())));
        let mut zones: Vec<usize> = activity
            .zones
            .iter()
            .filter_map(|zone| self.zones.get(zone.as_str()).copied())
            .collect();
        zones.sort_unstable();
        zones.dedup();
        if activity.placed().get() == 0 {
            zones.clear();
        }
        Item {
            fate: match activity.kind {
                Kind::ManualShutdown { .. } => Known::Block(span(activity, state)),
                _ => Known::Open,
            },
            mandatory: activity.priority >= parameters.mandatory_from,
            cleanup: activity.kind == Kind::Cleanup,
            expanding: is_expanding(activity.kind),
            shortest: activity.placed().get(),
            longest: activity.duration.get(),
            draw: Draw { marginal: small(activity.marginal), peak: small(activity.peak) },
            zones,
            ranges: self.ranges(activity),
            after: after.collect(),
            group: activity.group.as_deref().and_then(|group| self.groups.get(group).copied()),
        }
    }

    fn ranges(&self, activity: &Activity) -> Vec<Range> {
        let range = |range: &crate::plan::StartRange| {
            let last = range.cutoff.get().min(self.end);
            let to = range.to.get().min(last.saturating_sub(activity.placed().get()));
            Range { from: range.from.get().min(FAR), to, last }
        };
        activity.starts.iter().map(range).collect()
    }
}

/// When a manual shutdown is, if it is not over.
fn span(activity: &Activity, state: &State) -> Option<(i64, i64)> {
    let from = activity.starts.first()?.from.get();
    let to = from.saturating_add(activity.duration.get());
    (to > state.now.get() && from < to).then_some((from, to))
}

/// The manual shutdowns, in order.
pub(super) fn blocks(plan: &Plan, state: &State) -> Vec<Block> {
    let gone = |activity: &Activity| state.ended.iter().any(|ended| ended.id == activity.id);
    let block = |activity: &Activity| {
        let Kind::ManualShutdown { shutdown, wakeup } = activity.kind else { return None };
        let (from, to) = span(activity, state)?;
        let end = plan.end.get().max(state.now.get());
        (from < end && !gone(activity)).then(|| Block {
            from,
            shutdown_until: from.saturating_add(shutdown.get()),
            wakeup_from: to.saturating_sub(wakeup.get()),
            to: to.min(end),
        })
    };
    let mut blocks: Vec<Block> = plan.activities.iter().filter_map(block).collect();
    blocks.sort_by_key(|block| (block.from, block.to));
    blocks
}
