//! What a manager tells of every change.

use serde_json::Value;

use crate::wire::control::Said;
use crate::{Control, Error};

/// The changes of a schedule, one after the other.
#[derive(Debug)]
pub struct Watch {
    control: Control,
}

/// A change, or what is known of those that were not told.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// A change.
    Note {
        /// When, by the manager's clock that never jumps, in microseconds.
        at_us: u64,
        /// When, by the time of day, in microseconds since 1970.
        unix_us: i64,
        /// The change, as the schedule manager's `Note` writes it.
        note: Value,
    },
    /// So many changes were not told, since this program reads too slowly.
    Lost(u64),
}

impl Watch {
    pub(crate) fn over(control: Control) -> Self {
        Self { control }
    }

    /// Waits for the next change.
    ///
    /// # Errors
    /// [`Error::Closed`] when the manager has stopped.
    pub fn wait(&mut self) -> Result<Change, Error> {
        loop {
            match self.control.hear()? {
                Said::Note { at_us, unix_us, note } => {
                    return Ok(Change::Note { at_us, unix_us, note });
                }
                Said::Lost(count) => return Ok(Change::Lost(count)),
                Said::Hello { .. } | Said::Answer { .. } => {}
            }
        }
    }
}
