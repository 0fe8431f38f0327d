//! The Unix socket, seen from the manager's thread.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::thread::JoinHandle;

use crossbeam::channel::{Receiver, Sender, bounded, unbounded};
use faregate_client::Refused;
use faregate_client::wire::control::Answer;

use crate::control::listen::Listening;
use crate::control::thread::{Server, Tools};
use crate::control::{AskId, Asked, Link, MAX_CLIENTS, MAX_NOTES};
use crate::executive::Waker;
use crate::manager::Note;
use crate::task::Task;
use crate::time::Now;

/// Reads schedules: the formats, with the mission's names.
pub trait ReadSchedule: Send + Sync {
    /// The tasks of a schedule. The name's ending tells the format.
    ///
    /// # Errors
    /// Every mistake in it, at once.
    fn read(&self, name: &str, text: &str) -> Result<Vec<Task>, Refused>;
}

impl<F: Fn(&str, &str) -> Result<Vec<Task>, Refused> + Send + Sync> ReadSchedule for F {
    fn read(&self, name: &str, text: &str) -> Result<Vec<Task>, Refused> {
        self(name, text)
    }
}

/// What the socket's thread is told.
#[derive(Debug)]
pub(super) enum Told {
    Answer(AskId, Answer),
    End,
}

/// A manager's control port at a path. Its socket goes when this goes.
#[derive(Debug)]
pub struct SocketLink {
    asked: Receiver<Asked>,
    told: Sender<Told>,
    notes: Sender<(Now, Note)>,
    bell: Waker,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What both threads count.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// How many clients watch.
    pub(super) watchers: AtomicUsize,
    /// Changes that found the queue full and were not told to anybody yet.
    pub(super) lost: AtomicU64,
    pub(super) clients: AtomicU64,
    pub(super) turned_away: AtomicU64,
    pub(super) malformed: AtomicU64,
}

/// What happened at the control port so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ControlCounts {
    /// Clients that were let in.
    pub clients: u64,
    /// Clients that were not: other users, or too many at a time.
    pub turned_away: u64,
    /// Lines that were no message.
    pub malformed: u64,
}

impl SocketLink {
    /// Listens at this path, and rings the manager's bell when something is
    /// asked. Schedules are read by the link's own thread.
    ///
    /// # Errors
    /// [`io::ErrorKind::AddrInUse`] if another manager listens there,
    /// [`io::ErrorKind::AlreadyExists`] if there is a file that is no socket,
    /// and what else the operating system says.
    pub fn listen(
        path: impl AsRef<Path>,
        schedules: Arc<dyn ReadSchedule>,
        manager: Waker,
    ) -> io::Result<Self> {
        let listening = Listening::at(path.as_ref())?;
        // Each client asks one thing at a time: this is full only where many
        // have asked and gone before the manager looked.
        let (asks, asked) = bounded(MAX_CLIENTS);
        let (told, hears) = unbounded();
        let (notes, changes) = bounded(MAX_NOTES);
        let (bell, shared) = (Waker::new()?, Arc::<Shared>::default());
        let tools = Tools { asks, hears, changes, schedules, manager, shared: Arc::clone(&shared) };
        let server = Server::new(listening, bell.clone(), tools)?;
        let thread =
            std::thread::Builder::new().name("faregate-control".into()).spawn(|| server.run())?;
        Ok(Self { asked, told, notes, bell, shared, thread: Some(thread) })
    }

    /// What happened so far.
    #[must_use]
    pub fn counts(&self) -> ControlCounts {
        ControlCounts {
            clients: self.shared.clients.load(Relaxed),
            turned_away: self.shared.turned_away.load(Relaxed),
            malformed: self.shared.malformed.load(Relaxed),
        }
    }

    fn tell(&self, told: Told) {
        // It is refused only after the thread has ended.
        let _ = self.told.send(told);
        self.bell.wake();
    }
}

impl Link for SocketLink {
    fn poll(&mut self, _: Now, asked: &mut Vec<Asked>) {
        asked.extend(self.asked.try_iter());
    }

    fn answer(&mut self, _: Now, to: AskId, answer: Answer) {
        self.tell(Told::Answer(to, answer));
    }

    fn note(&mut self, now: Now, note: &Note) {
        if self.shared.watchers.load(Relaxed) == 0 {
            return;
        }
        if self.notes.try_send((now, note.clone())).is_err() {
            self.shared.lost.fetch_add(1, Relaxed);
        }
        self.bell.wake();
    }
}

impl Drop for SocketLink {
    /// What was answered is sent first, as far as clients take it.
    fn drop(&mut self) {
        self.tell(Told::End);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
