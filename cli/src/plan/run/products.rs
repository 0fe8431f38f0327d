//! `plan run --products`: what an execution leaves, in a directory.

use std::fs;
use std::io;
use std::path::Path;

use faregate_planner::Trace;
use faregate_planner::products;
use faregate_rehearsal::Setup;

use crate::disk;
use crate::exit::Failure;

/// Who has executed it.
const PROGRAM: &str = concat!("faregate ", env!("CARGO_PKG_VERSION"));

/// Refuses a directory in which something is: what is left of another execution
/// would be taken for a part of this one.
pub(super) fn is_free(directory: &Path) -> Result<(), Failure> {
    let why = match fs::read_dir(directory).map(|mut there| there.next().is_none()) {
        Ok(true) => return Ok(()),
        Ok(false) => "it is not empty: name another directory".to_owned(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(_) if directory.exists() && !directory.is_dir() => "it is no directory".to_owned(),
        Err(error) => error.to_string(),
    };
    Err(not_left(directory, &why))
}

/// Writes them all.
pub(super) fn write(directory: &Path, setup: &Setup, trace: &Trace) -> Result<(), Failure> {
    let all = products::of(&setup.plan, &setup.parameters, trace, PROGRAM);
    for product in all.map_err(|why| not_left(directory, &why.to_string()))? {
        let path = directory.join(&product.name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(|error| not_left(parent, &error.to_string()))?;
        }
        disk::write(&path, product.content)?;
    }
    Ok(())
}

fn not_left(directory: &Path, why: &str) -> Failure {
    Failure::failed(format!("products cannot be left in {}: {why}", directory.display()))
}
