//! `plan run --campaign`: many executions, counted.

use std::collections::BTreeMap;
use std::time::Duration;

use faregate_planner::execute::Options;
use faregate_rehearsal::campaign::{Counts, campaign};
use faregate_rehearsal::{Draws, Odds, Script, Setup};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::{summary, violations};
use crate::args::{PlanRunArgs, RunFormat};
use crate::exit::{Exit, Failure};
use crate::out::{self, BAD};

#[derive(Serialize)]
struct Document<'a> {
    seeds: [u64; 2],
    summary: &'a faregate_rehearsal::Summary,
    violated: u64,
    violations: Vec<BTreeMap<&'static str, String>>,
    /// What a random campaign is for, and never came up.
    never: &'a [&'static str],
}

pub(super) fn run(args: &PlanRunArgs, setup: &Setup, executions: u64) -> Result<Exit, Failure> {
    let seeds = args.seed..args.seed.saturating_add(executions);
    let bar = bar(executions);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let of_seed = |seed| if args.random { random(args, seed) } else { bad_day(setup, seed) };
    let counts =
        campaign(seeds.clone(), threads, &of_seed, &|| super::plan, &violations, &|done| {
            bar.set_position(done);
        });
    bar.finish_and_clear();
    let counts = counts
        .map_err(|(seed, why)| Failure::failed(format!("the execution of seed {seed}: {why}")))?;
    let never = if args.random { counts.summary.never() } else { Vec::new() };
    print(args, [seeds.start, seeds.end], &counts, &never)?;
    Ok(if counts.is_clean() && never.is_empty() { Exit::Done } else { Exit::Failed })
}

fn bar(executions: u64) -> ProgressBar {
    let bar = ProgressBar::new(executions);
    let style = "{bar:30} {pos} of {len} executions, {eta} left";
    if let Ok(style) = ProgressStyle::with_template(style) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}

fn random(args: &PlanRunArgs, seed: u64) -> Setup {
    let setup = Setup::random(seed);
    if args.is_static { Setup { options: Options::STATIC, ..setup } } else { setup }
}

/// The same plan, on another bad day.
fn bad_day(setup: &Setup, seed: u64) -> Setup {
    let mut draws = Draws::new(&setup.plan, seed, &Odds::HARSH);
    if let Some(next) = &setup.next {
        draws.add(next, seed, &Odds::HARSH);
    }
    let mut script = Script::drawn(&setup.plan, &setup.parameters, &setup.state, seed);
    script.0.extend(setup.script.0.iter().cloned());
    Setup { draws, script, seed, ..setup.clone() }
}

fn print(
    args: &PlanRunArgs,
    seeds: [u64; 2],
    counts: &Counts,
    never: &[&'static str],
) -> Result<(), Failure> {
    if args.format == RunFormat::Json {
        let row = |(seed, what): &(u64, String)| {
            BTreeMap::from([("seed", seed.to_string()), ("what", what.clone())])
        };
        let violations = counts.violations.iter().map(row).collect();
        let Counts { summary, violated, .. } = counts;
        out::json(&Document { seeds, summary, violated: *violated, violations, never })?;
        return Ok(());
    }
    summary::table(&counts.summary, None)?;
    let told: Vec<_> =
        counts.violations.iter().map(|(seed, what)| format!("seed {seed}: {what}")).collect();
    summary::verdict(usize::try_from(counts.violated).unwrap_or(usize::MAX), told.iter())?;
    if let Some((seed, _)) = counts.violations.first().filter(|_| args.random) {
        let is_static = if args.is_static { " --static" } else { "" };
        out::line(format!("again: faregate plan run --random --seed {seed}{is_static}"))?;
    }
    for what in never {
        let [first, end] = seeds;
        let last = end.saturating_sub(1).max(first);
        out::line(out::styled(BAD, format_args!("no {what} from seed {first} to {last}")))?;
    }
    Ok(())
}
