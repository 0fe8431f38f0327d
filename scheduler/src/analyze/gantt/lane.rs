//! Draws one row.

use svg::node::element::Group;

use crate::analyze::gantt::dense::{is_crowded, stretches};
use crate::analyze::gantt::pen::{
    BAD, GREY, RUN, RUN_EDGE, TONES, WAIT, WINDOW, WINDOW_EDGE, bar, cross, head, length, line,
    text, tip,
};
use crate::analyze::gantt::rows::{Bar, Lane, Span};
use crate::analyze::gantt::scale::Scale;
use crate::analyze::report::RunOutcome;

/// Where the row is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) top: f64,
    pub(super) height: f64,
}

impl Place {
    fn middle(self) -> f64 {
        self.top + self.height / 2.0
    }

    /// A bar of this part of the height, in the middle.
    fn part(self, part: f64) -> (f64, f64) {
        let height = self.height * part;
        (self.middle() - height / 2.0, height)
    }
}

/// How much of a row's height each thing has: told apart without colours, too.
const WINDOW_HEIGHT: f64 = 0.86;
const RUN_HEIGHT: f64 = 0.62;
const WAIT_HEIGHT: f64 = 0.2;

pub(super) fn draw(lane: &Lane, place: Place, scale: &Scale) -> Group {
    let group = windows(Group::new(), lane, place, scale);
    let group = waits(group, lane, place, scale);
    let group = gaps(group, lane, place, scale);
    let group = pauses(group, lane, place, scale);
    let group = runs(group, lane, place, scale);
    misses(group, lane, place, scale)
}

fn seen(span: &Span, scale: &Scale) -> Option<(f64, f64)> {
    (span.0 <= scale.until()).then(|| (scale.place(span.0), scale.place(span.1)))
}

fn windows(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    let (top, height) = place.part(WINDOW_HEIGHT);
    if is_crowded(lane.windows.len(), scale) {
        return shaded(group, lane.windows.iter().copied(), (top, height), WINDOW, scale);
    }
    let windows = lane.windows.iter().filter_map(|span| seen(span, scale));
    windows.fold(group, |group, (from, until)| {
        let ends = [from, until].map(|x| line((x, top), (x, top + height), WINDOW_EDGE));
        let [opens, closes] = ends;
        group.add(bar((from, until), top, height, WINDOW)).add(opens).add(closes)
    })
}

/// A stretch is as strong as it is covered.
fn shaded(
    group: Group,
    spans: impl Iterator<Item = Span>,
    (top, height): (f64, f64),
    colour: &str,
    scale: &Scale,
) -> Group {
    stretches(spans, scale).iter().fold(group, |group, stretch| {
        let strength = 0.15 + 0.85 * stretch.covered;
        let shade = bar((stretch.from, stretch.until), top, height, colour);
        group.add(shade.set("fill-opacity", format!("{strength:.2}")))
    })
}

fn waits(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    let (top, height) = place.part(WAIT_HEIGHT);
    if is_crowded(lane.waits.len(), scale) {
        return shaded(group, lane.waits.iter().copied(), (top, height), WAIT, scale);
    }
    let waits = lane.waits.iter().filter_map(|span| seen(span, scale));
    waits.fold(group, |group, span| group.add(bar(span, top, height, WAIT)))
}

fn gaps(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    if is_crowded(lane.gaps.len(), scale) {
        return group;
    }
    let (top, height) = place.part(RUN_HEIGHT);
    let gaps = lane.gaps.iter().filter_map(|span| seen(span, scale));
    gaps.fold(group, |group, span| {
        let edge = bar(span, top, height, "none").set("stroke", GREY);
        group.add(edge.set("stroke-dasharray", "2 2").set("stroke-width", 0.8))
    })
}

fn pauses(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    if is_crowded(lane.pauses.len(), scale) {
        return group;
    }
    let (top, height) = place.part(RUN_HEIGHT);
    let pauses = lane.pauses.iter().filter_map(|span| seen(span, scale));
    pauses.fold(group, |group, span| {
        let still = bar(span, top, height, "url(#still)");
        group.add(still.set("stroke", RUN_EDGE).set("stroke-width", 0.8))
    })
}

fn runs(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    let (top, height) = place.part(RUN_HEIGHT);
    if is_crowded(lane.runs.len(), scale) {
        let spans = lane.runs.iter().map(|bar| bar.span);
        return shaded(group, spans, (top, height), RUN, scale);
    }
    lane.runs.iter().fold(group, |group, run| {
        let Some(span) = seen(&run.span, scale) else { return group };
        group.add(piece(run, lane.mixed, span, (top, height)))
    })
}

fn piece(run: &Bar, mixed: bool, span: (f64, f64), (top, height): (f64, f64)) -> Group {
    let colour = colour(run, mixed);
    let shape = bar(span, top, height, colour).set("rx", 1);
    let group = end(Group::new().add(tip(&run.tip)).add(shape), run, span.1, (top, height));
    if span.1 - span.0 <= length(&run.words) + 6.0 || height <= 9.0 {
        return group;
    }
    let words = text((span.0 + span.1) / 2.0, top + height / 2.0 + 3.6, &run.words);
    group.add(words.set("text-anchor", "middle").set("fill", "white").set("font-size", 10))
}

/// Neighbours of several tasks differ in tone.
fn colour(run: &Bar, mixed: bool) -> &'static str {
    TONES.get(run.task % TONES.len()).filter(|_| mixed).map_or(RUN, |tone| *tone)
}

/// How the run ends, unless it succeeds.
fn end(group: Group, run: &Bar, x: f64, (top, height): (f64, f64)) -> Group {
    let colour = match run.outcome {
        _ if !run.last => return group,
        RunOutcome::Succeeded => return group,
        RunOutcome::Unfinished => return group.add(head(x, top, height, RUN)),
        RunOutcome::Failed | RunOutcome::Aborted => BAD,
        RunOutcome::Preempted => WAIT,
    };
    group.add(bar((x - 3.0, x), top - 2.0, height + 4.0, colour))
}

/// Crosses that would lie on each other are one.
fn misses(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    let mut last = f64::MIN;
    let places = lane.misses.iter().filter(|at| **at <= scale.until());
    let places = places.map(|at| scale.place(*at)).filter(|x| {
        let apart = *x - last >= 5.0;
        if apart {
            last = *x;
        }
        apart
    });
    places.fold(group, |group, x| group.add(cross(x, place.middle())))
}
