//! What the tasks themselves draw: the computers that they run on.

use std::collections::BTreeMap;

use faregate_scheduler::manager::{Attempt, Note};
use faregate_tickets::amount::Milliwatts;

/// The attempts that run, with what each draws.
#[derive(Debug, Default)]
pub(crate) struct Loads(BTreeMap<Attempt, Milliwatts>);

impl Loads {
    /// Follows a change; `draw` says what the task of an attempt draws. The sum
    /// from now on, if it has changed.
    pub(crate) fn follow(
        &mut self,
        note: &Note,
        draw: impl FnOnce(Attempt) -> Milliwatts,
    ) -> Option<Milliwatts> {
        match note {
            Note::Started(attempt) | Note::Resumed(attempt) => {
                let draw = draw(*attempt);
                self.0.insert(*attempt, draw);
            }
            Note::Paused(attempt) | Note::Preempted(attempt) | Note::Over { attempt, .. } => {
                self.0.remove(attempt)?;
            }
            _ => return None,
        }
        Some(self.0.values().copied().fold(Milliwatts::ZERO, Milliwatts::saturating_add))
    }
}

#[cfg(test)]
mod tests {
    use faregate_scheduler::TaskId;
    use faregate_scheduler::manager::Occurrence;

    use super::*;

    #[test]
    fn only_what_runs_draws() {
        let attempt = |id| {
            let task = TaskId::new(id).unwrap();
            Attempt { occurrence: Occurrence { task, load: 0, number: 0 }, number: 1 }
        };
        let draw = |attempt: Attempt| Milliwatts::new(attempt.occurrence.task.get().into());
        let mut loads = Loads::default();
        let mut sum = |note| loads.follow(&note, draw).map(Milliwatts::get);
        assert_eq!(sum(Note::Started(attempt(1))), Some(1));
        assert_eq!(sum(Note::Started(attempt(20))), Some(21));
        assert_eq!(sum(Note::Paused(attempt(20))), Some(1));
        assert_eq!(sum(Note::Preempted(attempt(20))), None, "it stood still already");
        assert_eq!(sum(Note::Resumed(attempt(20))), Some(21));
        assert_eq!(sum(Note::Preempted(attempt(1))), Some(20));
    }
}
