//! `plan run --campaign`: many executions, counted.

use std::collections::BTreeMap;

use faregate_rehearsal::campaign::{Counts, campaign};
use faregate_rehearsal::{Draws, Odds, Script, Setup};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::{summary, violations};
use crate::args::{PlanRunArgs, RunFormat};
use crate::exit::{Exit, Failure};
use crate::out;

#[derive(Serialize)]
struct Document<'a> {
    seeds: [u64; 2],
    summary: &'a faregate_rehearsal::Summary,
    violated: u64,
    violations: Vec<BTreeMap<&'static str, String>>,
}

pub(super) fn run(args: &PlanRunArgs, setup: &Setup, executions: u64) -> Result<Exit, Failure> {
    let seeds = args.seed..args.seed.saturating_add(executions);
    let bar = ProgressBar::new(executions);
    if let Ok(style) =
        ProgressStyle::with_template("{bar:30} {pos} of {len} executions, {eta} left")
    {
        bar.set_style(style);
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let of_seed = |seed| {
        let draws = Draws::new(&setup.plan, seed, &Odds::HARSH);
        let mut script = Script::drawn(&setup.plan, &setup.parameters, &setup.state, seed);
        script.0.extend(setup.script.0.iter().cloned());
        Setup { draws, script, seed, ..setup.clone() }
    };
    let counts =
        campaign(seeds.clone(), threads, &of_seed, &|| super::plan, &violations, &|done| {
            bar.set_position(done);
        });
    bar.finish_and_clear();
    let counts = counts
        .map_err(|(seed, why)| Failure::failed(format!("the execution of seed {seed}: {why}")))?;
    print(args, [seeds.start, seeds.end], &counts)?;
    Ok(if counts.is_clean() { Exit::Done } else { Exit::Failed })
}

fn print(args: &PlanRunArgs, seeds: [u64; 2], counts: &Counts) -> Result<(), Failure> {
    if args.format == RunFormat::Json {
        let row = |(seed, what): &(u64, String)| {
            BTreeMap::from([("seed", seed.to_string()), ("what", what.clone())])
        };
        let violations = counts.violations.iter().map(row).collect();
        let Counts { summary, violated, .. } = counts;
        out::json(&Document { seeds, summary, violated: *violated, violations })?;
        return Ok(());
    }
    summary::table(&counts.summary, None)?;
    let told: Vec<_> =
        counts.violations.iter().map(|(seed, what)| format!("seed {seed}: {what}")).collect();
    summary::verdict(usize::try_from(counts.violated).unwrap_or(usize::MAX), told.iter())?;
    Ok(())
}
