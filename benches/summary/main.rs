//! Gathers what the benches wrote: one table, one JSON file, one picture for
//! each curve; with `--write` in the documentation too.

#[path = "../support/mod.rs"]
mod support;

mod document;
mod gather;
mod machine;
mod plot;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;

use gather::Summary;
use support::{Failure, directory};

/// Gathers the benches' findings. `ci/bench.sh` runs the benches and then this.
#[derive(Debug, Parser)]
struct Options {
    /// Where the benches wrote; the summary and the pictures go there too.
    #[arg(long, value_name = "DIR", default_value_os_t = directory())]
    fragments: PathBuf,
    /// Puts the table into docs/performance.md and the pictures into docs/.
    #[arg(long)]
    write: bool,
    /// How the documentation says that all this is printed again.
    #[arg(long, default_value = "ci/bench.sh --write")]
    command: String,
    /// Given by `cargo bench`. Without it (`cargo test --benches`) there is
    /// nothing to gather.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("the benches were not summed up: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), Failure> {
    if !options.bench {
        return Ok(());
    }
    let summary = Summary::of(&options.fragments)?;
    println!("{}", support::peers(&summary.peers));
    println!("{}", support::figures(&summary.figures));
    summary.write(&options.fragments.join("summary.json"))?;
    draw(&summary, &options.fragments)?;
    if options.write {
        let docs = Path::new("docs");
        draw(&summary, docs)?;
        document::write(&docs.join("performance.md"), &summary, &options.command)?;
    }
    println!("{}", summary.verdict());
    Ok(())
}

fn draw(summary: &Summary, directory: &Path) -> Result<(), Failure> {
    for curve in &summary.curves {
        let path = directory.join(&curve.slug).with_extension("svg");
        fs::write(&path, plot::svg(curve)?)?;
    }
    Ok(())
}
