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
            self.renew_stale();
            self.walk();
            self.stand_back();
            if !self.start_granted() {
                break;
            }
        }
        // What can start has started before anything else is asked for.
        self.ask();
        self.pre_empt_the_rest();
        self.arm();
    }
}
