//! An analysis for people.

use std::io;

use comfy_table::{Cell, CellAlignment, Table};
use faregate_scheduler::analyze::{
    Analysis, Problem, Quantiles, Run, RunOutcome, Samples, TaskReport, Utilisation,
};
use faregate_scheduler::time::Duration;

use crate::out;
use crate::times::shown;

/// Runs of a task that are listed; of a routine task more are told by number.
const RUNS: usize = 4;

pub(crate) fn print(summary: &str, analysis: &Analysis) -> io::Result<()> {
    out::line(summary)?;
    out::line(tasks(&analysis.tasks))?;
    if let Some(samples) = &analysis.samples {
        out::line(format_args!(
            "\n{} runs with drawn durations, seed {}: {}",
            samples.count,
            samples.seed,
            samples
                .makespan
                .map_or_else(|| "nothing ends".into(), |q| format!("done {}", within(q)))
        ))?;
        out::line(sampled(samples))?;
    }
    usage(&analysis.utilisation)?;
    problems(&analysis.problems)?;
    out::line(match analysis.makespan {
        Some(makespan) => {
            format!("\nThe last task that runs once is over after {} s.", s(makespan))
        }
        None => format!("\nOnly routine tasks; looked at for {} s.", s(analysis.horizon)),
    })
}

fn tasks(tasks: &[TaskReport]) -> Table {
    let mut table = out::table(&["task", "name", "runs", "outcome", "waited", "why"]);
    for task in tasks {
        let listed: Vec<String> = task.runs.iter().take(RUNS).map(run).collect();
        let mut runs = listed.join("\n");
        if task.runs.len() > RUNS {
            runs += &format!("\n… {} runs", task.runs.len());
        }
        if task.runs.is_empty() {
            runs = "none".into();
        }
        let waited = if task.waited.is_zero() { String::new() } else { s(task.waited) + " s" };
        table.add_row([
            Cell::new(task.id.get()).set_alignment(CellAlignment::Right),
            Cell::new(task.more.name.as_deref().unwrap_or_default()),
            Cell::new(runs),
            outcome(task),
            Cell::new(waited).set_alignment(CellAlignment::Right),
            Cell::new(task.reason.as_deref().unwrap_or_default()),
        ]);
    }
    table
}

/// When a run stood still is seen by its segments.
fn run(run: &Run) -> String {
    let segments: Vec<String> =
        run.segments.iter().filter(|(from, until)| from < until).map(span).collect();
    let text = segments.join(", ");
    if text.is_empty() { format!("{} s", s(run.start)) } else { text + " s" }
}

fn span((from, until): &(Duration, Duration)) -> String {
    format!("{}–{}", s(*from), s(*until))
}

fn outcome(task: &TaskReport) -> Cell {
    let Some(last) = task.runs.last() else { return out::cell(out::BAD, "never runs") };
    let (style, odd) = match last.outcome {
        RunOutcome::Succeeded => (out::GOOD, task.more.misses.len()),
        RunOutcome::Unfinished | RunOutcome::Preempted => (out::ODD, task.more.misses.len()),
        RunOutcome::Failed | RunOutcome::Aborted => (out::BAD, task.more.misses.len()),
    };
    match odd {
        0 => out::cell(style, last.outcome),
        missed => out::cell(out::ODD, format!("{}, {missed} missed", last.outcome)),
    }
}

fn sampled(samples: &Samples) -> Table {
    let mut table = out::table(&["task", "first start", "last end", "missed in"]);
    for task in &samples.tasks {
        let missed = match task.miss_probability {
            0.0 => Cell::new(""),
            part => out::cell(out::BAD, format!("{:.1} % of the runs", part * 100.0)),
        };
        table.add_row([
            Cell::new(task.id.get()).set_alignment(CellAlignment::Right),
            Cell::new(task.start.map_or_else(String::new, within)),
            Cell::new(task.end.map_or_else(String::new, within)),
            missed,
        ]);
    }
    table
}

/// Half, nineteen of twenty, all.
fn within(quantiles: Quantiles) -> String {
    let Quantiles { p50, p95, max, .. } = quantiles;
    if p50 == max {
        return format!("{} s", s(max));
    }
    format!("{} s, 95 % by {} s, all by {} s", s(p50), s(p95), s(max))
}

fn usage(utilisation: &Utilisation) -> io::Result<()> {
    for agent in &utilisation.agents {
        let supply = agent.supply.map_or_else(String::new, |supply| format!(" of {supply}"));
        let mut text = format!(
            "{}: at most {}{supply} at a time, {} on average",
            agent.name,
            agent.peak,
            out::about(agent.average)
        );
        if let Some(at) = agent.exceeded {
            text +=
                &format!("; {} wished for, more than there is from {} s on", agent.wished.0, s(at));
        }
        out::line(text)?;
    }
    for category in &utilisation.categories {
        let name =
            category.name.clone().unwrap_or_else(|| format!("category {}", category.category));
        let part = permille(category.busy, utilisation.over);
        out::line(format_args!("{name}: busy {}.{} % of the time", part / 10, part % 10))?;
    }
    Ok(())
}

fn permille(part: Duration, whole: Duration) -> u128 {
    u128::from(part.as_micros()) * 1_000 / u128::from(whole.as_micros().max(1))
}

fn problems(problems: &[Problem]) -> io::Result<()> {
    if problems.is_empty() {
        return out::line(out::styled(out::GOOD, "\nNo problems."));
    }
    out::line(out::styled(out::STRONG, format_args!("\n{} to look at:", problems.len())))?;
    for problem in problems {
        let at = problem.at.map_or_else(String::new, |at| format!("{} s: ", s(at)));
        out::line(format_args!(
            "  {}  {at}{}",
            out::styled(out::ODD, format_args!("{:<11}", problem.kind.to_string())),
            problem.message
        ))?;
    }
    Ok(())
}

/// Seconds, without decimals that say nothing.
fn s(duration: Duration) -> String {
    let text = shown(duration.as_micros(), 6);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
