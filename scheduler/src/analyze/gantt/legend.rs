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
    let is_crowded = |lane: &Lane| is_crowded(lane.runs.len(), scale);
    for Sign { words, lane, is_end, is_used } in signs() {
        // Runs that cannot be told apart are drawn without their ends.
        if lanes().any(|lane| is_used(lane) && !(is_end && is_crowded(lane))) {
            group = group.add(sample(&lane, x, middle)).add(said(words, x, middle));
            x += SIGN + length(words) + 30.0;
        }
    }
    if lanes().any(is_crowded) {
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
    /// Whether it is the end of a run.
    is_end: bool,
    is_used: fn(&Lane) -> bool,
}

fn signs() -> [Sign; 9] {
    let at = Duration::from_secs;
    let whole = (at(0), at(10));
    let empty = Lane::default;
    let sign = |words, lane, is_used| Sign { words, lane, is_end: false, is_used };
    let end = |words, outcome, is_used| {
        let lane = Lane { runs: vec![piece(outcome)], ..empty() };
        Sign { words, lane, is_end: true, is_used }
    };
    [
        sign("window", Lane { windows: vec![whole], ..empty() }, |lane| !lane.windows.is_empty()),
        sign("waits", Lane { waits: vec![whole], ..empty() }, |lane| !lane.waits.is_empty()),
        sign("runs", Lane { runs: vec![piece(RunOutcome::Succeeded)], ..empty() }, |lane| {
            !lane.runs.is_empty()
        }),
        sign("paused", Lane { pauses: vec![whole], ..empty() }, |lane| !lane.pauses.is_empty()),
        end("to be run again", RunOutcome::Preempted, |lane| {
            ends_with(lane, &[RunOutcome::Preempted])
        }),
        end("failed or ended", RunOutcome::Failed, |lane| {
            ends_with(lane, &[RunOutcome::Failed, RunOutcome::Aborted])
        }),
        end("goes on", RunOutcome::Unfinished, |lane| ends_with(lane, &[RunOutcome::Unfinished])),
        sign("gap", Lane { gaps: vec![whole], ..empty() }, |lane| !lane.gaps.is_empty()),
        sign("missed", Lane { misses: vec![at(5)], ..empty() }, |lane| !lane.misses.is_empty()),
    ]
}

fn piece(outcome: RunOutcome) -> Bar {
    let span = (Duration::ZERO, Duration::from_secs(10));
    Bar { span, outcome, last: true, task: 0, words: String::new(), tip: String::new() }
}

fn ends_with(lane: &Lane, outcomes: &[RunOutcome]) -> bool {
    lane.runs.iter().any(|bar| bar.last && outcomes.contains(&bar.outcome))
}
