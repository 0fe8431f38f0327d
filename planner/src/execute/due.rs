//! When to come again.

use super::Control;
use crate::plan::ActivityId;
use crate::state::Mode;
use crate::timed::Slot;
use crate::units::{Span, Time};

impl Control {
    /// The next instant at which something becomes due by itself; before it,
    /// only an event makes anything due. None: the plan is over.
    #[must_use]
    pub fn due(&self) -> Option<Time> {
        if self.is_over {
            return None;
        }
        let now = self.state.now;
        let mut instants = vec![self.plan.end, self.plan.handover];
        instants
            .extend(self.planned_at.get().checked_add(self.options.period.get()).map(Time::new));
        instants.push(self.looked_at_again());
        if self.state.mode == Mode::Awake {
            instants.push(self.charge_is_known_until());
        }
        instants.extend(self.looks_again_from().filter(|_| self.is_untimed));
        self.of_activities(&mut instants);
        self.of_running(&mut instants);
        self.of_computer(&mut instants);
        instants.into_iter().filter(|at| *at > now).min()
    }

    fn of_activities(&self, instants: &mut Vec<Time>) {
        let tolerance = self.parameters.handover_tolerance;
        let past = |at: Time| at.after(Span::new(1));
        for activity in &self.plan.activities {
            instants.push(past(self.last_start(activity)));
        }
        let slots = self.planned.values().map(|slot: &Slot| slot.start);
        instants.extend(slots.flat_map(|start| [start, past(start.after(tolerance))]));
        let asked = self.asked.values().map(|asked| past(asked.since.after(tolerance)));
        instants.extend(asked);
    }

    fn of_running(&self, instants: &mut Vec<Time>) {
        for running in &self.state.running {
            instants.extend([running.cutoff, running.ends]);
            if let Some(activity) = self.activity(running.id) {
                instants.push(self.patience(activity, running));
            }
        }
    }

    fn of_computer(&self, instants: &mut Vec<Time>) {
        for phase in &self.timed.awake {
            instants.extend([phase.wakeup, phase.down]);
        }
        for heating in &self.timed.preheats {
            instants.extend([heating.start, heating.end]);
        }
        for block in self.blocks() {
            instants.extend([block.from, block.until.before(block.wakeup), block.until]);
        }
        for window in self.state.windows.iter().filter(|window| window.awake) {
            instants.extend([window.start, window.end]);
        }
    }

    /// What an activity waits for, if its time has come and it has not started.
    #[must_use]
    pub fn waits_for(&self, id: ActivityId) -> Option<super::NotReady> {
        let slot = self.planned.get(&id).filter(|slot| slot.start <= self.state.now)?;
        self.ready(id, *slot, false).err()
    }
}
