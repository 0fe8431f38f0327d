//! What is told of a task in the end.

use crate::analyze::report::{Picture, TaskReport};
use crate::analyze::track::Track;
use crate::task::{Body, Task};
use crate::time::Duration;

impl Track {
    pub(super) fn longest_reason(&self) -> Option<&str> {
        let never = self.never.as_ref().map(|(_, why)| why.as_str());
        let long = self.reasons.iter().max_by_key(|(_, long)| *long).map(|(why, _)| why.as_str());
        never.or(long)
    }

    /// What is told of it in the end.
    pub(super) fn report(self, horizon: Duration) -> TaskReport {
        TaskReport {
            id: self.task.id,
            waited: self.waited(),
            reason: self.reason(),
            more: Picture {
                windows: self.windows_that_were_seen(horizon),
                name: called(&self.task),
                priority: self.task.priority.level(),
                categories: self.task.categories,
                gap: self.task.gap,
                waits: self.waits,
                misses: self.misses,
                routine: self.task.interval.is_some(),
            },
            runs: self.runs,
        }
    }

    /// Only where it matters: a task that never had to wait has none.
    fn reason(&self) -> Option<String> {
        let matters = self.never.is_some() || !self.waited().is_zero();
        self.longest_reason().filter(|_| matters).map(str::to_owned)
    }

    /// Those that close: one that stays open is no window to look at.
    fn windows_that_were_seen(&self, horizon: Duration) -> Vec<(Duration, Option<Duration>)> {
        let last = self.seen.unwrap_or(self.first);
        let opens = |occurrence: &u64| self.windows(*occurrence).any(|(opens, _)| opens < horizon);
        let seen = (self.first..=last).take_while(opens);
        let all = seen.flat_map(|occurrence| self.windows(occurrence));
        all.filter(|(opens, closes)| closes.is_some() && *opens < horizon).collect()
    }

    /// How long it was due and did not run.
    pub(super) fn waited(&self) -> Duration {
        let waits = self.waits.iter().map(|(from, until)| until.saturating_sub(*from));
        waits.fold(self.pauses, Duration::saturating_add)
    }
}

/// What people call it, or the program that it runs.
fn called(task: &Task) -> Option<String> {
    let program = match &task.body {
        Body::Process { program, .. } => program.rsplit('/').next().unwrap_or(program).to_owned(),
        Body::Function { number, .. } => format!("function {number}"),
        Body::Sequence(_) => "sequence".into(),
        Body::Hold => "hold".into(),
        Body::BuiltIn(_) => "built in".into(),
    };
    task.name.clone().or(Some(program))
}
