//! The flight recorder: bounded lanes from the critical sections, drained into
//! `tracing`.
//!
//! Each gate and each broker writes its own [`RingLane`]. The [`Recorder`] has
//! the other ends, and gives every record to `tracing` as an event with the
//! target `faregate` and the fields `time_us`, `lane`, `ticket` (where one is
//! concerned) and `event`. *Nothing Lost*: what found its lane full is counted
//! and reported.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use faregate_tickets::clock::Instant;
use faregate_tickets::recorder::{Lane, Record, RecordedEvent};
use rtrb::{Consumer, Producer, RingBuffer};
use tracing::Level;

mod draining;

pub use draining::Draining;

/// A bounded lane: the writing end, for one gate or one broker.
#[derive(Debug)]
pub struct RingLane {
    records: Producer<Record>,
    lost: Arc<AtomicUsize>,
}

impl Lane for RingLane {
    /// Keeps the record, or counts that the lane was full.
    ///
    /// # Timing
    /// Constant: a handful of plain loads and stores; no loop, lock,
    /// allocation, system call or atomic read-modify-write.
    fn record(&mut self, record: Record) {
        if self.records.push(record).is_err() {
            // `&mut self` makes this the only writer, so nothing comes between
            // the load and the store. Relaxed: the count says nothing about
            // other memory.
            self.lost.store(self.lost.load(Relaxed).wrapping_add(1), Relaxed);
        }
    }
}

/// The reading ends of all lanes.
#[derive(Debug, Default)]
pub struct Recorder {
    lanes: Vec<Reader>,
}

/// The reading end of one lane.
#[derive(Debug)]
struct Reader {
    name: Box<str>,
    records: Consumer<Record>,
    lost: Arc<AtomicUsize>,
    /// How many of the lost are reported.
    reported: usize,
    /// How many records the present drain still has to take.
    due: usize,
}

/// What one drain found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drained {
    /// Records given to `tracing`.
    pub records: usize,
    /// Records that had found their lane full, since the last drain.
    pub lost: usize,
}

impl Recorder {
    /// A recorder without lanes.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a lane with room for `capacity` records. All its memory is
    /// allocated here.
    ///
    /// A lane does not overflow while its capacity covers what its gate writes
    /// between two drains.
    pub fn lane(&mut self, name: impl Into<Box<str>>, capacity: usize) -> RingLane {
        let (writer, records) = RingBuffer::new(capacity);
        let lost = Arc::new(AtomicUsize::new(0));
        self.lanes.push(Reader {
            name: name.into(),
            records,
            lost: Arc::clone(&lost),
            reported: 0,
            due: 0,
        });
        RingLane { records: writer, lost }
    }

    /// Gives every record that is there now to `tracing`, across the lanes in
    /// the order of their instants; then says what was lost.
    ///
    /// Lanes that go on being written do not keep it: what arrives meanwhile
    /// is for the next drain.
    ///
    /// # Timing
    /// Not for a real-time thread: the subscriber does what it likes.
    pub fn drain(&mut self) -> Drained {
        for lane in &mut self.lanes {
            lane.due = lane.records.slots();
        }
        let mut drained = Drained::default();
        while let Some(lane) = self.with_earliest() {
            lane.emit_next();
            drained.records += 1;
        }
        drained.lost = self.lanes.iter_mut().map(Reader::report_lost).sum();
        drained
    }

    /// The lane whose next due record is the earliest; of equals the first.
    fn with_earliest(&mut self) -> Option<&mut Reader> {
        let heads = self.lanes.iter_mut().filter_map(|lane| Some((lane.next_at()?, lane)));
        heads.min_by_key(|(at, _)| *at).map(|(_, lane)| lane)
    }
}

impl Reader {
    fn next_at(&self) -> Option<Instant> {
        if self.due == 0 {
            return None;
        }
        self.records.peek().ok().map(|record| record.at)
    }

    fn emit_next(&mut self) {
        self.due -= 1;
        if let Ok(record) = self.records.pop() {
            emit(&self.name, &record);
        }
    }

    /// Reports the losses since the last report, and says how many.
    fn report_lost(&mut self) -> usize {
        let total = self.lost.load(Relaxed);
        let lost = total.wrapping_sub(self.reported);
        self.reported = total;
        if lost > 0 {
            tracing::warn!(target: "faregate", lane = &*self.name, lost, "{}", Lost(lost, &self.name));
        }
        lost
    }
}

struct Lost<'a>(usize, &'a str);

impl fmt::Display for Lost<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(n, lane) = self;
        write!(f, "{n} record{} lost in lane {lane}", if *n == 1 { "" } else { "s" })
    }
}

/// How notable an event is: what needs somebody's attention, what changed, and
/// the traffic of every command and hand-over. What this crate does not know yet
/// counts as a change, where somebody sees it.
fn severity(event: &RecordedEvent) -> Level {
    use RecordedEvent::*;
    match event {
        Closed(_) | Faulted { .. } | Stuck { .. } => Level::ERROR,
        SafeMode { .. } | ClockWentBack => Level::WARN,
        Issued { .. } | Admitted { .. } | Vacated { .. } => Level::DEBUG,
        Requested { .. } | Relinquished | SeenOff { .. } => Level::DEBUG,
        _ => Level::INFO,
    }
}

fn emit(lane: &str, record: &Record) {
    // `tracing` wants the level of an event as a constant.
    macro_rules! at {
        ($level:expr) => {
            tracing::event!(
                target: "faregate",
                $level,
                time_us = record.at.as_micros(),
                lane,
                ticket = (record.ticket != 0).then_some(record.ticket),
                event = ?record.event,
            )
        };
    }
    match severity(&record.event) {
        Level::ERROR => at!(Level::ERROR),
        Level::WARN => at!(Level::WARN),
        Level::INFO => at!(Level::INFO),
        Level::DEBUG => at!(Level::DEBUG),
        Level::TRACE => at!(Level::TRACE),
    }
}
