//! Files that are read and written, with an answer for each that cannot be.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

use faregate_scheduler::control::MAX_FILE;

use crate::exit::{Exit, Failure};

/// The whole of a file. One without an end, such as `/dev/zero`, would fill the
/// memory: what a task cannot load is too long here, too.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, String> {
    let name = path.display();
    let read = || -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        File::open(path)?.take(MAX_FILE + 1).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let bytes = read().map_err(|error| format!("{name} cannot be read: {error}"))?;
    match u64::try_from(bytes.len()) {
        Ok(length) if length <= MAX_FILE => Ok(bytes),
        _ => Err(format!("{name} cannot be read: it is longer than {} MiB", MAX_FILE >> 20)),
    }
}

/// Writes a file, over what is there.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    fs::write(path, content).map_err(|error| not_written(path, &error.to_string()))
}

/// Says before long work that its result could not be written, as far as that
/// can be seen without writing.
pub(crate) fn can_be_written(path: &Path) -> Result<(), Failure> {
    let directory = path.parent().filter(|directory| !directory.as_os_str().is_empty());
    if let Some(directory) = directory.filter(|directory| !directory.is_dir()) {
        let why = format!("there is no directory {}", directory.display());
        return Err(not_written(path, &why));
    }
    if path.is_dir() {
        return Err(not_written(path, "it is a directory"));
    }
    // To open a pipe would wait for its reader.
    if path.is_file() {
        let opened = OpenOptions::new().write(true).open(path);
        opened.map_err(|error| not_written(path, &error.to_string()))?;
    }
    Ok(())
}

fn not_written(path: &Path, why: &str) -> Failure {
    Failure::failed(format!("{} cannot be written: {why}", path.display()))
}

/// Refuses to write a file in another form over itself: comments would be lost,
/// and whatever else the other form has no place for.
pub(crate) fn are_two(from: &Path, to: &Path) -> Result<(), Failure> {
    let same = fs::canonicalize(from).ok().zip(fs::canonicalize(to).ok());
    match same.is_some_and(|(from, to)| from == to) {
        true => Err(Failure::Because(
            Exit::Usage,
            format!("{} would be written over itself: name another file", to.display()),
        )),
        false => Ok(()),
    }
}
