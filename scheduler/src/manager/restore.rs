//! Going on where a journal ends.

use crate::manager::admit::Admission;
use crate::manager::point::Present;
use crate::manager::step::Step;
use crate::manager::{Restored, RestoredTask};

impl Step<'_> {
    /// Puts every task back where it was.
    pub(crate) fn restore(&mut self, restored: Restored) {
        self.manager.last = self.now;
        self.manager.next_position = restored.next_position;
        for task in restored.tasks {
            self.restore_task(task);
        }
        for mode in restored.modes {
            // A mode that the mission has no more cannot be in force.
            let _ = self.enter_mode(&mode);
        }
    }

    fn restore_task(&mut self, restored: RestoredTask) {
        let RestoredTask { task, load, position, accepted, held, .. } = restored;
        let wall = accepted.as_micros();
        let ago = self.now.wall.saturating_sub(wall);
        let accepted = Present { elapsed: self.now.elapsed.saturating_sub(ago), wall };
        let index = self.insert(task, Admission { load, position, accepted, held });
        self.begin(index, 0);
    }
}
