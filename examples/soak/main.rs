//! The soak: holders hammer, revokers revoke, millions of times, and no command
//! comes after quiescence.
//!
//! A holder's thread gives commands without end, refused or not. A revoker takes
//! its ticket away in every way that there is, waits until quiescent, and sets a
//! mark. The device looks at that mark without any lock, and counts each command
//! that began or was in progress after it. There must be none, under any gate
//! strategy, on all processors and pinned to one, where the revoker pre-empts
//! holders inside their commands. The same device behind a bare flag must show
//! some, or the soak could not have seen any.
//!
//! Most revocations go through a gate's key, as an agent's do beneath its books;
//! the others through a broker, with books and hand-over.
//!
//! ```sh
//! cargo run --release --example soak                          # 10^6, some seconds
//! cargo run --release --example soak -- --revocations 1000000000
//! ```

mod agents;
mod drive;
mod driver;
mod gates;
mod holder;
mod place;
mod report;
mod rivals;
mod room;
mod rows;
mod strategies;
mod subject;

use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use drive::{Drive, Tally};
use place::Place;
use report::Soaked;
use rows::{Row, Where};
use subject::Outcome;

/// Revokes valid tickets under load, and counts commands after quiescence.
#[derive(Parser)]
#[command(after_help = "\
Exit code: 0 if no command came after quiescence, and the controls show some; 1 if not; \
2 for wrong arguments. With CI=true, what the host does not permit is a failure too.")]
struct Options {
    /// How many revocations, in all.
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(100_000..))]
    revocations: u64,
    /// Seeds the dice of holders and revokers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Soak only what has this text in its strategy's name, and only its share.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Do not ask for real-time priority on all cores: under load it takes many
    /// times as long, and leaves room for others.
    #[arg(long)]
    ordinary: bool,
    /// Write the figures to target/bench/soak.json as well.
    #[arg(long)]
    json: bool,
    /// Break it on purpose: then every row must show commands after quiescence.
    #[arg(long = "break", value_name = "HOW", hide = true)]
    broken: Option<Break>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Break {
    /// The mark is set without waiting for quiescence.
    SkipQuiescence,
    /// A flag is looked at outside of the lock around the command.
    CheckOutside,
}

/// The rows are soaked in passes of so many revocations, so that the estimate
/// of the time left is of all of them.
const PASS: u64 = 10_000_000;

