//! The decision: who runs is found out, and made so.

use crate::manager::step::Step;

impl Step<'_> {
    /// Takes one decision. What the manager does by itself can change what it
    /// stands on; then another one follows at once.
    pub(crate) fn decide(&mut self) {
        loop {
            self.ring_timers();
            self.bury();
            self.manager.classes.advance(self.now);
            self.walk();
            self.stand_back();
            self.ask();
            self.pre_empt_the_rest();
            if !self.start_granted() {
                break;
            }
        }
        self.arm();
    }
}
