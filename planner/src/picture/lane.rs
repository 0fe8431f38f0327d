//! One row of the picture: an activity, or several of a kind.

use svg::node::element::{Group, Path};

use crate::picture::pen::{
    BAD, HEAT, INK, MANDATORY, OPTIONAL, RANGE, RANGE_EDGE, bar, cross, haloed, length, line,
    shape, shortened, tip,
};
use crate::picture::scale::Scale;
use crate::units::Time;

/// From, until.
pub(super) type Stretch = (Time, Time);

/// What is drawn in one row.
#[derive(Clone, Debug, Default)]
pub(super) struct Lane {
    pub(super) label: String,
    /// Right of the label.
    pub(super) note: String,
    /// Whether it must not be left out.
    pub(super) mandatory: bool,
    /// Start ranges: from, to, cutoff.
    pub(super) ranges: Vec<(Time, Time, Time)>,
    pub(super) preheats: Vec<Stretch>,
    pub(super) bars: Vec<Bar>,
    pub(super) pauses: Vec<Stretch>,
    /// Planned, where what is drawn is what happened.
    pub(super) planned: Vec<Stretch>,
    /// Why it is left out, and when that would have been.
    pub(super) out: Option<(String, Option<Time>)>,
}

/// A piece of a run.
#[derive(Clone, Debug)]
pub(super) struct Bar {
    pub(super) span: Stretch,
    /// Where its minimum ends, if it was given more.
    pub(super) minimum: Option<Time>,
    pub(super) mandatory: bool,
    pub(super) ending: Ending,
    /// Whether it began before it was planned.
    pub(super) early: bool,
    /// What is written beside it.
    pub(super) words: String,
    pub(super) tip: String,
}

/// How a run ends, where that is to be seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Ending {
    /// As it should, or with a pause.
    #[default]
    Quiet,
    /// Earlier than it was planned.
    Early,
    /// In a malfunction.
    Failed,
    /// By the control thread.
    Aborted,
}

/// Where the row is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) top: f64,
    pub(super) height: f64,
}

impl Place {
    pub(super) fn middle(self) -> f64 {
        self.top + self.height / 2.0
    }

    /// A bar of this part of the height, in the middle.
    fn part(self, part: f64) -> (f64, f64) {
        let height = self.height * part;
        (self.middle() - height / 2.0, height)
    }
}

/// How much of a row's height each thing has: told apart without colours, too.
const RANGE_HEIGHT: f64 = 0.8;
const RUN_HEIGHT: f64 = 0.6;
const HEAT_HEIGHT: f64 = 0.3;

pub(super) fn draw(lane: &Lane, place: Place, scale: &Scale) -> Group {
    let group = ranges(Group::new(), lane, place, scale);
    let group = preheats(group, lane, place, scale);
    let group = pauses(group, lane, place, scale);
    let group = lane.bars.iter().fold(group, |group, bar| group.add(run(lane, bar, place, scale)));
    let group = planned(group, lane, place, scale);
    match &lane.out {
        Some((words, at)) => group.add(out(lane, words, *at, place, scale)),
        None => group,
    }
}

/// Where it could start, and by when it has to end.
fn ranges(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    let (top, height) = place.part(RANGE_HEIGHT);
    let seen = lane.ranges.iter().filter_map(|(from, to, cutoff)| {
        let (left, right) = scale.seen(*from, *to)?;
        Some((left, right, scale.place(*cutoff), *cutoff <= scale.until))
    });
    seen.fold(group, |group, (left, right, cutoff, ends)| {
        let group = group.add(bar((left, right), top, height, RANGE));
        if lane.out.is_some() {
            // Words are written there.
            return group;
        }
        let wire = line((right, place.middle()), (cutoff, place.middle()), RANGE_EDGE);
        let group = group.add(wire.set("stroke-width", 0.9).set("stroke-dasharray", "2 2"));
        if !ends {
            return group;
        }
        let stop = (place.middle() - height * 0.35, place.middle() + height * 0.35);
        group.add(line((cutoff, stop.0), (cutoff, stop.1), RANGE_EDGE).set("stroke-width", 1.4))
    })
}

fn preheats(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    let (top, height) = place.part(HEAT_HEIGHT);
    let seen = lane.preheats.iter().filter_map(|(from, until)| scale.seen(*from, *until));
    seen.fold(group, |group, span| group.add(bar(span, top, height, HEAT)))
}

fn pauses(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    let (top, height) = place.part(RUN_HEIGHT);
    let colour = colour(lane.mandatory);
    let seen = lane.pauses.iter().filter_map(|(from, until)| scale.seen(*from, *until));
    seen.fold(group, |group, span| {
        let still = bar(span, top, height, "white").set("stroke", colour);
        group.add(still.set("stroke-width", 1).set("stroke-dasharray", "2 2"))
    })
}

