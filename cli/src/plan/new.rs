//! `plan new`: something to begin with.

use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::Path;

use faregate_planner::file::template;

use crate::args::{PlanNewArgs, TemplateName};
use crate::exit::{Exit, Failure};
use crate::out;

pub(crate) fn new(args: &PlanNewArgs) -> Result<Exit, Failure> {
    let text = match args.template {
        TemplateName::Plan => template::PLAN,
        TemplateName::Parameters => template::PARAMETERS,
        TemplateName::State => template::STATE,
    };
    match &args.out {
        Some(path) => write(path, text)?,
        None => out::bytes(text.as_bytes())?,
    }
    Ok(Exit::Done)
}

/// Whatever somebody has written is never overwritten by this.
fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let written = File::create_new(path).and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| {
        let path = path.display();
        Failure::failed(match error.kind() {
            ErrorKind::AlreadyExists => format!("{path} is there already: name another file"),
            _ => format!("{path} cannot be written: {error}"),
        })
    })
}
