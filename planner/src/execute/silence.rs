//! When nobody knows the charge.
//!
//! What the control thread sees of the charge is late and wrong by a little, and
//! limits are judged by it. When the gauge is silent it would be later and later,
//! and nothing would be aborted at the hard limit any more. So an estimate holds
//! for a time, and then the charge counts as the worst that it can be.

use super::Control;
use crate::state::Mode;
use crate::units::Time;

impl Control {
    /// Asked when everything that happened at this instant is known: who has
    /// just come up has looked around by then.
    pub(super) fn notice_silence(&mut self) {
        let has_just_come_up = std::mem::take(&mut self.looks_around);
        if self.state.mode != Mode::Awake || self.charge_is_known() {
            return;
        }
        if has_just_come_up || self.blind.is_none() {
            self.blind = Some(self.state.now);
        }
    }

    pub(super) fn charge_is_known(&self) -> bool {
        self.state.now < self.charge_is_known_until()
    }

    pub(super) fn charge_is_known_until(&self) -> Time {
        self.estimated_at.after(self.options.charge_holds)
    }

    /// Whether the computer may be woken then: to look around again, after a
    /// sleep that is worth it. Who has just come up looks around first.
    pub(super) fn may_look_again(&self, wakeup: Time) -> bool {
        let rested = || self.looks_again_from().is_some_and(|rested| rested <= wakeup);
        self.blind.is_none() || self.looks_around || rested()
    }

    pub(super) fn looks_again_from(&self) -> Option<Time> {
        let sleeps = self.state.mode == Mode::Asleep && self.blind.is_some();
        sleeps.then(|| self.state.mode_since.after(self.parameters.min_sleep))
    }
}
