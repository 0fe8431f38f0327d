//! The computer and the heaters: what the planner generated, as it becomes due.

use super::{Action, Control};
use crate::plan::{ActivityId, Kind};
use crate::state::Mode;
use crate::units::{Span, Time};

/// A manual shutdown, sleep and wakeup.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) id: ActivityId,
    pub(super) from: Time,
    pub(super) until: Time,
    shutdown: Span,
    pub(super) wakeup: Span,
}

impl Control {
    /// Those that are not over, and were not vetoed.
    pub(super) fn blocks(&self) -> impl Iterator<Item = Block> {
        let open = self.plan.activities.iter().filter(|activity| self.is_open(activity.id));
        open.filter_map(|activity| {
            let Kind::ManualShutdown { shutdown, wakeup } = activity.kind else { return None };
            let from = activity.starts.first()?.from;
            let until = from.after(activity.duration);
            Some(Block { id: activity.id, from, until, shutdown, wakeup })
        })
    }

    pub(super) fn block_now(&self) -> Option<Block> {
        let now = self.now();
        self.blocks().find(|block| block.from <= now && now < block.until)
    }

    pub(super) fn run_computer(&mut self) {
        let block = self.block_now();
        match self.state.mode {
            Mode::Asleep if self.is_wanted_up() => {
                let manual = block.map(|block| block.wakeup);
                let takes = manual.unwrap_or(self.parameters.wakeup.duration);
                self.begin(Mode::WakingUp);
                self.actions.push(Action::Wake(takes));
            }
            Mode::Awake if !self.is_wanted_up() => {
                let manual = block.map(|block| block.shutdown);
                let takes = manual.unwrap_or(self.parameters.shutdown.duration);
                self.begin(Mode::ShuttingDown);
                self.actions.push(Action::ShutDown(takes));
            }
            _ => {}
        }
    }

    fn begin(&mut self, mode: Mode) {
        self.state.mode = mode;
        self.state.mode_since = self.now();
    }

    /// A manual block comes before everything else; then what runs; a spent
    /// battery before what is only planned.
    fn is_wanted_up(&self) -> bool {
        let now = self.state.now;
        if let Some(block) = self.block_now() {
            return now >= block.until.before(block.wakeup);
        }
        let window = self
            .state
            .windows
            .iter()
            .any(|window| window.awake && window.start <= now && now < window.end);
        window
            || !self.state.running.is_empty()
            || !self.spent && (self.is_timed_up() || self.waits_a_little() || self.naps())
    }

    /// A plan that took over has to be timed first, and nobody does so in sleep.
    fn is_timed_up(&self) -> bool {
        self.is_untimed && self.may_look_again(self.state.now) || self.is_planned_up()
    }

    fn is_planned_up(&self) -> bool {
        let now = self.state.now;
        let mut phases = self.timed.awake.iter();
        phases.any(|phase| {
            phase.wakeup <= now && now < phase.down && self.may_look_again(phase.wakeup)
        })
    }

    /// What is due waits for a device that is still made safe.
    fn waits_a_little(&self) -> bool {
        let tolerance = self.parameters.handover_tolerance;
        let is_close =
            |start: Time| start <= self.state.now && self.state.now.since(start) <= tolerance;
        self.state.mode == Mode::Awake
            && self.blind.is_none()
            && self.planned.values().any(|slot| is_close(slot.start))
    }

    /// A sleep that would be too short is not begun: it was not planned to be.
    fn naps(&self) -> bool {
        if self.state.mode != Mode::Awake || self.blind.is_some() {
            return false;
        }
        let asleep = self.state.now.after(self.parameters.shutdown.duration);
        let wakeups = self.timed.awake.iter().map(|phase| phase.wakeup);
        let next = wakeups.filter(|wakeup| *wakeup > self.state.now).min();
        next.is_some_and(|next| next.since(asleep) < self.parameters.min_sleep)
    }

    /// A heater is on while it is planned to be, and while what is due waits for
    /// its zone.
    pub(super) fn heat(&mut self) {
        if self.is_untimed {
            // Nobody has said yet what is to be heated: it stays as it is.
            return;
        }
        let zones: Vec<_> = self.parameters.zones.iter().map(|zone| zone.name.clone()).collect();
        for zone in zones {
            let on = self.state.heating.contains_key(&zone);
            let can = self.state.mode == Mode::Awake && !self.spent && self.blind.is_none();
            let wanted = can && self.is_to_be_heated(&zone);
            if on == wanted {
                continue;
            }
            if wanted {
                self.state.heating.insert(zone.clone(), self.now());
            } else {
                self.state.heating.remove(&zone);
            }
            self.actions.push(Action::Heat { zone, on: wanted });
        }
    }

    fn is_to_be_heated(&self, zone: &str) -> bool {
        let now = self.state.now;
        let planned = self
            .timed
            .preheats
            .iter()
            .any(|heating| heating.zone == zone && heating.start <= now && now < heating.end);
        planned || !self.is_used(zone) && !self.is_warm(zone) && self.is_waited_for(zone)
    }

    /// A zone in use keeps itself warm.
    fn is_used(&self, zone: &str) -> bool {
        self.state.running.iter().any(|running| self.uses(running.id, zone))
    }

    fn is_waited_for(&self, zone: &str) -> bool {
        self.planned.iter().any(|(id, slot)| slot.start <= self.state.now && self.uses(*id, zone))
    }

    fn uses(&self, id: crate::ActivityId, zone: &str) -> bool {
        self.activity(id).is_some_and(|activity| activity.zones.iter().any(|name| name == zone))
    }

    pub(super) fn is_warm(&self, zone: &str) -> bool {
        self.warm.get(zone).copied().unwrap_or(false)
    }
}
