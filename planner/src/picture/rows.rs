//! Which rows a picture has, and what is in them.

use crate::parameters::Parameters;
use crate::picture::Scene;
use crate::picture::happened::{self, heated_for, left_out};
use crate::picture::lane::{Bar, Ending, Lane, Stretch};
use crate::plan::{Activity, ActivityId, Kind};
use crate::timed::{Fate, Row as Line, Slot};
use crate::trace::Trace;
use crate::units::Time;
use crate::words::{Words, span};

/// A row of the picture.
#[derive(Clone, Debug)]
pub(super) enum Row {
    /// What the rows below have in common, and something to know of it.
    Heading(String, String),
    Lane(Lane),
}

/// More activities than these are not drawn one by one.
const MOST: usize = 120;

pub(super) fn rows(scene: &Scene<'_>) -> Vec<Row> {
    let mut scheduled = Vec::new();
    let mut out = Vec::new();
    for activity in &scene.plan.activities {
        let Some(row) = scene.timed.rows.iter().find(|row| row.id == activity.id) else { continue };
        let lane = lane(scene, activity, row);
        let first = lane.bars.iter().map(|bar| bar.span.0);
        match first.chain(lane.planned.iter().map(|(from, _)| *from)).min() {
            Some(start) => scheduled.push((start, lane)),
            None => out.push(lane),
        }
    }
    scheduled.sort_by_key(|(start, _)| *start);
    let scheduled: Vec<_> = scheduled.into_iter().map(|(_, lane)| lane).collect();
    let many = scene.plan.activities.len() > MOST;
    let mut rows = Vec::new();
    let title = if scene.trace.is_some() { "Started, or planned" } else { "Scheduled" };
    section(&mut rows, title, if many { packed(scheduled) } else { scheduled }, many);
    section(&mut rows, "Left out", if many { Vec::new() } else { out }, many);
    rows
}

fn section(rows: &mut Vec<Row>, title: &str, lanes: Vec<Lane>, many: bool) {
    if lanes.is_empty() {
        return;
    }
    let note = if many { String::new() } else { lanes.len().to_string() };
    rows.push(Row::Heading(title.into(), note));
    rows.extend(lanes.into_iter().map(Row::Lane));
}

/// As few rows as hold them without one lying on another.
fn packed(lanes: Vec<Lane>) -> Vec<Lane> {
    let mut packed: Vec<(Time, Lane)> = Vec::new();
    for mut lane in lanes {
        let begin = lane.preheats.iter().chain(lane.bars.first().map(|bar| &bar.span));
        let begin = begin.map(|(from, _)| *from).min().unwrap_or_default();
        let Some(end) = lane.bars.last().map(|bar| bar.span.1) else { continue };
        let free = packed.iter_mut().find(|(until, _)| *until <= begin);
        if let Some((until, other)) = free {
            *until = end;
            other.preheats.append(&mut lane.preheats);
            other.bars.append(&mut lane.bars);
        } else {
            let (preheats, bars) = (lane.preheats, lane.bars);
            packed.push((end, Lane { preheats, bars, ..Lane::default() }));
        }
    }
    packed.into_iter().map(|(_, lane)| lane).collect()
}

fn lane(scene: &Scene<'_>, activity: &Activity, row: &Line) -> Lane {
    let words = Words::new(scene.plan, scene.parameters);
    let mandatory = is_mandatory(scene.parameters, activity);
    let mut lane = Lane {
        label: label(activity),
        note: format!("p {}", activity.priority),
        mandatory,
        ranges: activity.starts.iter().map(|range| (range.from, range.to, range.cutoff)).collect(),
        ..Lane::default()
    };
    if let Some(trace) = scene.trace {
        lane.planned = scene.timed.slot(activity.id).map(ends).into_iter().collect();
        happened::put(trace, activity.id, &words, &mut lane);
        lane.bars.extend(block(trace, activity, &words));
        let start = lane.bars.first().map(|bar| bar.span.0);
        lane.preheats =
            start.map_or_else(Vec::new, |start| heated_for(trace, &activity.zones, start));
        return lane;
    }
    match &row.fate {
        Fate::Scheduled(slot) | Fate::Running(slot) => {
            lane.preheats = preheats(scene, activity, *slot);
            lane.bars.push(planned(activity, *slot, mandatory, &words));
        }
        Fate::Ended(_) => lane.bars.extend(past(scene, activity.id, mandatory, &words)),
        Fate::Out(_) => lane.out = left_out(scene.timed, activity.id, &words),
    }
    lane
}

/// The ground's own shutdown, if it was.
fn block(trace: &Trace, activity: &Activity, words: &Words<'_>) -> Option<Bar> {
    matches!(activity.kind, Kind::ManualShutdown { .. }).then_some(())?;
    let until = happened::block_over(trace, activity.id)?;
    let from = until.before(activity.duration);
    let tip = format!("{}: {} to {}", label(activity), words.time(from), words.time(until));
    let (span, ending) = ((from, until), Ending::Quiet);
    let words = String::new();
    let mandatory = true;
    Some(Bar { span, minimum: None, mandatory, ending, early: false, words, tip })
}

fn ends(slot: Slot) -> Stretch {
    (slot.start, slot.end)
}

fn label(activity: &Activity) -> String {
    match &activity.name {
        Some(name) => format!("{}  {name}", activity.id.get()),
        None => activity.id.to_string(),
    }
}

pub(super) const fn is_mandatory(parameters: &Parameters, activity: &Activity) -> bool {
    activity.priority >= parameters.mandatory_from
}

fn planned(activity: &Activity, slot: Slot, mandatory: bool, words: &Words<'_>) -> Bar {
    let minimum = slot.start.after(activity.placed());
    let said = format!(
        "{}: {} to {} ({})",
        label(activity),
        words.time(slot.start),
        words.time(slot.end),
        span(slot.length().get())
    );
    Bar {
        span: ends(slot),
        minimum: (minimum < slot.end).then_some(minimum),
        mandatory,
        ending: Ending::Quiet,
        early: false,
        words: String::new(),
        tip: said,
    }
}

/// What the state knows of an activity that has ended.
fn past(scene: &Scene<'_>, id: ActivityId, mandatory: bool, words: &Words<'_>) -> Option<Bar> {
    use crate::plan::Outcome;
    let ended = scene.state.ended.iter().find(|ended| ended.id == id)?;
    let started = ended.started?;
    let ending = match ended.outcome {
        Outcome::Failed => Ending::Failed,
        Outcome::Aborted => Ending::Aborted,
        Outcome::Succeeded | Outcome::NotStarted => Ending::Quiet,
    };
    let tip = format!("{}: {} to {}", id, words.time(started), words.time(ended.ended));
    let span = (started, ended.ended);
    Some(Bar { span, minimum: None, mandatory, ending, early: false, words: String::new(), tip })
}

/// What is heated for this activity: it ends where the activity begins.
fn preheats(scene: &Scene<'_>, activity: &Activity, slot: Slot) -> Vec<Stretch> {
    let mine = scene
        .timed
        .preheats
        .iter()
        .filter(|preheat| preheat.end == slot.start && activity.zones.contains(&preheat.zone));
    mine.map(|preheat| (preheat.start, preheat.end)).collect()
}