fn planned(group: Group, lane: &Lane, place: Place, scale: &Scale) -> Group {
    let (top, height) = place.part(RANGE_HEIGHT);
    let seen = lane.planned.iter().filter_map(|(from, until)| scale.seen(*from, *until));
    seen.fold(group, |group, span| {
        group.add(bar(span, top, height, "none").set("stroke", INK).set("stroke-width", 0.9))
    })
}

const fn colour(mandatory: bool) -> &'static str {
    if mandatory { MANDATORY } else { OPTIONAL }
}

fn run(lane: &Lane, run: &Bar, place: Place, scale: &Scale) -> Group {
    let Some((from, until)) = scale.seen(run.span.0, run.span.1) else { return Group::new() };
    let (top, height) = place.part(RUN_HEIGHT);
    let colour = colour(run.mandatory);
    let minimum = run.minimum.map_or(until, |end| scale.place(end));
    let mut group = Group::new().add(tip(&run.tip));
    if minimum < until {
        let stripes = if run.mandatory { "url(#more-mandatory)" } else { "url(#more-optional)" };
        let more = bar((minimum, until), top, height, stripes);
        group = group.add(more.set("stroke", colour).set("stroke-width", 0.8));
    }
    let group = group.add(bar((from, minimum), top, height, colour).set("rx", 1));
    let group = if run.early { group.add(arrow(from, place)) } else { group };
    let group = ending(group, run.ending, until, (top, height));
    if run.words.is_empty() {
        return group;
    }
    group.add(beside(lane, &run.words, (from, until), place, scale))
}

/// Began before its time: the head of an arrow that points there.
fn arrow(x: f64, place: Place) -> Path {
    let y = place.middle();
    shape(&[(x - 6.0, y), (x, y - 4.5), (x, y + 4.5)], INK)
}

fn ending(group: Group, ending: Ending, x: f64, (top, height): (f64, f64)) -> Group {
    let cap = |colour| bar((x - 3.0, x), top - 2.5, height + 5.0, colour);
    match ending {
        Ending::Quiet => group,
        Ending::Early => {
            let y = top + height / 2.0;
            group.add(shape(&[(x + 1.0, y), (x + 6.5, y - 4.0), (x + 6.5, y + 4.0)], RANGE_EDGE))
        }
        Ending::Failed => group.add(cap(INK)),
        Ending::Aborted => group.add(cap(BAD)),
    }
}

/// To the right, or to the left where the picture ends.
fn beside(
    lane: &Lane,
    words: &str,
    (from, until): (f64, f64),
    place: Place,
    scale: &Scale,
) -> Group {
    let y = place.middle() + 3.7;
    let begin = beyond(lane, (until + 9.0, length(words)), scale);
    if begin + 1.0 + length(words) <= scale.right {
        return haloed(begin, y, words);
    }
    haloed(from - 9.0, y, words).set("text-anchor", "end")
}

/// Left out: where it would have broken something, and what.
fn out(lane: &Lane, words: &str, at: Option<Time>, place: Place, scale: &Scale) -> Group {
    let seen = at.and_then(|at| scale.seen(at, at)).map(|(x, _)| x);
    let first = lane.ranges.first().map_or(scale.left, |(from, ..)| scale.place(*from));
    let x = seen.unwrap_or(first);
    let group = Group::new().add(tip(words));
    let group = if seen.is_some() { group.add(cross(x, place.middle())) } else { group };
    let words = shortened(words, scale.right - scale.left);
    let y = place.middle() + 3.7;
    let wide = length(&words) * 0.95;
    let begin = beyond(lane, (x + 9.0, wide), scale);
    if begin + 1.0 + wide <= scale.right {
        return group.add(haloed(begin, y, &words));
    }
    let end = before(lane, (x - 9.0, wide), scale).max(scale.left + wide).min(scale.right);
    group.add(haloed(end, y, &words).set("text-anchor", "end"))
}

/// Where words begin that are not to lie on what was planned.
fn beyond(lane: &Lane, (begin, wide): (f64, f64), scale: &Scale) -> f64 {
    let hit = outlines(lane, (begin, begin + wide), scale);
    hit.map(|(_, right)| right + 6.0).fold(begin, f64::max)
}

/// Where words end that are not to lie on what was planned.
fn before(lane: &Lane, (end, wide): (f64, f64), scale: &Scale) -> f64 {
    let hit = outlines(lane, (end - wide, end), scale);
    hit.map(|(left, _)| left - 6.0).fold(end, f64::min)
}

/// Outlines that meet these places.
fn outlines(
    lane: &Lane,
    (begin, end): (f64, f64),
    scale: &Scale,
) -> impl Iterator<Item = (f64, f64)> {
    let planned = lane.planned.iter().filter_map(|(from, until)| scale.seen(*from, *until));
    planned.filter(move |(left, right)| *left < end && begin < *right)
}
