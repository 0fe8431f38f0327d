//! A lane that the test can read, of bounded length if it wants.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};

use faregate_tickets::recorder::{Lane, Record, RecordedEvent};

#[derive(Debug)]
pub(crate) struct Tape {
    records: Mutex<Vec<Record>>,
    /// How many records it takes.
    pub(crate) room: AtomicUsize,
    /// How many it could not keep.
    pub(crate) lost: AtomicUsize,
    /// Whoever records an admission stops until this is false.
    pub(crate) hold_admission: AtomicBool,
    /// Somebody has been stopped.
    pub(crate) held: AtomicBool,
}

impl Default for Tape {
    fn default() -> Self {
        Self {
            records: Mutex::default(),
            room: AtomicUsize::new(usize::MAX),
            lost: AtomicUsize::new(0),
            hold_admission: AtomicBool::new(false),
            held: AtomicBool::new(false),
        }
    }
}

impl Tape {
    pub(crate) fn records(&self) -> Vec<Record> {
        self.records.lock().unwrap().clone()
    }

    pub(crate) fn events(&self) -> Vec<RecordedEvent> {
        self.records().iter().map(|record| record.event).collect()
    }

    /// What was recorded of a ticket.
    pub(crate) fn events_of(&self, serial: usize) -> Vec<RecordedEvent> {
        let records = self.records();
        records.iter().filter(|record| record.ticket == serial).map(|record| record.event).collect()
    }

    pub(crate) fn rewind(&self) {
        self.records.lock().unwrap().clear();
    }
}

impl Lane for &'static Tape {
    fn record(&mut self, record: Record) {
        if let RecordedEvent::Admitted { .. } = record.event {
            self.held.store(self.hold_admission.load(SeqCst), SeqCst);
            while self.hold_admission.load(SeqCst) {
                std::thread::yield_now();
            }
        }
        let mut records = self.records.lock().unwrap();
        if records.len() < self.room.load(SeqCst) {
            records.push(record);
        } else {
            self.lost.fetch_add(1, SeqCst);
        }
    }
}
