//! Compaction: what a log adds up to replaces it.
//!
//! 1. The next log is made, empty, with its name durable.
//! 2. After a sync, the writer goes on there: nothing of the old log is not
//!    durable.
//! 3. The old log is added to the snapshot before it, from the files, and the
//!    sum is written as a new snapshot.
//! 4. When that is durable, the old log and the old snapshot are removed.
//!
//! The manager's thread does the second step alone, which is an assignment: it
//! waits for nothing that it would not have waited for anyway. Whatever stops
//! the rest, the files that are there are the journal: a snapshot counts when
//! its last entry is there, and logs go when it is durable.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use crate::journal::entry::Entry;
use crate::journal::frame;
use crate::journal::open::{self, Found};
use crate::journal::points::{self, Point};
use crate::journal::segment::{HEAD, Segment};
use crate::journal::storage::{Storage, StoredFile};
use crate::journal::sum::add_up;
use crate::journal::writer::{EmptyLog, encode};
use crate::journal::{Compaction, JournalError, Options};

/// How long a frame of a snapshot becomes, about.
const FRAME: usize = 64 << 10;

/// Decides when to compact, and has it done.
#[derive(Debug)]
pub(super) struct Compactor {
    above: u64,
    options: Options,
    worker: Worker,
    state: State,
    done: u64,
}

/// What is to be done after a sync.
#[derive(Debug)]
pub(super) enum Step {
    Nothing,
    /// Go on in this log, and say [`Compactor::switched`].
    Switch(EmptyLog),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Idle,
    /// The next log is being made.
    Preparing,
    /// Logs up to this one are to be compacted, or are being compacted.
    Compacting(u64),
}

impl Compactor {
    pub(super) fn new(storage: &Arc<dyn Storage>, options: Options, snapshot: u64) -> Self {
        let worker = match options.compaction {
            Compaction::Background => Worker::start(storage),
            Compaction::Inline => Worker::Here(Arc::clone(storage), None),
            Compaction::Never => Worker::None,
        };
        let mut compactor = Self { above: 0, options, worker, state: State::Idle, done: 0 };
        compactor.next_above(snapshot);
        compactor
    }

    pub(super) const fn done(&self) -> u64 {
        self.done
    }

    /// After a sync, with the log this long.
    pub(super) fn step(&mut self, log: u64) -> Step {
        match self.state {
            State::Idle if log > self.above => {
                if self.worker.ask(Order::Prepare) {
                    self.state = State::Preparing;
                }
            }
            State::Idle => return Step::Nothing,
            State::Preparing | State::Compacting(_) => {}
        }
        match self.worker.answer() {
            None => Step::Nothing,
            Some(Answer::Prepared(next)) => {
                self.state = State::Compacting(next.segment.number - 1);
                Step::Switch(next)
            }
            Some(Answer::Compacted { bytes }) => {
                self.done += 1;
                self.next_above(bytes);
                self.state = State::Idle;
                Step::Nothing
            }
            Some(Answer::Failed(error)) => {
                tracing::warn!(%error, "the journal cannot be compacted; it goes on growing");
                self.next_above(log);
                self.state = State::Idle;
                Step::Nothing
            }
        }
    }

    /// The writer is in the next log.
    pub(super) fn switched(&mut self) {
        if let State::Compacting(up_to) = self.state {
            self.worker.ask(Order::Compact(up_to));
        }
    }

    fn next_above(&mut self, left: u64) {
        self.above = self.options.compact_above.max(left.saturating_mul(2));
    }
}

#[derive(Debug)]
enum Order {
    Prepare,
    /// All logs up to this one.
    Compact(u64),
}

#[derive(Debug)]
enum Answer {
    Prepared(EmptyLog),
    Compacted { bytes: u64 },
    Failed(JournalError),
}

/// Who does the slow part.
#[derive(Debug)]
enum Worker {
    Thread {
        orders: Option<Sender<Order>>,
        answers: Receiver<Answer>,
        thread: Option<JoinHandle<()>>,
    },
    Here(Arc<dyn Storage>, Option<Answer>),
    None,
}

