//! What is right or wrong about whole tasks and whole schedules.

mod circles;
mod references;
mod resources;
mod together;

pub(crate) use references::no_such;
pub use together::together;

use crate::format::diagnostic::Rule;
use crate::format::draft::Draft;
use crate::format::policy;
use crate::format::wrong::{Report, Wrong};
use crate::manager::limits::SHORTEST_INTERVAL;
use crate::mission::Mission;
use crate::task::{Overrun, Restart, Task, When, Window};

/// What a schedule is judged against.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Judge<'a> {
    /// The mission; none: whatever depends on one is not judged.
    pub(crate) mission: Option<&'a Mission>,
    /// Whether all of the mission could be read. What is not known to be there
    /// is not told of where it may have been misspelt there.
    pub(crate) mission_good: bool,
    /// Whether tasks that are referred to must be in the file.
    pub(crate) whole: bool,
}

/// Judges each task, and then all of them together.
pub(crate) fn schedule(drafts: &[Draft], judge: Judge<'_>, report: &mut Report<'_>) {
    for draft in drafts {
        task(draft, report);
        resources::task(draft, judge, report);
    }
    references::duplicates(drafts, report);
    references::unknown(drafts, judge, report);
    circles::find(drafts, report);
}

/// What one task says that cannot be meant together.
fn task(draft: &Draft, report: &mut Report<'_>) {
    let task = &draft.task;
    if draft.good(["st", "et"])
        && let [only] = task.windows.as_slice()
        && let Err(wrong) = window(*only)
    {
        report.error(draft.span("et"), "et", wrong);
    }
    if draft.good(["st", "window", "cutoff"]) && before_all_windows(task) {
        let wrong = Wrong::new(Rule::Window, "the cutoff is before the earliest start")
            .expected("a latest end after the earliest start");
        report.error(draft.span("cutoff"), "cutoff", wrong);
    }
    if draft.good(["dur", "dur_min", "dur_max"]) {
        spread(draft, report);
    }
    if draft.good([draft.body, "type", "preempt"]) {
        let suits = policy::suits(&task.body, task.preemption);
        report.take(draft.span("preempt"), "preempt", suits);
    }
    if draft.good(["interval"])
        && task.interval.is_some_and(|interval| interval < SHORTEST_INTERVAL)
    {
        let wrong = Wrong::new(Rule::Range, "no task can come round so often")
            .expected("0 for a task that runs once, or at least 1 ms");
        report.error(draft.span("interval"), "interval", wrong);
    }
    if draft.good(["restart", "overrun", "interval"]) {
        restart(draft, report);
    }
}

/// Whether a window can be open at all. Two ends that are told on different
/// clocks cannot be compared before the load.
pub(crate) fn window(window: Window) -> Result<(), Wrong> {
    if is_before(window.closes, window.opens) {
        return Err(Wrong::new(Rule::Window, "the latest start is before the earliest")
            .expected("0, or a time not before st"));
    }
    Ok(())
}

fn is_before(earlier: When, later: When) -> bool {
    match (earlier, later) {
        (When::AfterLoad(earlier), When::AfterLoad(later)) => earlier < later,
        (When::At(earlier), When::At(later)) => earlier < later,
        _ => false,
    }
}

fn before_all_windows(task: &Task) -> bool {
    task.windows.iter().all(|window| is_before(task.cutoff, window.opens))
}

fn spread(draft: &Draft, report: &mut Report<'_>) {
    let Some(spread) = draft.task.spread else { return };
    let dur = draft.task.duration;
    let (field, expected) = if dur.is_zero() {
        ("dur", "the usual duration, for dur_min and dur_max to be about")
    } else if spread.shortest > dur {
        ("dur_min", "no more than dur")
    } else if spread.longest < dur {
        ("dur_max", "no less than dur")
    } else {
        return;
    };
    let wrong =
        Wrong::new(Rule::Range, "dur is not between dur_min and dur_max").expected(expected);
    report.error(draft.span(field), field, wrong);
}

fn restart(draft: &Draft, report: &mut Report<'_>) {
    let task = &draft.task;
    match task.restart {
        Restart::OnFailure { .. } if task.interval.is_none() => {
            let message = "after a crash of the manager this task may run twice";
            let help =
                "restart = \"never\" runs it at most once; keep this where twice does no harm";
            report.warn(
                draft.span("restart"),
                "restart",
                Wrong::new(Rule::Restart, message).help(help),
            );
        }
        Restart::Never if task.overrun == Overrun::AbortAndRestart => {
            let message = "nothing restarts this task after an overrun";
            let help = "set restart = \"on_failure\", or overrun = \"abort\"";
            report.warn(
                draft.span("overrun"),
                "overrun",
                Wrong::new(Rule::NoEffect, message).help(help),
            );
        }
        _ => {}
    }
}