fn main() -> ExitCode {
    let outcome = soak(&Options::parse());
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("\nFAILED: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn soak(options: &Options) -> Outcome<()> {
    let places = Places::of_host(options)?;
    let rows = chosen(options, &places)?;
    let passes = options.revocations.div_ceil(PASS);
    let revocations = |row: &Row| row_revocations(options.revocations / passes, row);
    let all: u64 = rows.iter().map(revocations).sum::<u64>() * passes;
    println!("{all} revocations, seed {}", options.seed);
    let mut soaked: Vec<Soaked> = Vec::new();
    let bar = bar(all);
    for pass in 0..passes {
        for (number, row) in rows.iter().enumerate() {
            bar.set_message(format!("{}, {}", row.strategy, row.through));
            let drive = Drive {
                place: places.place(row.place).ok_or("a place that is not there")?,
                revocations: revocations(row),
                seed: options.seed.wrapping_add(pass.wrapping_mul(0x5EED)),
                skip_quiescence: options.broken == Some(Break::SkipQuiescence),
            };
            let begun = Instant::now();
            let tally = run(row, drive, &bar);
            let tally = tally.map_err(|why| format!("{}, {}: {why}", row.strategy, row.through))?;
            match soaked.get_mut(number) {
                Some(before) => before.add(tally, begun.elapsed()),
                None => soaked.push(Soaked { row: *row, tally, took: begun.elapsed() }),
            }
        }
    }
    bar.finish_and_clear();
    let asked = rows.iter().filter(|row| !row.control).map(revocations).sum::<u64>() * passes;
    judge(options, &soaked, asked)
}

fn judge(options: &Options, soaked: &[Soaked], asked: u64) -> Outcome<()> {
    println!("{}", report::table(soaked));
    let figures = report::figures(soaked, asked);
    if options.json {
        println!("figures: {}", report::write(&figures)?.display());
    }
    let failures: Vec<String> = figures.iter().filter_map(report::Figure::failure).collect();
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n        ").into()) }
}

/// The rows to be soaked; what this host cannot run is said.
fn chosen(options: &Options, places: &Places) -> Outcome<Vec<Row>> {
    let mut rows: Vec<Row> = match options.broken {
        None => rows::all().into_iter().chain(rows::controls()).collect(),
        Some(Break::SkipQuiescence) => rows::where_quiescence_counts(),
        Some(Break::CheckOutside) => vec![rows::outside_the_lock()],
    };
    if let Some(only) = &options.only {
        rows.retain(|row| row.strategy.contains(only.as_str()));
    }
    let mut runnable = Vec::new();
    for row in rows {
        match (row.check)() {
            Err(why) => skipped(&format!("{}: {why}", row.strategy))?,
            Ok(()) if places.place(row.place).is_some() => runnable.push(row),
            // It has been said which place is not there.
            Ok(()) => {}
        }
    }
    if runnable.is_empty() { Err("there is nothing to soak".into()) } else { Ok(runnable) }
}

/// Says what is not soaked. Where all must be seen, that is a failure.
fn skipped(what: &str) -> Outcome<()> {
    if std::env::var_os("CI").is_some_and(|ci| ci == "true") {
        return Err(format!("not permitted here, and CI must see it: {what}").into());
    }
    println!("skipped: {what}");
    Ok(())
}

/// The places that the host permits.
struct Places {
    all_cores: Place,
    one_cpu: Option<Place>,
}

impl Places {
    fn of_host(options: &Options) -> Outcome<Self> {
        let one_cpu = place::one_cpu();
        if let Err(why) = &one_cpu {
            skipped(&format!("one CPU, which takes real-time priorities: {why}"))?;
        }
        let ordinary = options.ordinary || one_cpu.is_err();
        Ok(Self { all_cores: Place::AllCores { ordinary }, one_cpu: one_cpu.ok() })
    }

    fn place(&self, place: Where) -> Option<Place> {
        match place {
            Where::AllCores => Some(self.all_cores),
            Where::OneCpu => self.one_cpu,
        }
    }
}

/// How many revocations a row gets of so many in all. A control takes some
/// more.
fn row_revocations(all: u64, row: &Row) -> u64 {
    let share = if row.share == 0 { (all / 100).min(100_000) } else { all * row.share / 1000 };
    share.max(2_000)
}

/// Soaks a row, on as many subjects as its place has room for.
fn run(row: &Row, drive: Drive, bar: &ProgressBar) -> Outcome<Tally> {
    let subjects = drive.place.subjects();
    let (done, before) = (AtomicU64::new(0), bar.position());
    thread::scope(|scope| {
        let done = &done;
        let mut soaks = Vec::new();
        for number in 0..subjects {
            let number = u64::try_from(number)?;
            let revocations = drive.revocations / subjects as u64;
            let seed = drive.seed.wrapping_add(number << 32);
            let drive = Drive { revocations, seed, ..drive };
            soaks.push(scope.spawn(move || (row.soak)(drive, done)));
        }
        while soaks.iter().any(|soak| !soak.is_finished()) {
            bar.set_position(before + done.load(Ordering::Relaxed));
            thread::park_timeout(Duration::from_millis(50));
        }
        bar.set_position(before + drive.revocations);
        let tallies = soaks.into_iter().map(|soak| soak.join().map_err(|_| "a soak panicked")?);
        tallies.sum()
    })
}

fn bar(len: u64) -> ProgressBar {
    let bar = ProgressBar::new(len);
    let template = "{wide_bar} {human_pos} of {human_len}, {per_sec}, {eta} left  {msg}";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}
