//! Where records go.

use std::io;

use crate::executive::{JournalSink, Unwritten};
use crate::journal::Journal;
use crate::manager::Record;

/// Where records go: to a journal, or nowhere.
#[derive(Debug)]
pub enum Kept {
    /// To this journal.
    Journal(Box<Journal>),
    /// Nothing outlives this run.
    Nowhere(Unwritten),
}

impl Kept {
    fn sink(&mut self) -> &mut dyn JournalSink {
        match self {
            Self::Journal(journal) => &mut **journal,
            Self::Nowhere(nowhere) => nowhere,
        }
    }
}

impl JournalSink for Kept {
    fn append(&mut self, record: &Record) -> io::Result<()> {
        self.sink().append(record)
    }

    fn commit(&mut self) -> io::Result<()> {
        self.sink().commit()
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sink().sync()
    }
}
