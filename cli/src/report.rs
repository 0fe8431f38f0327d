//! What is wrong with files, told.

use std::io::IsTerminal;

use faregate_scheduler::format::{self, Diagnostic};

use crate::out;
use crate::schedule::Source;

/// On standard error, for people: each with its line.
pub(crate) fn complain(diagnostics: &[Diagnostic], sources: &[Source]) {
    let colour = std::io::stderr().is_terminal();
    for source in sources {
        let found: Vec<Diagnostic> =
            diagnostics.iter().filter(|one| one.file == source.name).cloned().collect();
        if !found.is_empty() {
            out::complain(format::render(&found, &source.bytes, colour).trim_end());
        }
    }
}
