//! Which rows a picture has, and what is in them.

use crate::analyze::gantt::Rows;
use crate::analyze::gantt::scale::say;
use crate::analyze::report::{Analysis, Run, RunOutcome, TaskReport};
use crate::analyze::utilisation::{CategoryUse, bits};
use crate::time::Duration;

/// From, until.
pub(super) type Span = (Duration, Duration);

/// A row of the picture.
#[derive(Clone, Debug)]
pub(super) enum Row {
    /// What the rows below have in common, and something to know of it.
    Heading(String, String),
    /// A task, or a category.
    Lane(Lane),
}

/// What is drawn in one row.
#[derive(Clone, Debug, Default)]
pub(super) struct Lane {
    pub(super) label: String,
    /// Right of the label.
    pub(super) note: String,
    pub(super) windows: Vec<Span>,
    pub(super) waits: Vec<Span>,
    pub(super) runs: Vec<Bar>,
    pub(super) pauses: Vec<Span>,
    pub(super) gaps: Vec<Span>,
    pub(super) misses: Vec<Duration>,
    /// Whether its runs are of several tasks.
    pub(super) mixed: bool,
}

/// A piece of a run.
#[derive(Clone, Debug)]
pub(super) struct Bar {
    pub(super) span: Span,
    pub(super) outcome: RunOutcome,
    /// Whether the run ends with this piece.
    pub(super) last: bool,
    /// The task's place in the schedule.
    pub(super) task: usize,
    /// What is written in it, if there is room.
    pub(super) words: String,
    pub(super) tip: String,
}

/// More tasks than this are not drawn one by one, unless that is wanted.
const MOST_TASKS: usize = 120;

pub(super) fn rows(analysis: &Analysis, wanted: Rows) -> Vec<Row> {
    let by_task = match wanted {
        Rows::Tasks => true,
        Rows::Categories => false,
        Rows::Fitting => analysis.tasks.len() <= MOST_TASKS,
    };
    if by_task { by_tasks(analysis) } else { by_categories(analysis) }
}

/// Tasks under the first of their categories, in the order in which they start.
fn by_tasks(analysis: &Analysis) -> Vec<Row> {
    let mut rows = Vec::new();
    let groups = groups(analysis);
    for (category, members) in &groups {
        if groups.len() > 1 {
            rows.push(heading(*category, analysis));
        }
        let mut members = members.clone();
        members.sort_by_key(|(place, task)| (starts(task), *place));
        rows.extend(members.iter().map(|(place, task)| Row::Lane(lane_of(*place, task))));
    }
    rows
}

type Members<'a> = Vec<(usize, &'a TaskReport)>;

/// Those without a category come last.
fn groups(analysis: &Analysis) -> Vec<(Option<&CategoryUse>, Members<'_>)> {
    let categories = analysis.utilisation.categories.iter().map(Some).chain([None]);
    let groups = categories.map(|category| {
        let members = analysis.tasks.iter().enumerate();
        let number = category.map(|category| category.category);
        let mine = members.filter(|(_, task)| bits(task.more.categories.mask()).next() == number);
        (category, mine.collect::<Vec<_>>())
    });
    groups.filter(|(_, members)| !members.is_empty()).collect()
}

fn starts(task: &TaskReport) -> Option<Duration> {
    let run = task.runs.first().map(|run| run.start);
    let wait = task.more.waits.first().map(|(from, _)| *from);
    run.or(wait).or(Some(Duration::MAX))
}

fn heading(category: Option<&CategoryUse>, analysis: &Analysis) -> Row {
    match category {
        None => Row::Heading("no category".into(), String::new()),
        Some(category) => Row::Heading(name(category), busy(category, analysis)),
    }
}

fn name(category: &CategoryUse) -> String {
    let number = category.category;
    category.name.clone().unwrap_or_else(|| match 1_u128.checked_shl(number.into()) {
        Some(mask) if number < 10 => format!("category {number} (con {mask})"),
        _ => format!("category {number}"),
    })
}

