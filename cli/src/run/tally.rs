//! What became of the tasks of a run, in numbers.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use faregate_scheduler::TaskId;
use faregate_scheduler::manager::Note;
use faregate_scheduler::task::{Outcome, Task};

/// Counts occurrences by their outcome.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    succeeded: u64,
    failed: u64,
    aborted: u64,
    missed: u64,
    never_run: u64,
    /// Those that the mission needs.
    mandatory: BTreeSet<TaskId>,
    /// Which of them went wrong, and how.
    wanting: BTreeMap<TaskId, &'static str>,
}

impl Tally {
    /// This task is in the schedule from now on: whether it is mandatory makes
    /// the difference. Its number may have been another one's before.
    pub(crate) fn learn(&mut self, task: &Task) {
        if task.mandatory {
            self.mandatory.insert(task.id);
        } else {
            self.mandatory.remove(&task.id);
        }
    }

    /// Counts what the note tells.
    pub(crate) fn count(&mut self, note: &Note) {
        match note {
            Note::Ended { occurrence, outcome } => self.ended(occurrence.task, *outcome),
            Note::Missed { task, count, .. } => {
                self.missed += count;
                self.wants(*task, "was missed");
            }
            Note::NeverRuns { task, .. } => {
                self.never_run += 1;
                self.wants(*task, "never ran");
            }
            _ => {}
        }
    }

    fn ended(&mut self, task: TaskId, outcome: Outcome) {
        match outcome {
            Outcome::Succeeded => self.succeeded += 1,
            Outcome::Failed => {
                self.failed += 1;
                self.wants(task, "failed");
            }
            Outcome::Aborted => {
                self.aborted += 1;
                self.wants(task, "was aborted");
            }
            Outcome::Missed => {
                self.missed += 1;
                self.wants(task, "was missed");
            }
        }
    }

    fn wants(&mut self, task: TaskId, how: &'static str) {
        if self.mandatory.contains(&task) {
            self.wanting.insert(task, how);
        }
    }

    /// What went wrong of what the mission needs.
    pub(crate) fn wanting(&self) -> Option<String> {
        let wanting: Vec<String> =
            self.wanting.iter().map(|(task, how)| format!("{task} {how}")).collect();
        (!wanting.is_empty()).then(|| format!("the mission needs it, but {}", wanting.join(", ")))
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.succeeded, "succeeded"),
            (self.failed, "failed"),
            (self.aborted, "aborted"),
            (self.missed, "missed"),
            (self.never_run, "never run"),
        ];
        let told = counts.iter().filter(|(count, word)| *count > 0 || *word == "succeeded");
        let told: Vec<String> = told.map(|(count, word)| format!("{count} {word}")).collect();
        f.write_str(&told.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use faregate_scheduler::manager::Occurrence;
    use faregate_scheduler::task::Body;

    use super::*;

    #[test]
    fn only_what_the_mission_needs_makes_a_run_fail() {
        let task = |id, mandatory| {
            let id = TaskId::new(id).unwrap();
            Task { mandatory, ..Task::new(id, Body::Hold) }
        };
        let mut tally = Tally::default();
        [task(1, false), task(2, true)].iter().for_each(|task| tally.learn(task));
        let ended = |id, outcome| Note::Ended {
            occurrence: Occurrence { task: TaskId::new(id).unwrap(), load: 0, number: 0 },
            outcome,
        };
        tally.count(&ended(1, Outcome::Failed));
        assert_eq!(tally.wanting(), None);
        tally.count(&ended(2, Outcome::Succeeded));
        tally.count(&ended(2, Outcome::Aborted));
        assert_eq!(tally.to_string(), "1 succeeded, 1 failed, 1 aborted");
        assert!(tally.wanting().unwrap().contains("task 2 was aborted"));
        let mut tally = Tally::default();
        [task(1, true), task(1, false)].iter().for_each(|task| tally.learn(task));
        tally.count(&ended(1, Outcome::Failed));
        assert_eq!(tally.wanting(), None, "it is another task of this number");
    }
}
