//! Which lines of some source files a program reaches, by breakpoints.
//!
//! A breakpoint stands at the start of each line of the source that the
//! program's debug information knows. It is taken away when it is reached. So
//! the figure needs no tools but the compiler's own debug information, costs
//! one stop for each line, and does not depend on the compiler's version. A
//! line that the compiler made no code of is not counted.

mod source;
mod trace;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use clap::Parser;
use comfy_table::Table;
use comfy_table::presets::ASCII_MARKDOWN;

/// Prints which lines of some source files a program reaches.
#[derive(Parser)]
struct Options {
    /// A source file or folder to look at; can be given several times.
    #[arg(long = "of", required = true)]
    of: Vec<PathBuf>,
    /// A source file or folder among them not to look at.
    #[arg(long)]
    without: Vec<PathBuf>,
    /// Fails where fewer of a hundred lines are reached.
    #[arg(long, default_value_t = 0)]
    at_least: u32,
    /// Prints the lines that are not reached.
    #[arg(long)]
    missed: bool,
    /// A program, and after a colon the folder whose files it is given; can be
    /// given several times.
    #[arg(required = true)]
    runs: Vec<String>,
}

/// For each file, its lines, and whether they were reached.
pub(crate) type Lines = BTreeMap<PathBuf, BTreeMap<u64, bool>>;

fn main() -> Result<()> {
    let mut arguments = std::env::args_os().skip(1).peekable();
    if arguments.next_if(|first| first == trace::HOST).is_some() {
        return trace::host(arguments);
    }
    let options = Options::parse();
    let root = std::env::current_dir()?;
    let looked_at = |file: &Path| {
        let under =
            |places: &[PathBuf]| places.iter().any(|place| file.starts_with(root.join(place)));
        under(&options.of) && !under(&options.without)
    };
    let mut lines = Lines::new();
    for run in &options.runs {
        let (program, folder) = run.split_once(':').unwrap_or((run, ""));
        let places = source::places(Path::new(program), &looked_at)?;
        let mut arguments: Vec<PathBuf> = Vec::new();
        if !folder.is_empty() {
            let files = std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
            arguments = files.collect::<std::io::Result<_>>()?;
        }
        let reached = trace::reached(Path::new(program), &arguments, places.keys().copied())?;
        for (address, at) in places {
            let hit = reached.contains(&address);
            for (file, line) in at {
                *lines.entry(file).or_default().entry(line).or_default() |= hit;
            }
        }
    }
    let (all, hit) = print(&lines, &root, options.missed);
    ensure!(all > 0, "no line of these files is in these programs");
    ensure!(
        hit * 100 >= all * u64::from(options.at_least),
        "{hit} of {all} lines are reached, and {} of a hundred must be",
        options.at_least
    );
    Ok(())
}

fn print(lines: &Lines, root: &Path, missed: bool) -> (u64, u64) {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(["file", "lines", "reached", "of a hundred"]);
    let (mut all, mut hit) = (0, 0);
    for (file, lines) in lines {
        let (there, reached) =
            (lines.len() as u64, lines.values().filter(|hit| **hit).count() as u64);
        (all, hit) = (all + there, hit + reached);
        let name = file.strip_prefix(root).unwrap_or(file);
        table.add_row([
            format!("`{}`", name.display()),
            there.to_string(),
            reached.to_string(),
            percent(reached, there),
        ]);
        if missed {
            let missed = lines.iter().filter(|(_, hit)| !**hit).map(|(line, _)| line.to_string());
            eprintln!("{}: {}", name.display(), missed.collect::<Vec<_>>().join(" "));
        }
    }
    table.add_row(["all".to_owned(), all.to_string(), hit.to_string(), percent(hit, all)]);
    println!("{table}");
    (all, hit)
}

/// Rounded down: 99.99 is not 100.
fn percent(part: u64, whole: u64) -> String {
    let tenths = part * 1_000 / whole.max(1);
    format!("{}.{}", tenths / 10, tenths % 10)
}