fn busy(category: &CategoryUse, analysis: &Analysis) -> String {
    let over = analysis.utilisation.over.as_micros().max(1);
    format!("{} % busy", category.busy.as_micros().saturating_mul(100) / over)
}

/// One row for each category: what the thesis draws.
fn by_categories(analysis: &Analysis) -> Vec<Row> {
    let categories = analysis.utilisation.categories.iter().map(|category| {
        let tasks = analysis.tasks.iter().enumerate();
        let mine = tasks.filter(|(_, task)| {
            bits(task.more.categories.mask()).any(|number| number == category.category)
        });
        (name(category), busy(category, analysis), mine.collect::<Vec<_>>())
    });
    let tasks = analysis.tasks.iter().enumerate();
    let free: Vec<_> = tasks.filter(|(_, task)| task.more.categories.is_empty()).collect();
    let free = (!free.is_empty()).then(|| ("no category".into(), String::new(), free));
    let lanes = categories.chain(free);
    lanes.map(|(label, note, members)| Row::Lane(mixed(label, note, &members))).collect()
}

fn mixed(label: String, note: String, members: &Members<'_>) -> Lane {
    let mut lane = Lane { label, note, mixed: true, ..Lane::default() };
    for (place, task) in members {
        let mut other = lane_of(*place, task);
        lane.runs.append(&mut other.runs);
        lane.pauses.append(&mut other.pauses);
        lane.gaps.append(&mut other.gaps);
        lane.misses.append(&mut other.misses);
    }
    lane.runs.sort_by_key(|bar| (bar.span, bar.task));
    lane.pauses.clear();
    lane.gaps.sort_unstable();
    lane.misses.sort_unstable();
    lane
}

fn lane_of(place: usize, task: &TaskReport) -> Lane {
    let id = task.id.get();
    let label = match &task.more.name {
        Some(name) => format!("{id}  {name}"),
        None => task.id.to_string(),
    };
    let windows = task.more.windows.iter();
    Lane {
        label,
        note: format!("pri {}", task.more.priority),
        windows: windows.filter_map(|(from, until)| Some((*from, (*until)?))).collect(),
        waits: task.more.waits.clone(),
        runs: task.runs.iter().flat_map(|run| bars(place, task, run)).collect(),
        pauses: task.runs.iter().flat_map(pauses).collect(),
        gaps: task.runs.iter().filter_map(|run| gap(task, run)).collect(),
        misses: task.more.misses.clone(),
        mixed: false,
    }
}

fn bars<'a>(place: usize, task: &'a TaskReport, run: &'a Run) -> impl Iterator<Item = Bar> + 'a {
    let end = run.end.map_or("the horizon".into(), say);
    let tip = format!("{}: {} to {end}, {}", task.id, say(run.start), run.outcome);
    let count = run.segments.len();
    run.segments.iter().enumerate().map(move |(index, span)| Bar {
        span: *span,
        outcome: run.outcome,
        last: index.saturating_add(1) == count,
        task: place,
        words: task.id.get().to_string(),
        tip: tip.clone(),
    })
}

/// Between the pieces of a run, and after the last one of a run that ended
/// while it stood still.
fn pauses(run: &Run) -> Vec<Span> {
    let between = run.segments.windows(2).filter_map(|pair| match pair {
        [(_, from), (until, _)] => Some((*from, *until)),
        _ => None,
    });
    let last = run.segments.last().map(|(_, until)| *until);
    let after = last.zip(run.end).filter(|(from, until)| from < until);
    between.chain(after).collect()
}

fn gap(task: &TaskReport, run: &Run) -> Option<Span> {
    let end = run.end.filter(|_| !task.more.gap.is_zero())?;
    (run.outcome != RunOutcome::Preempted).then(|| (end, end.saturating_add(task.more.gap)))
}
