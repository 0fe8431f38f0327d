//! The flight recorder: one tape for all lanes, since one core writes at a time.

use core::cell::RefCell;

use critical_section::Mutex;
use faregate_tickets::recorder::{Lane, Record};

/// Whose lane a record came in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    Broker,
    Camera,
    Valve,
}

/// A record, or several alike that followed each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) source: Source,
    pub(crate) record: Record,
}

/// What happened since the tape was rewound.
#[derive(Clone, Debug)]
pub(crate) struct Tape {
    running: bool,
    pub(crate) entries: heapless::Vec<Entry, 48>,
    pub(crate) lost: u32,
}

static TAPE: Mutex<RefCell<Tape>> =
    Mutex::new(RefCell::new(Tape { running: false, entries: heapless::Vec::new(), lost: 0 }));

/// Begins a new tape.
pub(crate) fn rewind() {
    critical_section::with(|masked| {
        *TAPE.borrow_ref_mut(masked) =
            Tape { running: true, entries: heapless::Vec::new(), lost: 0 };
    });
}

/// Ends the tape and shows it.
pub(crate) fn stop<R>(f: impl FnOnce(&Tape) -> R) -> R {
    critical_section::with(|masked| TAPE.borrow_ref_mut(masked).running = false);
    // Nobody writes any more, so whoever reads may take the time.
    critical_section::with(|masked| f(&TAPE.borrow_ref(masked)))
}

/// One lane of the tape.
#[derive(Debug)]
pub(crate) struct TapeLane(pub(crate) Source);

impl Lane for TapeLane {
    fn record(&mut self, record: Record) {
        critical_section::with(|masked| TAPE.borrow_ref_mut(masked).add(self.0, record));
    }
}

impl Tape {
    fn add(&mut self, source: Source, record: Record) {
        let same = |last: &Entry| {
            (last.source, last.record.ticket, last.record.event)
                == (source, record.ticket, record.event)
        };
        if !self.running || self.entries.last().is_some_and(same) {
            return;
        }
        if self.entries.push(Entry { source, record }).is_err() {
            self.lost += 1;
        }
    }
}
