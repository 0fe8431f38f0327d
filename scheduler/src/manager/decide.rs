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
        let about_to_start = self.ask();
        self.pre_empt_the_rest();
        self.disarm_the_late();
        // To arm takes a disk's time. Who is about to start does not wait for
        // it: its grant is an event, and whoever comes next is armed then.
        if !about_to_start {
            self.arm();
        }
    }
}
