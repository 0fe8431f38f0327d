//! Tasks that wait for each other, or clean up after each other, for ever.

use std::collections::BTreeMap;

use crate::format::diagnostic::Rule;
use crate::format::draft::Draft;
use crate::format::wrong::{Report, Wrong};
use crate::task::TaskId;

/// Tells of one circle for each group of tasks that wait for each other.
pub(crate) fn find(drafts: &[Draft], report: &mut Report<'_>) {
    let known: BTreeMap<TaskId, usize> =
        (drafts.iter().enumerate()).filter_map(|(index, draft)| Some((draft.id?, index))).collect();
    let index = |id: TaskId| known.get(&id).copied();
    let priors: Vec<Vec<usize>> = (drafts.iter())
        .map(|draft| draft.task.after.iter().filter_map(|prior| index(prior.task)).collect())
        .collect();
    let stuck = stuck(&priors);
    let waits = |task: usize| {
        priors.get(task)?.iter().copied().find(|prior| stuck.get(*prior) == Some(&true))
    };
    for circle in walk(drafts.len(), |task| stuck.get(task)?.then(|| waits(task))?) {
        tell(drafts, &circle, "after", "waits for", report);
    }
    let cleanup = |task: usize| drafts.get(task)?.task.cleanup.and_then(index);
    for circle in walk(drafts.len(), cleanup) {
        tell(drafts, &circle, "cleanup", "is cleaned up after by", report);
    }
}

/// Which tasks can never have all their priors behind them: those that remain
/// when everything without a prior is taken away, again and again.
fn stuck(priors: &[Vec<usize>]) -> Vec<bool> {
    let mut followers = vec![Vec::new(); priors.len()];
    let mut open: Vec<usize> = priors.iter().map(Vec::len).collect();
    for (task, priors) in priors.iter().enumerate() {
        for prior in priors {
            if let Some(followers) = followers.get_mut(*prior) {
                followers.push(task);
            }
        }
    }
    let mut free: Vec<usize> =
        (0..priors.len()).filter(|task| open.get(*task) == Some(&0)).collect();
    while let Some(task) = free.pop() {
        for follower in followers.get(task).into_iter().flatten() {
            if let Some(open) = open.get_mut(*follower) {
                *open -= 1;
                if *open == 0 {
                    free.push(*follower);
                }
            }
        }
    }
    open.into_iter().map(|open| open > 0).collect()
}

/// The circles that one meets by following, from each place, the way onwards.
fn walk(places: usize, next: impl Fn(usize) -> Option<usize>) -> Vec<Vec<usize>> {
    let mut seen = vec![None; places];
    let mut circles = Vec::new();
    for start in 0..places {
        let mut path = Vec::new();
        let mut here = Some(start);
        while let Some(place) = here
            && seen.get(place) == Some(&None)
        {
            path.push(place);
            seen.iter_mut().skip(place).take(1).for_each(|seen| *seen = Some(start));
            here = next(place);
        }
        let met = here.and_then(|place| path.iter().position(|step| *step == place));
        circles.extend(met.and_then(|from| path.get(from..)).map(<[usize]>::to_vec));
    }
    circles
}

fn tell(
    drafts: &[Draft],
    circle: &[usize],
    field: &'static str,
    how: &str,
    report: &mut Report<'_>,
) {
    let members: Vec<&Draft> = circle.iter().filter_map(|index| drafts.get(*index)).collect();
    let Some(first) = members.iter().copied().min_by_key(|draft| draft.whole.start) else { return };
    let from = members.iter().position(|draft| draft.id == first.id).unwrap_or(0);
    let around = members.iter().cycle().skip(from).take(members.len().min(8) + 1);
    let names: Vec<_> = around.filter_map(|draft| draft.id).map(|id| id.to_string()).collect();
    let message = names.join(&format!(" {how} "));
    let wrong = Wrong::new(Rule::Cycle, message).expected("no circle");
    report.error(first.span(field), field, wrong);
}
