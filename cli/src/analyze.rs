//! `analyze`: what would become of a schedule.

mod text;

use std::fs;
use std::time::{Duration as StdDuration, Instant as StdInstant};

use faregate_scheduler::analyze::{self, Analysis, Look, Options, Surroundings};
use faregate_scheduler::executive::LoadedFile;
use indicatif::{ProgressBar, ProgressStyle};

use crate::args::{AnalyzeArgs, Format};
use crate::exit::{Exit, Failure};
use crate::schedule::{self, Loader, Schedule};
use crate::{out, times};

pub(crate) fn analyze(args: &AnalyzeArgs) -> Result<Exit, Failure> {
    let schedule = schedule::read(&args.files)?;
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
        fs::write(path, picture).map_err(|error| {
            Failure::failed(format!("{} cannot be written: {error}", path.display()))
        })?;
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

/// Reads what tasks load, and shows how far the samples are when they take
/// more than a second.
struct Patience {
    loader: Loader,
    began: StdInstant,
    bar: ProgressBar,
}

impl Patience {
    fn new(loader: Loader) -> Self {
        Self { loader, began: StdInstant::now(), bar: ProgressBar::hidden() }
    }

    fn end(&self) {
        self.bar.finish_and_clear();
    }
}

impl Surroundings for Patience {
    fn load(&mut self, path: &str) -> LoadedFile {
        self.loader.load(path)
    }

    fn sampled(&mut self, taken: u32, of: u32) {
        if self.bar.is_hidden() && self.began.elapsed() > StdDuration::from_secs(1) {
            let style = ProgressStyle::with_template("{bar:30} {pos} of {len} samples, {eta} left");
            self.bar = ProgressBar::new(of.into());
            if let Ok(style) = style {
                self.bar.set_style(style);
            }
        }
        self.bar.set_position(taken.into());
    }
}
