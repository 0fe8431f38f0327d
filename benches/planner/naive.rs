//! The scheduler that is written first: by priority, each start on a grid of
//! minutes, each compared with everything that is placed. It knows bits, peak,
//! engines and data; no charge, no heating, no awake time.

use core::cmp::Reverse;

use faregate_planner::plan::Plan;
use faregate_planner::{Activity, Parameters, State};

const MINUTE: usize = 60_000;

/// What is placed: from when to when, and what it uses.
struct Used {
    from: i64,
    to: i64,
    bits: u128,
    peak: u64,
    engines: u32,
    data: i64,
}

impl Used {
    fn of(activity: &Activity, from: i64) -> Self {
        Self {
            from,
            to: from + activity.placed().get(),
            bits: activity.resources.mask(),
            peak: activity.peak.get(),
            engines: activity.engines,
            data: activity.data.get(),
        }
    }
}

/// How many activities it places.
pub(crate) fn schedule(plan: &Plan, parameters: &Parameters, state: &State) -> usize {
    let mut placed: Vec<Used> = state
        .windows
        .iter()
        .map(|window| Used {
            from: window.start.get(),
            to: window.end.get(),
            bits: window.resources.mask(),
            peak: window.peak.get(),
            engines: window.engines,
            data: window.data.get(),
        })
        .collect();
    let given = placed.len();
    let mut order: Vec<&Activity> = plan.activities.iter().collect();
    order.sort_by_key(|activity| Reverse(activity.priority));
    for activity in order {
        let starts = activity.starts.iter().flat_map(|range| {
            let last = range.cutoff.min(plan.end).before(activity.placed()).min(range.to);
            (range.from.max(state.now).get()..=last.get()).step_by(MINUTE)
        });
        let uses = starts.map(|start| Used::of(activity, start));
        if let Some(first) = uses.into_iter().find(|new| fits(new, &placed, plan, parameters)) {
            placed.push(first);
        }
    }
    placed.len() - given
}

/// Looks at each instant at which something begins, since sums change there.
fn fits(new: &Used, placed: &[Used], plan: &Plan, parameters: &Parameters) -> bool {
    let beside: Vec<&Used> =
        placed.iter().filter(|other| other.from < new.to && new.from < other.to).collect();
    let instants = beside.iter().map(|other| other.from.max(new.from)).chain([new.from]);
    let total: i64 = placed.iter().map(|other| other.data).sum();
    beside.iter().all(|other| other.bits & new.bits == 0)
        && total + new.data <= plan.max_delta_data.get()
        && instants.into_iter().all(|at| {
            let now = || beside.iter().filter(|other| other.from <= at && at < other.to);
            now().map(|other| other.peak).sum::<u64>() + new.peak <= parameters.peak_limit.get()
                && now().map(|other| other.engines).sum::<u32>() + new.engines <= parameters.engines
        })
}
