//! Files of the planner: opened, read, complained about.

use std::path::Path;

use faregate_planner::Parameters;
use faregate_planner::file::{self, Document, Loaded, binary};
use faregate_scheduler::format::Diagnostic;

use crate::exit::{Exit, Failure};
use crate::report;
use crate::schedule::Source;

/// The same with nothing to show where the file is not text.
pub(super) fn shown(source: Source) -> Source {
    match binary::is_binary(&source.bytes) {
        true => Source { bytes: Vec::new(), ..source },
        false => source,
    }
}

/// Reads a file; what is wrong with it is told, and ends the program with this
/// code.
pub(super) fn read<T>(
    path: &Path,
    exit: Exit,
    read: impl FnOnce(&str, &[u8]) -> Result<Loaded<T>, Vec<Diagnostic>>,
) -> Result<T, Failure> {
    let source = Source::open(path)?;
    match read(&source.name, &source.bytes) {
        Ok(Loaded { value, warnings }) => {
            report::complain(&warnings, &[shown(source)]);
            Ok(value)
        }
        Err(found) => {
            report::complain(&found, &[shown(source)]);
            Err(Failure::Said(exit))
        }
    }
}

/// Reads the parameters, where they are given.
pub(super) fn parameters(path: Option<&Path>, exit: Exit) -> Result<Option<Parameters>, Failure> {
    path.map(|path| read(path, exit, file::parameters)).transpose()
}

/// Reads whatever there is in a file.
pub(super) fn document(
    path: &Path,
    parameters: Option<&Parameters>,
    exit: Exit,
) -> Result<Document, Failure> {
    read(path, exit, |name, bytes| file::read(name, bytes, parameters))
}
