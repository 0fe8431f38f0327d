//! Every change at a running manager.

use faregate_client::{Change, Error};
use faregate_scheduler::manager::Note;
use serde_json::json;

use crate::args::{Format, WatchArgs};
use crate::changes::{self, Changes};
use crate::exit::{Exit, Failure};
use crate::out;

pub(crate) fn watch(args: &WatchArgs) -> Result<Exit, Failure> {
    let mut watch = args.socket.connect()?.watch()?;
    let mut changes = Changes::default();
    loop {
        match watch.wait() {
            Ok(change) => tell(args.format, &change, &mut changes)?,
            // The manager has ended: that is the last change.
            Err(Error::Closed) => return Ok(Exit::Done),
            Err(error) => return Err(error.into()),
        }
    }
}

fn tell(format: Format, change: &Change, changes: &mut Changes) -> Result<(), Failure> {
    match (format, change) {
        (Format::Json, Change::Note { at_us, unix_us, note }) => {
            out::json_line(&json!({ "at_us": at_us, "unix_us": unix_us, "note": note }))?;
        }
        (Format::Json, Change::Lost(count)) => out::json_line(&json!({ "lost": count }))?,
        (Format::Text, Change::Note { at_us, note, .. }) => {
            match serde_json::from_value::<Note>(note.clone()) {
                Ok(note) => changes.told(*at_us, &note).map_or(Ok(()), out::line)?,
                // A manager of a later version: better raw than not at all.
                Err(_) => out::line(note)?,
            }
        }
        (Format::Text, Change::Lost(count)) => out::line(changes::lost(*count))?,
    }
    Ok(())
}
