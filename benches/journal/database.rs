//! The same records in `redb`, each under its number.

use std::path::Path;

use faregate_scheduler::manager::Record;
use redb::{Database, Durability, ReadableDatabase, ReadableTable, TableDefinition};

use crate::support::Failure;

const RECORDS: TableDefinition<'_, u64, &[u8]> = TableDefinition::new("records");

/// When a commit counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Commit {
    /// With the next one that is durable: `kill -9` takes it away.
    Volatile,
    /// At once; after a crash the whole file is walked.
    Durable,
    /// At once, and what the next opening needs is saved with it.
    QuickRepair,
}

/// A log in a database.
#[derive(Debug)]
pub(crate) struct Log {
    database: Database,
    next: u64,
}

impl Log {
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        Ok(Self { database: Database::create(path)?, next: 0 })
    }

    pub(crate) fn write(&mut self, records: &[Record], commit: Commit) -> Result<(), Failure> {
        let mut transaction = self.database.begin_write()?;
        match commit {
            Commit::Volatile => transaction.set_durability(Durability::None)?,
            Commit::Durable => {}
            Commit::QuickRepair => transaction.set_quick_repair(true),
        }
        {
            let mut table = transaction.open_table(RECORDS)?;
            for record in records {
                table.insert(self.next, &*postcard::to_stdvec(record)?)?;
                self.next += 1;
            }
        }
        Ok(transaction.commit()?)
    }

    /// Everything that was written, in order.
    pub(crate) fn read(&self) -> Result<Vec<Record>, Failure> {
        let transaction = self.database.begin_read()?;
        let table = transaction.open_table(RECORDS)?;
        let mut records = Vec::new();
        for entry in table.iter()? {
            records.push(postcard::from_bytes(entry?.1.value())?);
        }
        Ok(records)
    }
}
