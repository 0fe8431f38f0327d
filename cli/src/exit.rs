//! How the program ends.

use std::fmt::Write as _;
use std::io;

use faregate_client::Error;
pub(crate) use faregate_client::exit::Exit;

/// Why a sub-command did not come to its end.
#[derive(Debug)]
pub(crate) enum Failure {
    /// It ends with this code, and this is why.
    Because(Exit, String),
    /// It has said everything already.
    Said(Exit),
    /// Whoever read the output has gone: nothing more is said.
    NobodyReads,
}

impl Failure {
    /// Something that is not a refusal, and not a mistake in a schedule.
    pub(crate) fn failed(why: impl Into<String>) -> Self {
        Self::Because(Exit::Failed, why.into())
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Because(Exit::from(&error), error.to_string())
    }
}

/// Only the output is written with `?`: files say which one it was.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::NobodyReads,
            _ => Self::failed(format!("the output cannot be written: {error}")),
        }
    }
}

/// The exit codes, for `--help`.
pub(crate) fn table() -> String {
    let mut table = String::from("Exit codes:\n");
    for (exit, meaning) in Exit::ALL {
        // Writing to a string does not fail.
        let _ = writeln!(table, "  {:>2}  {meaning}", exit.code());
    }
    table
}
