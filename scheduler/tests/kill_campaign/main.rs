//! The kill campaign: a real manager with real processes and a device is killed
//! at each named place of its journal, its execs and its reaps, and started
//! again, until its schedule is over.
//!
//! What happened is read from a file that the tasks' own processes and the
//! device write, and from the journal that is left. The program plays three
//! parts: the campaign, the manager that is killed, and the tasks.
//!
//! `cargo test -p faregate-scheduler --features kill-points --test
//! kill_campaign -- --help`; `ci/kill.sh`.
#![cfg(target_os = "linux")]

mod campaign;
mod checks;
mod crew;
mod device;
mod history;
mod manager;
mod schedule;
mod task;
mod truth;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use faregate_scheduler::journal::points::Point;

/// Kills a schedule manager at every place where it matters, and looks at what
/// comes of it.
#[derive(Debug, Parser)]
#[command(name = "kill_campaign")]
struct Options {
    #[command(subcommand)]
    part: Option<Part>,
    #[command(flatten)]
    campaign: campaign::Wishes,
}

/// The other parts that this program plays, for itself.
#[derive(Debug, Subcommand)]
enum Part {
    /// A manager: lives until its schedule is over, or it is killed.
    #[command(hide = true)]
    Manager {
        /// Where everything is.
        place: PathBuf,
        /// What is wrong with it.
        #[arg(long = "break")]
        broken: Option<Break>,
    },
    /// A task's process.
    #[command(hide = true)]
    Task(task::Conduct),
}

/// What can be broken on purpose, to see that it is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Break {
    /// Records stay in the process until a sync.
    Uncommitted,
    /// The camera does not go off, and its sensor says that it did.
    LeftOn,
}

impl Break {
    /// Where it shows.
    const fn points(self) -> &'static [Point] {
        match self {
            Self::Uncommitted => &[Point::AfterExec, Point::BeforeReap],
            Self::LeftOn => &Point::ALL,
        }
    }

    /// What the campaign then has to say.
    const fn complaint(self) -> &'static str {
        match self {
            Self::Uncommitted => "twice",
            Self::LeftOn => "the camera",
        }
    }
}

fn main() -> ExitCode {
    let Options { part, campaign } = Options::parse();
    let done = match part {
        None => campaign::run(&campaign),
        Some(Part::Manager { place, broken }) => manager::live(&place, broken),
        Some(Part::Task(conduct)) => task::run(&conduct),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Why a part could not be played to its end.
type Failure = Box<dyn std::error::Error + Send + Sync>;