impl Worker {
    fn start(storage: &Arc<dyn Storage>) -> Self {
        let (orders, to_do) = channel();
        let (results, answers) = channel();
        let storage = Arc::clone(storage);
        let work = move || {
            for order in to_do {
                if results.send(carry_out(&*storage, order)).is_err() {
                    break;
                }
            }
        };
        match std::thread::Builder::new().name("journal".into()).spawn(work) {
            Ok(thread) => Self::Thread { orders: Some(orders), answers, thread: Some(thread) },
            Err(error) => {
                tracing::warn!(%error, "no thread to compact the journal with; it goes on growing");
                Self::None
            }
        }
    }

    fn ask(&mut self, order: Order) -> bool {
        match self {
            Self::Thread { orders: Some(orders), .. } => orders.send(order).is_ok(),
            Self::Here(storage, answer) => {
                *answer = Some(carry_out(&**storage, order));
                true
            }
            Self::Thread { orders: None, .. } | Self::None => false,
        }
    }

    fn answer(&mut self) -> Option<Answer> {
        match self {
            Self::Thread { answers, .. } => answers.try_recv().ok(),
            Self::Here(_, answer) => answer.take(),
            Self::None => None,
        }
    }
}

impl Drop for Worker {
    /// The next one who opens the journal must not meet this one's worker.
    fn drop(&mut self) {
        if let Self::Thread { orders, thread, .. } = self {
            *orders = None;
            if let Some(thread) = thread.take() {
                // A worker that panicked has left files that count for nothing.
                let _ = thread.join();
            }
        }
    }
}

fn carry_out(storage: &dyn Storage, order: Order) -> Answer {
    let result = match order {
        Order::Prepare => prepare(storage).map(Answer::Prepared),
        Order::Compact(up_to) => compact(storage, up_to).map(|bytes| Answer::Compacted { bytes }),
    };
    result.unwrap_or_else(Answer::Failed)
}

fn prepare(storage: &dyn Storage) -> Result<EmptyLog, JournalError> {
    let found = Found::list(storage)?;
    open::empty_log(storage, Segment::log(found.last_log().unwrap_or(0) + 1))
}

fn compact(storage: &dyn Storage, up_to: u64) -> Result<u64, JournalError> {
    let found = Found::list(storage)?;
    let sum = add_up(storage, &found, up_to)?;
    let snapshot = Segment::snapshot(up_to);
    let written = write_snapshot(storage, snapshot, sum.replay.entries());
    let bytes = written.inspect_err(|_| {
        // Half of one counts for nothing, and a full disk has no room for it. If
        // it cannot be removed, either, it goes with what the next one replaces.
        let _ = storage.remove(&snapshot.name());
    })?;
    points::hit(Point::AfterSnapshot);
    found.remove_up_to(storage, up_to)?;
    Ok(bytes)
}

pub(super) fn write_snapshot(
    storage: &dyn Storage,
    segment: Segment,
    entries: impl Iterator<Item = Entry>,
) -> Result<u64, JournalError> {
    let name = segment.name();
    let mut file = storage.create(&name).map_err(JournalError::storage("making", &name))?;
    let written = write_frames(&mut *file, segment, entries)?;
    file.sync().map_err(JournalError::storage("syncing", &name))?;
    storage.sync_names().map_err(JournalError::storage("syncing the name of", &name))?;
    Ok(written)
}

fn write_frames(
    file: &mut dyn StoredFile,
    segment: Segment,
    entries: impl Iterator<Item = Entry>,
) -> Result<u64, JournalError> {
    let name = segment.name();
    file.write(&segment.head()).map_err(JournalError::storage("writing", &name))?;
    let mut written = u64::try_from(HEAD).unwrap_or(u64::MAX);
    let mut entries = entries.peekable();
    let mut batch = vec![0; frame::HEAD];
    while let Some(entry) = entries.next() {
        if !encode(&entry, &mut batch) {
            return Err(JournalError::TooLong { bytes: batch.len() });
        }
        if batch.len() < FRAME && entries.peek().is_some() {
            continue;
        }
        points::hit(Point::InsideSnapshot);
        frame::seal(&mut batch, segment.identity(), written, 0);
        file.write(&batch).map_err(JournalError::storage("writing", &name))?;
        written += u64::try_from(batch.len()).unwrap_or(u64::MAX);
        batch.truncate(frame::HEAD);
    }
    Ok(written)
}
