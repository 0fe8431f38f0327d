//! Reasons for waits of which the manager told nothing.

use std::collections::HashMap;

use crate::analyze::trace::{Trace, Wait};
use crate::analyze::track::Track;
use crate::manager::{HeldBy, WaitsFor};
use crate::time::Duration;

impl Trace {
    /// Finds a reason for waits of which nothing was told: the manager tells of
    /// the most important ones only.
    pub(super) fn explain(&mut self) {
        let mut left_off: HashMap<Duration, Vec<usize>> = HashMap::new();
        for (index, track) in self.tracks.iter().enumerate() {
            let segments = track.runs.iter().flat_map(|run| &run.segments);
            for (_, until) in segments {
                left_off.entry(until.saturating_add(track.task.gap)).or_default().push(index);
            }
        }
        let found = self.tracks.iter().enumerate().filter_map(|(index, track)| {
            let longest =
                track.waits.iter().max_by_key(|(from, until)| until.saturating_sub(*from));
            let (from, until) = *longest?;
            let waits_for = self.prior_of(track, from, until).or_else(|| {
                let others = left_off.get(&until).filter(|_| track.reasons.is_empty())?;
                self.blocker_of(track, others)
            });
            Some((index, from, until, waits_for?))
        });
        let found: Vec<_> = found.collect();
        for (index, from, until, waits_for) in found {
            let Some(track) = self.tracks.get_mut(index) else { continue };
            track.reasons.push((format!("waited for {waits_for}"), until.saturating_sub(from)));
            self.waits.push(Wait { task: track.task.id, at: from, waits_for });
        }
    }

    /// The one of its priors that ended last before the wait was over.
    fn prior_of(&self, track: &Track, from: Duration, until: Duration) -> Option<WaitsFor> {
        let ends = track.task.after.iter().filter_map(|dependency| {
            let runs = self.track(dependency.task)?.runs.iter();
            let ends = runs.filter_map(|run| run.end).filter(|end| from < *end && *end <= until);
            Some((ends.max()?, dependency.task))
        });
        ends.max().map(|(_, prior)| WaitsFor::Dependency(prior))
    }

    /// Somebody who had the same, and left off at the instant at which the wait
    /// was over.
    fn blocker_of(&self, track: &Track, others: &[usize]) -> Option<WaitsFor> {
        let mut others = others.iter().filter_map(|other| self.tracks.get(*other));
        let other = others.find(|other| {
            other.task.id != track.task.id && other.task.categories.overlaps(track.task.categories)
        })?;
        let shared = other.task.categories.shared(track.task.categories);
        Some(WaitsFor::Categories { shared, by: HeldBy::Task(other.task.id) })
    }
}
