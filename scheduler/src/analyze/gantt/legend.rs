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
    for (words, sign, is_used) in signs() {
        if lanes().any(is_used) {
            group = group.add(sample(&sign, x, middle)).add(said(words, x, middle));
            x += SIGN + length(words) + 22.0;
        }
    }
    if lanes().any(|lane| is_crowded(lane.runs.len(), scale)) {
        let words = "paler: part of the time";
        let pale = bar((x, x + SIGN), middle - 6.0, 12.0, TONES[0]).set("fill-opacity", "0.35");
        group = group.add(pale).add(said(words, x, middle));
    }
    group
}

fn said(words: &str, x: f64, middle: f64) -> svg::node::element::Text {
    text(x + SIGN + 6.0, middle + 4.0, words).set("fill", GREY)
}

/// The sign as the rows draw it.
fn sample(lane: &Lane, x: f64, middle: f64) -> Group {
    let scale = Scale::new(Duration::from_secs(10), x, x + SIGN);
    lane::draw(lane, Place { top: middle - 10.0, height: 20.0 }, &scale)
}

type Sign = (&'static str, Lane, fn(&Lane) -> bool);

fn signs() -> [Sign; 9] {
    let at = Duration::from_secs;
    let whole = (at(0), at(10));
    let run = |outcome| Lane { runs: vec![piece(outcome)], ..Lane::default() };
    [
        ("window", Lane { windows: vec![whole], ..Lane::default() }, |lane| {
            !lane.windows.is_empty()
        }),
        ("waits", Lane { waits: vec![whole], ..Lane::default() }, |lane| !lane.waits.is_empty()),
        ("runs", run(RunOutcome::Succeeded), |lane| !lane.runs.is_empty()),
        ("paused", Lane { pauses: vec![whole], ..Lane::default() }, |lane| !lane.pauses.is_empty()),
        ("to be run again", run(RunOutcome::Preempted), |lane| {
            ends_with(lane, &[RunOutcome::Preempted])
        }),
        ("failed or ended", run(RunOutcome::Failed), |lane| {
            ends_with(lane, &[RunOutcome::Failed, RunOutcome::Aborted])
        }),
        ("goes on", run(RunOutcome::Unfinished), |lane| ends_with(lane, &[RunOutcome::Unfinished])),
        ("gap", Lane { gaps: vec![whole], ..Lane::default() }, |lane| !lane.gaps.is_empty()),
        ("missed", Lane { misses: vec![at(5)], ..Lane::default() }, |lane| !lane.misses.is_empty()),
    ]
}

fn piece(outcome: RunOutcome) -> Bar {
    let span = (Duration::ZERO, Duration::from_secs(10));
    Bar { span, outcome, last: true, task: 0, words: String::new(), tip: String::new() }
}

fn ends_with(lane: &Lane, outcomes: &[RunOutcome]) -> bool {
    lane.runs.iter().any(|bar| bar.last && outcomes.contains(&bar.outcome))
}
