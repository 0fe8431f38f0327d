//! The program: options, rows, results.

mod bell;
mod brokers;
mod desk;
mod device;
mod gates;
mod locks;
mod measured;
mod picture;
mod probe;
mod report;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod restarts;
mod results;
mod rights;
mod rows;
mod stage;
mod wakeup;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};

use measured::Measured;
use results::{Fragment, Played};
use rights::{Placement, Rights};
use rows::{Case, Expected, Row};
use stage::Limits;
use wakeup::By;

/// Why something did not come to its end.
pub(crate) type Failure = Box<dyn Error + Send + Sync>;

/// What something comes to.
pub(crate) type Outcome<T> = Result<T, Failure>;

/// Measures how long revocations, hand-overs and valid commands wait for a
/// thread that was pre-empted, behind our gates and behind plain locks.
#[derive(Parser)]
#[command(
    after_help = "Exit code: 0; 1 if a command came after quiescence, if a control that must fail \
                        did not, or if a row could not be measured; with CI=true also if a row was skipped \
                        because the host does not permit it. No time is judged."
)]
struct Options {
    /// How many rounds a row has at most.
    #[arg(long, default_value_t = 4_000, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    rounds: u64,
    /// How long a row is played at most; the plain locks need 3 ms for a round.
    #[arg(long, value_name = "MS", default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..=3_600_000))]
    row_ms: u64,
    /// Fewer rounds: some seconds in all.
    #[arg(long, conflicts_with_all = ["rounds", "row_ms"])]
    quick: bool,
    /// The CPUs: the first for holder and hog, the second for the revoker in
    /// rows on two. By default the first two that the process may use.
    #[arg(long, value_delimiter = ',', value_name = "CPU,CPU", num_args = 1..=2)]
    cpus: Vec<usize>,
    /// Write the histograms as a picture.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Where the figures go, as JSON. By default bench/latency.json in the
    /// folder that Cargo builds in.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Options {
    fn limits(&self) -> Limits {
        if self.quick {
            return Limits { rounds: 200, time: Duration::from_millis(120) };
        }
        Limits { rounds: self.rounds, time: Duration::from_millis(self.row_ms) }
    }

    fn json(&self) -> PathBuf {
        let folder = || std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
        self.json.clone().unwrap_or_else(|| Path::new(&folder()).join("bench/latency.json"))
    }
}

pub(crate) fn main() -> ExitCode {
    match measure(&Options::parse()) {
        Ok(complaints) if complaints.is_empty() => ExitCode::SUCCESS,
        Ok(complaints) => {
            complaints.iter().for_each(|complaint| eprintln!("error: {complaint}"));
            ExitCode::FAILURE
        }
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn measure(options: &Options) -> Outcome<Vec<String>> {
    let rights = Rights::take(&options.cpus);
    println!("Note: {}.", rights::throttling());
    rights.missing.iter().for_each(|missing| println!("Not set up: {missing}."));
    let mut run = Run::default();
    run.play_all(&rights, options.limits());
    rustix::mm::munlockall()?;
    run.print();
    run.write(options)?;
    Ok(run.complaints())
}

/// What has been played.
#[derive(Default)]
struct Run {
    played: Vec<Played>,
    failed: Vec<String>,
    skipped: Vec<String>,
}

impl Run {
    fn play_all(&mut self, rights: &Rights, limits: Limits) {
        let (rows, skipped): (Vec<_>, Vec<_>) =
            rows::all().into_iter().partition(|row| row.check().is_ok());
        self.skipped.extend(skipped.iter().filter_map(|row| row.check().err()));
        if rights.placements.is_empty() {
            self.skipped.push(format!("all {} rows, on one CPU and on two", rows.len()));
            return;
        }
        if rights.placements.len() < 2 {
            self.skipped.push(format!("{} rows on two CPUs", rows.len()));
        }
        let progress = progress(rows.len() * rights.placements.len());
        let mut host = WakeUps::of(&rights.placements);
        for row in &rows {
            for placement in &rights.placements {
                progress.set_message(format!("{}, {}", row.case.name(), row.who));
                self.play(row, *placement, limits);
                host.iter_mut().for_each(WakeUps::measure);
                progress.inc(1);
            }
        }
        progress.finish_and_clear();
        for WakeUps { by, placement, measured } in host {
            self.keep(Case::WakeUp, by.name(), Expected::Host, None, placement, measured);
        }
    }

    fn play(&mut self, row: &Row, placement: Placement, limits: Limits) {
        let (target_us, measured) = (row.target_us(placement), row.play(placement, limits));
        self.keep(row.case, row.who, row.expected, target_us, placement, measured);
    }

    fn keep(
        &mut self,
        case: Case,
        who: &'static str,
        expected: Expected,
        target_us: Option<u32>,
        placement: Placement,
        measured: Outcome<Measured>,
    ) {
        match measured {
            Ok(measured) => {
                self.played.push(Played { case, who, expected, target_us, placement, measured });
            }
            Err(failure) => {
                let (case, placement) = (case.name(), placement.name());
                self.failed.push(format!("{case}, {placement}, {who}: not measured: {failure}"));
            }
        }
    }

    fn print(&self) {
        for case in Case::ALL {
            if let Some(table) = report::table(case, &self.played) {
                println!("\n{table}");
            }
        }
        println!();
        results::remarks(&self.played).iter().for_each(|remark| println!("{remark}"));
        self.skipped.iter().for_each(|skipped| println!("SKIPPED: {skipped}."));
    }

    fn write(&self, options: &Options) -> Outcome<()> {
        let fragment = Fragment::of(&self.played, &self.skipped);
        write(&options.json(), &serde_json::to_string_pretty(&fragment)?)?;
        match &options.svg {
            Some(file) => write(file, &picture::draw(&self.played)),
            None => Ok(()),
        }
    }

    fn complaints(&self) -> Vec<String> {
        let ci = std::env::var_os("CI").is_some_and(|ci| ci == "true");
        let skipped = self.skipped.iter().filter(|_| ci).map(|row| format!("skipped: {row}"));
        let wrong = self.played.iter().filter_map(Played::complaint);
        self.failed.iter().cloned().chain(wrong).chain(skipped).collect()
    }
}

/// The host's own wake-ups, some after each row.
struct WakeUps {
    by: By,
    placement: Placement,
    measured: Outcome<Measured>,
}

impl WakeUps {
    fn of(placements: &[Placement]) -> Vec<Self> {
        let on = |placement: &Placement| match placement.is_one_cpu() {
            true => vec![(By::Timer, *placement), (By::TimerWhenBusy, *placement)],
            false => vec![(By::OtherCpu, *placement)],
        };
        let measured = Measured::new;
        let of = |(by, placement)| Self { by, placement, measured: measured() };
        placements.iter().flat_map(on).map(of).collect()
    }

    fn measure(&mut self) {
        let Ok(measured) = &mut self.measured else { return };
        if let Err(failure) = wakeup::measure(measured, self.by, self.placement) {
            self.measured = Err(failure);
        }
    }
}

fn write(file: &Path, text: &str) -> Outcome<()> {
    let told = |error| format!("cannot write {}: {error}", file.display());
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder).map_err(told)?;
    }
    Ok(fs::write(file, text).map_err(told)?)
}

fn progress(rows: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} rows, {msg}");
    let bar = ProgressBar::new(rows.try_into().unwrap_or(u64::MAX));
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
