//! The manager's side of the command ports.

use std::collections::HashMap;
use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::thread::JoinHandle;

use crossbeam::channel::{Sender, unbounded};
use parking_lot::Mutex;

use crate::executive::{Commands, PortFactory, PortNotice, Waker};
use crate::manager::{Attempt, Event};
use crate::port::PortCounts;
use crate::port::connection::pair;
use crate::port::counts::Counting;
use crate::port::entrance::Quiet;
use crate::port::thread::{Order, Reader};
use crate::port::worker::{Line, Tools};

/// The command ports of all attempts.
///
/// Handles are cheap to clone: the bodies have one, to open and to close ports,
/// and the executive another, to hear heartbeats. The last one that goes takes
/// the ports with it.
#[derive(Clone, Debug)]
pub struct CommandServer(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    /// Locked by the manager's thread alone; the lock makes the handles `Sync`.
    lines: Mutex<HashMap<Attempt, Arc<Line>>>,
    orders: Sender<Order>,
    reader: Waker,
    thread: Option<JoinHandle<()>>,
    counts: Arc<Counting>,
}

impl CommandServer {
    /// Starts the thread that reads. Commands are issued through `commands`;
    /// `manager` is rung for heartbeats, and when an attempt has become quiet.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn start(commands: Arc<dyn Commands>, manager: Waker) -> io::Result<Self> {
        let counts = Arc::<Counting>::default();
        let (orders, received) = unbounded();
        let bell = Waker::new()?;
        let tools = Tools { commands, manager, counts: Arc::clone(&counts) };
        let reader = Reader::new(received, bell.clone(), tools)?;
        let thread =
            std::thread::Builder::new().name("faregate-port".into()).spawn(|| reader.run())?;
        let lines = Mutex::default();
        Ok(Self(Arc::new(Shared { lines, orders, reader: bell, thread: Some(thread), counts })))
    }

    /// The heartbeats that came since: one event for each attempt, however
    /// often it beat.
    ///
    /// # Timing
    /// A step for each attempt that runs.
    pub fn poll(&self, events: &mut Vec<Event>) {
        self.0.lines.lock().retain(|attempt, line| {
            if line.beat.take() && !line.entrance.is_closed() {
                events.push(Event::Heartbeat { attempt: *attempt });
            }
            line.entrance.quiet() == Quiet::NotYet
        });
    }

    /// What happened so far.
    #[must_use]
    pub fn counts(&self) -> PortCounts {
        self.0.counts.so_far()
    }
}

impl PortFactory for CommandServer {
    fn open(&mut self, attempt: Attempt) -> io::Result<Option<OwnedFd>> {
        let (ours, theirs) = pair(attempt, &self.0.counts)?;
        let line = Arc::new(Line::new(attempt));
        self.0.lines.lock().insert(attempt, Arc::clone(&line));
        self.0.order(Order::Open(line, ours));
        Ok(Some(theirs))
    }

    fn tell(&mut self, attempt: Attempt, notice: PortNotice) {
        self.0.order(Order::Tell(attempt, notice));
    }

    fn close(&mut self, attempt: Attempt) {
        let mut lines = self.0.lines.lock();
        if let Some(line) = lines.get(&attempt) {
            if line.entrance.close() == Quiet::Now {
                lines.remove(&attempt);
            }
            self.0.order(Order::Close(attempt));
        }
    }

    fn is_quiet(&self, attempt: Attempt) -> bool {
        self.0.lines.lock().get(&attempt).is_none_or(|line| line.entrance.quiet() == Quiet::Now)
    }
}

impl Shared {
    fn order(&self, order: Order) {
        // It is refused only after the reading thread has ended, with this.
        let _ = self.orders.send(order);
        self.reader.wake();
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        for line in self.lines.get_mut().values() {
            let _ = line.entrance.close();
        }
        self.order(Order::End);
        if let Some(thread) = self.thread.take() {
            // It never blocks, so this is soon. A panic of its own has been
            // printed.
            let _ = thread.join();
        }
    }
}
