//! What a run in real time shows: written by a thread of its own.
//!
//! Whoever reads may be slow, or stand still: a terminal does while somebody
//! selects text in it, a pager until a key is pressed. The thread that decides
//! waits for nobody. Lines that nobody takes are counted, and the count is told
//! when there is room again.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use crate::out;

/// How many lines wait to be written. More are counted.
const WAITING: usize = 8192;

/// Writes lines to standard output, in their order.
#[derive(Debug)]
pub(crate) struct Display {
    /// Gone when everything is said.
    lines: Option<SyncSender<String>>,
    lost: u64,
    /// How it is told that so many lines were lost.
    tells_lost: fn(u64) -> String,
    thread: Option<JoinHandle<()>>,
}

impl Display {
    /// A display, which says by `tells_lost` how many lines it could not take.
    ///
    /// # Errors
    /// When the host has no thread left.
    pub(crate) fn new(tells_lost: fn(u64) -> String) -> std::io::Result<Self> {
        let (lines, to_write) = sync_channel(WAITING);
        let thread = std::thread::Builder::new().name("display".into());
        let thread = Some(thread.spawn(move || write(to_write))?);
        Ok(Self { lines: Some(lines), lost: 0, tells_lost, thread })
    }

    /// Has this line written.
    ///
    /// # Timing
    /// Waits for nobody.
    pub(crate) fn line(&mut self, line: String) {
        let Some(lines) = &self.lines else { return };
        if self.lost > 0 && lines.try_send((self.tells_lost)(self.lost)).is_ok() {
            self.lost = 0;
        }
        if self.lost > 0 || matches!(lines.try_send(line), Err(TrySendError::Full(_))) {
            self.lost += 1;
        }
    }
}

/// Until nobody says anything any more, or nobody reads.
fn write(lines: Receiver<String>) {
    for line in lines {
        if out::line(line).is_err() {
            return;
        }
    }
}

/// What was said is written before the program ends.
impl Drop for Display {
    fn drop(&mut self) {
        if let Some(lines) = self.lines.take().filter(|_| self.lost > 0) {
            // At the end there is time for it.
            let _ = lines.send((self.tells_lost)(self.lost));
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
