//! What the manager can do by itself, as the body of a task.

use crate::manager::step::Step;
use crate::manager::{Attempt, Exit};
use crate::task::BuiltIn;

impl Step<'_> {
    /// Does it at once: the attempt is over when this returns.
    pub(crate) fn build_in(&mut self, attempt: Attempt, built_in: BuiltIn) {
        let own = self.manager.named(attempt.occurrence);
        let done = match built_in {
            BuiltIn::Clear { all } => {
                self.clear(all, own);
                Ok(())
            }
            BuiltIn::Remove(ids) => self.remove(&ids),
            BuiltIn::EnterMode(name) => self.enter_mode(&name),
            BuiltIn::LeaveMode(name) => self.leave_mode(&name),
            // The executive reads files.
            BuiltIn::Load(path) => Err(format!("{path} was not loaded")),
        };
        let exit = done.map_or_else(Exit::Failed, |()| Exit::Code(0));
        self.exited(attempt, exit);
    }
}
