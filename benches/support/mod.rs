//! What the benches share: contests of interleaved samples, and what is written
//! down of them.
#![allow(dead_code, unused_imports, reason = "each bench uses its own part of this")]

mod contest;
mod fragment;
mod table;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

pub(crate) use contest::{Contest, Entrant, Quantiles, Times};
pub(crate) use fragment::{Curve, Figure, Fragment, Peer, Series, Target, directory};
pub(crate) use table::{figures, number, peers};

/// Why a bench did not come to its end.
pub(crate) type Failure = Box<dyn Error>;

/// Measures, prints what it finds, and writes it down for the summary.
#[derive(Debug, Parser)]
struct Options {
    /// How many rounds each contest has; each entrant is sampled once in each.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// A tenth of the rounds: a look, not a figure to quote.
    #[arg(long)]
    quick: bool,
    /// Where the findings are written.
    #[arg(long, value_name = "DIR", default_value_os_t = directory())]
    out: PathBuf,
    /// Given by `cargo bench`. Without it (`cargo test --benches`) three rounds
    /// are run, to see that they do, and nothing is written.
    #[arg(long, hide = true)]
    bench: bool,
}

const ROUNDS: u32 = 2_000;

impl Options {
    fn rounds(&self) -> u32 {
        match self {
            Self { rounds: Some(rounds), .. } => *rounds,
            Self { bench: false, .. } => 3,
            Self { quick: true, .. } => ROUNDS / 10,
            Self { .. } => ROUNDS,
        }
    }
}

/// One bench: what it has found so far.
#[derive(Debug)]
pub(crate) struct Bench {
    rounds: u32,
    fragment: Fragment,
}

impl Bench {
    /// How many rounds a contest has, for those that want fewer.
    pub(crate) fn rounds(&self) -> u32 {
        self.rounds
    }

    /// A contest between entrants of one run.
    pub(crate) fn contest<'a>(&self, name: &str) -> Contest<'a> {
        Contest::new(name, self.rounds)
    }

    /// The ratio of two entrants: of their 5th percentiles, which is the figure
    /// that counts, and of their medians, as context.
    pub(crate) fn ratio(
        &mut self,
        row: u8,
        name: &str,
        times: &Times,
        (subject, peer): (Entrant, Entrant),
        target: Target,
    ) {
        let (subject, peer) = (times.of(subject), times.of(peer));
        self.figure(row, name, subject.p5 / peer.p5, "x", target);
        let medians = format!("{name}, medians");
        self.figure(row, &medians, subject.median / peer.median, "x", Target::None);
    }

    /// A figure, in this row of the targets.
    pub(crate) fn figure(&mut self, row: u8, name: &str, value: f64, unit: &str, target: Target) {
        self.fragment.figures.push(Figure::new(row, name, value, unit, target));
    }

    /// The entrants of a contest, as context.
    pub(crate) fn peers(&mut self, times: &Times) {
        self.fragment.peers.extend(times.peers());
    }

    /// A curve, which the summary draws.
    pub(crate) fn curve(&mut self, curve: Curve) {
        self.fragment.curves.push(curve);
    }
}

/// The main function of a bench.
pub(crate) fn run(name: &str, measure: impl FnOnce(&mut Bench) -> Result<(), Failure>) -> ExitCode {
    let options = Options::parse();
    let mut bench = Bench { rounds: options.rounds(), fragment: Fragment::new(name) };
    match measure(&mut bench).and_then(|()| publish(&options, &bench.fragment)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("the bench {name} did not come to its end: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn publish(options: &Options, fragment: &Fragment) -> Result<(), Failure> {
    println!("{}", peers(&fragment.peers));
    println!("{}", figures(&fragment.figures));
    if options.bench {
        let path = fragment.write(&options.out)?;
        println!("written to {}", path.display());
    }
    Ok(())
}
