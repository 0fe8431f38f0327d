//! The commands.

mod check;
mod items;
mod reject;
mod show;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod step;
#[cfg(not(all(target_os = "linux", target_arch = "x86_64")))]
#[path = "cli/no_step.rs"]
mod step;
mod table;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context as _, Result, ensure};
use clap::{Parser, Subcommand};
use faregate_audit::image::Image;
use faregate_audit::isa::Isa;
use faregate_audit::rows::Rows;

/// The static bounded-time audit of the compiled code.
///
/// Exits with 0 where all holds, with 1 where something audited does not, with
/// 2 where the audit could not be made.
#[derive(Debug, Parser)]
#[command(version)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Audits the rows and says what breaks them.
    Check {
        /// What is audited.
        #[arg(long, default_value = "audit/rows.toml")]
        rows: PathBuf,
        /// As JSON.
        #[arg(long)]
        json: bool,
        /// The objects.
        #[arg(required = true, value_name = "x86_64=PATH|thumb=PATH")]
        objects: Vec<Object>,
    },
    /// Writes the table of the rows into a document, between its markers, or
    /// compares.
    Table {
        /// What is audited.
        #[arg(long, default_value = "audit/rows.toml")]
        rows: PathBuf,
        /// Writes it.
        #[arg(long, conflicts_with = "check", required_unless_present = "check")]
        write: bool,
        /// Compares, and breaks where the document says something else.
        #[arg(long)]
        check: bool,
        /// The document.
        #[arg(long, default_value = "docs/timing.md")]
        document: PathBuf,
        /// The objects: all that the rows are about.
        #[arg(required = true, value_name = "x86_64=PATH|thumb=PATH")]
        objects: Vec<Object>,
    },
    /// Calls the audited functions with random inputs, one instruction at a
    /// time, and compares with the bounds. On Linux on x86-64.
    Step {
        /// What is audited.
        #[arg(long, default_value = "audit/rows.toml")]
        rows: PathBuf,
        /// As JSON.
        #[arg(long)]
        json: bool,
        /// Calls of each function.
        #[arg(long, default_value_t = 300)]
        calls: u64,
        /// Instructions of each function; no new call is made after them.
        #[arg(long, default_value_t = 200_000)]
        instructions: u64,
        /// The object.
        #[arg(value_name = "x86_64=PATH")]
        object: Object,
    },
    /// What `step` starts as its child.
    #[command(hide = true)]
    StepHost {
        /// The object.
        path: PathBuf,
        /// The function.
        symbol: String,
        /// How many calls.
        calls: u64,
    },
    /// Lists the items whose documentation promises constant time, and compares
    /// them with the rows.
    Items {
        /// What is audited.
        #[arg(long, default_value = "audit/rows.toml")]
        rows: PathBuf,
        /// As JSON.
        #[arg(long)]
        json: bool,
        /// The crates' folders.
        #[arg(default_values = ["tickets/src", "agents/src", "runtime/src"])]
        sources: Vec<PathBuf>,
    },
    /// Audits the must-reject set: each row has to be rejected for its own
    /// reason, or accepted where it names none.
    Reject {
        /// What is audited, and what is wrong with it.
        #[arg(long, default_value = "audit/must-reject/rows.toml")]
        rows: PathBuf,
        /// The objects.
        #[arg(required = true, value_name = "x86_64=PATH|thumb=PATH")]
        objects: Vec<Object>,
    },
    /// Prints the instructions of a function and of all that it calls, with
    /// where they stand in the source.
    Show {
        /// The object.
        #[arg(value_name = "x86_64=PATH|thumb=PATH")]
        object: Object,
        /// A symbol, or a path in the source.
        symbol: String,
    },
}

/// Whether what is audited holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It does.
    Holds,
    /// It does not, and what was printed says why.
    Broken,
}

impl Verdict {
    fn of(holds: bool) -> Self {
        if holds { Self::Holds } else { Self::Broken }
    }
}

/// An object on the command line.
#[derive(Clone, Debug)]
struct Object {
    isa: Isa,
    path: PathBuf,
}

impl FromStr for Object {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (isa, path) = text.split_once('=').ok_or("write x86_64=PATH or thumb=PATH")?;
        let isa = [Isa::X86_64, Isa::Thumb]
            .into_iter()
            .find(|known| known.name() == isa)
            .ok_or_else(|| format!("{isa} is neither x86_64 nor thumb"))?;
        Ok(Self { isa, path: path.into() })
    }
}

impl Object {
    fn read(&self) -> Result<Image> {
        let image = Image::read(&self.path)?;
        let (found, said) = (image.isa.name(), self.isa.name());
        ensure!(found == said, "{} is {found}, not {said}", self.path.display());
        Ok(image)
    }
}

fn read_all(objects: &[Object]) -> Result<BTreeMap<Isa, Image>> {
    let mut images = BTreeMap::new();
    for object in objects {
        let before = images.insert(object.isa, object.read()?);
        ensure!(before.is_none(), "{} is given twice", object.isa.name());
    }
    Ok(images)
}

/// Does what was asked for.
pub(crate) fn run(arguments: Arguments) -> Result<Verdict> {
    match arguments.command {
        Command::Check { rows, json, objects } => {
            let rows = Rows::read(&rows)?;
            ensure!(
                rows.rows.iter().all(|row| row.rejected.is_none()),
                "`rejected` is for `reject`"
            );
            check::check(&rows, &read_all(&objects)?, json)
        }
        Command::Items { rows, json, sources } => items::items(&Rows::read(&rows)?, &sources, json),
        Command::Table { rows, write, document, objects, .. } => {
            table::table(&Rows::read(&rows)?, &read_all(&objects)?, &document, write)
        }
        Command::Step { rows, json, calls, instructions, object } => {
            step::step(&Rows::read(&rows)?, &object, calls, instructions, json)
        }
        Command::StepHost { path, symbol, calls } => step::host(&path, &symbol, calls),
        Command::Reject { rows, objects } => {
            reject::reject(&Rows::read(&rows)?, &read_all(&objects)?)
        }
        Command::Show { object, symbol } => {
            show::show(&object.read()?, &symbol).context("nothing to show")
        }
    }
}
