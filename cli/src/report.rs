//! What is wrong with files, told.

use faregate_scheduler::format::Diagnostic;

use crate::out;
use crate::schedule::Source;

/// On standard error, for people.
pub(crate) fn complain(diagnostics: &[Diagnostic], _sources: &[Source]) {
    for diagnostic in diagnostics {
        out::complain(diagnostic);
    }
}
