//! Opens a journal although something of a dead manager still has its lock.

use std::path::Path;

use crate::bodies::{Swept, end_left};
use crate::journal::{Journal, JournalError, Opened, Options};
use crate::manager::Restored;

/// Opens the journal. A child that was frozen as it was forked has its
/// manager's lock, and outlives it: it has executed nothing yet, so nothing in
/// it has asked to die with the manager. It is ended as all leftovers are, and
/// answered with them.
///
/// Not before somebody is known to have the lock: what else is left is ended
/// when devices are safe.
///
/// # Errors
/// The journal's. That it is in use, if its manager lives or had left nothing.
pub(super) fn open(
    directory: &Path,
    state: &Path,
) -> Result<(Journal, Restored, Opened, Vec<Swept>), JournalError> {
    let mut swept = Vec::new();
    let opened = match Journal::open(directory, Options::default()) {
        Err(in_use @ JournalError::InUse { .. }) => {
            swept = end_left(state).unwrap_or_default();
            if swept.is_empty() {
                return Err(in_use);
            }
            Journal::open(directory, Options::default())
        }
        opened => opened,
    };
    opened.map(|(journal, restored, opened)| (journal, restored, opened, swept))
}
