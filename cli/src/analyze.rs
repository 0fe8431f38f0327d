//! `analyze`: what would become of a schedule.

mod text;

use std::time::{Duration as StdDuration, Instant as StdInstant};

use faregate_scheduler::analyze::{self, Analysis, Look, MOST_RUNS, Options, Surroundings};
use faregate_scheduler::executive::LoadedFile;
use faregate_scheduler::time::Duration;
use indicatif::{ProgressBar, ProgressStyle};

use crate::args::{AnalyzeArgs, Format};
use crate::exit::{Exit, Failure};
use crate::schedule::{self, Loader, Schedule};
use crate::{disk, out, times};

pub(crate) fn analyze(args: &AnalyzeArgs) -> Result<Exit, Failure> {
    let schedule = schedule::read(&args.files)?;
    args.gantt.as_deref().map_or(Ok(()), disk::can_be_written)?;
    let options = Options {
        at: args.at.unwrap_or_else(times::now),
        horizon: args.horizon,
        serial: args.serial,
        samples: args.samples.unwrap_or(0),
        seed: args.seed,
    };
    let mut patience = Patience::new(schedule.loader.clone());
    let analysis = analyze::analyze_in(&schedule.tasks, &schedule.mission, &options, &mut patience)
        .map_err(|failed| Failure::failed(failed.to_string()))?;
    patience.end();
    if let Some(path) = &args.gantt {
        let picture = picture(&schedule, &analysis);
        disk::write(path, picture)?;
    }
    match args.format {
        Format::Json => out::json(&analysis)?,
        Format::Text => text::print(&schedule.summary(), &analysis)?,
    }
    Ok(Exit::Done)
}

fn picture(schedule: &Schedule, analysis: &Analysis) -> String {
    analyze::gantt(analysis, &Look { title: schedule.title(), ..Look::default() })
}

/// Reads what tasks load, and shows how far it is when that takes more than a
/// second.
struct Patience {
    loader: Loader,
    began: StdInstant,
    shows: Option<(Stage, ProgressBar)>,
}

/// What is looked at.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The run itself, of which somebody knows when it ends.
    Run,
    /// The run itself, until all is over.
    Endless,
    /// Runs with durations that are drawn.
    Samples,
}

impl Stage {
    const fn style(self) -> &'static str {
        match self {
            Self::Run => "{bar:30} {pos} of {len} s",
            Self::Endless => "{spinner} {pos} runs",
            Self::Samples => "{bar:30} {pos} of {len} samples, {eta} left",
        }
    }
}

impl Patience {
    fn new(loader: Loader) -> Self {
        Self { loader, began: StdInstant::now(), shows: None }
    }

    fn show(&mut self, stage: Stage, done: u64, of: u64) {
        if self.began.elapsed() < StdDuration::from_secs(1) {
            return;
        }
        if self.shows.as_ref().is_none_or(|(shown, _)| *shown != stage) {
            self.end();
            let bar = ProgressBar::new(of);
            if let Ok(style) = ProgressStyle::with_template(stage.style()) {
                bar.set_style(style);
            }
            self.shows = Some((stage, bar));
        }
        if let Some((_, bar)) = &self.shows {
            bar.set_position(done);
        }
    }

    fn end(&self) {
        if let Some((_, bar)) = &self.shows {
            bar.finish_and_clear();
        }
    }
}

impl Surroundings for Patience {
    fn load(&mut self, path: &str) -> LoadedFile {
        self.loader.load(path)
    }

    fn reached(&mut self, at: Duration, limit: Option<Duration>, runs: usize) -> bool {
        let s = |time: Duration| time.as_micros() / 1_000_000;
        // Each sample is such a run, too: they are counted.
        if self.shows.as_ref().is_none_or(|(stage, _)| *stage != Stage::Samples) {
            match limit {
                Some(limit) => self.show(Stage::Run, s(at), s(limit)),
                None => self.show(Stage::Endless, u64::try_from(runs).unwrap_or(u64::MAX), 0),
            }
        }
        runs < MOST_RUNS
    }

    fn sampled(&mut self, taken: u32, of: u32) {
        self.show(Stage::Samples, taken.into(), of.into());
    }
}
