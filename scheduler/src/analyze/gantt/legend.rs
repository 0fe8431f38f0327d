//! The legend: each sign that is in the picture, and no other.

use svg::node::element::Group;

use crate::analyze::gantt::dense::is_crowded;
use crate::analyze::gantt::lane::{self, Place};
use crate::analyze::gantt::pen::{GREY, TONES, bar, length, text};
use crate::analyze::gantt::rows::{Bar, Lane, Row};
use crate::analyze::gantt::scale::Scale;
use crate::analyze::report::RunOutcome;
use crate::time::Duration;

/// Wide enough for every sign.
const SIGN: f64 = 30.0;

pub(super) fn draw(rows: &[Row], scale: &Scale, (left, middle): (f64, f64)) -> Group {
    let mut x = left;
    let lanes = || {
        rows.iter().filter_map(|row| match row {
            Row::Lane(lane) => Some(lane),
            Row::Heading(..) => None,
        })
    };
    let mut group = Group::new();
    let is_crowded = |count: usize| is_crowded(count, scale);
    for Sign { words, lane, is_lost, count } in signs() {
        // Some of what cannot be told apart is not drawn.
        let is_drawn = |lane: &Lane| match is_lost {
            Lost::Never => true,
            Lost::AmongItsLike => !is_crowded(count(lane)),
            Lost::AmongRuns => !is_crowded(lane.runs.len()),
        };
        if lanes().any(|lane| count(lane) > 0 && is_drawn(lane)) {
            group = group.add(sample(&lane, x, middle)).add(said(words, x, middle));
            x += SIGN + length(words) + 30.0;
        }
    }
    if lanes().any(|lane| is_crowded(lane.runs.len())) {
        let words = "paler: part of the time";
        let pale = bar((x, x + SIGN), middle - 6.0, 12.0, TONES[0]).set("fill-opacity", "0.35");
        group = group.add(pale).add(said(words, x, middle));
    }
    group
}

fn said(words: &str, x: f64, middle: f64) -> svg::node::element::Text {
    text(x + SIGN + 9.0, middle + 4.0, words).set("fill", GREY)
}

/// The sign as the rows draw it.
fn sample(lane: &Lane, x: f64, middle: f64) -> Group {
    let scale = Scale::new(Duration::from_secs(10), x, x + SIGN);
    lane::draw(lane, Place { top: middle - 10.0, height: 20.0 }, &scale)
}

/// A thing that can be in a picture.
struct Sign {
    words: &'static str,
    /// A row that has nothing else.
    lane: Lane,
    is_lost: Lost,
    /// How many of it a row has.
    count: fn(&Lane) -> usize,
}

/// Where a thing is not drawn.
#[derive(Clone, Copy)]
enum Lost {
    Never,
    /// Where it cannot be told apart from others of its kind.
    AmongItsLike,
    /// Where runs cannot be told apart.
    AmongRuns,
}

fn signs() -> [Sign; 9] {
    let at = Duration::from_secs;
    let whole = (at(0), at(10));
    let empty = Lane::default;
    let sign = |words, lane, is_lost, count| Sign { words, lane, is_lost, count };
    let end = |words, outcome, count| {
        let lane = Lane { runs: vec![piece(outcome)], ..empty() };
        Sign { words, lane, is_lost: Lost::AmongRuns, count }
    };
    let windows = Lane { windows: vec![whole], ..empty() };
    let waits = Lane { waits: vec![whole], ..empty() };
    let runs = Lane { runs: vec![piece(RunOutcome::Succeeded)], ..empty() };
    let pauses = Lane { pauses: vec![whole], ..empty() };
    let gaps = Lane { gaps: vec![whole], ..empty() };
    let misses = Lane { misses: vec![at(5)], ..empty() };
    [
        sign("window", windows, Lost::Never, |lane| lane.windows.len()),
        sign("waits", waits, Lost::Never, |lane| lane.waits.len()),
        sign("runs", runs, Lost::Never, |lane| lane.runs.len()),
        sign("paused", pauses, Lost::AmongItsLike, |lane| lane.pauses.len()),
        end("to be run again", RunOutcome::Preempted, |lane| ends(lane, &[RunOutcome::Preempted])),
        end("failed or ended", RunOutcome::Failed, |lane| {
            ends(lane, &[RunOutcome::Failed, RunOutcome::Aborted])
        }),
        end("goes on", RunOutcome::Unfinished, |lane| ends(lane, &[RunOutcome::Unfinished])),
        sign("gap", gaps, Lost::AmongItsLike, |lane| lane.gaps.len()),
        sign("missed", misses, Lost::Never, |lane| lane.misses.len()),
    ]
}

fn piece(outcome: RunOutcome) -> Bar {
    let span = (Duration::ZERO, Duration::from_secs(10));
    Bar { span, outcome, last: true, task: 0, words: String::new(), tip: String::new() }
}

fn ends(lane: &Lane, outcomes: &[RunOutcome]) -> usize {
    lane.runs.iter().filter(|bar| bar.last && outcomes.contains(&bar.outcome)).count()
}
