//! What the computer and the radio do: two rows that lie behind all others.

use svg::node::element::Group;

use crate::picture::lane::Place;
use crate::picture::pen::{
    DOWN, GREY, INK, RADIO, RADIO_SHADE, SMALL, UP, bar, length, shape, text, tip,
};
use crate::picture::scale::Scale;
use crate::picture::{Scene, happened};
use crate::plan::Kind;
use crate::state::Window;
use crate::timed::AwakePhase;
use crate::units::{Span, Time};
use crate::words::{Words, span};

/// When the computer is up: as planned, or as it was.
pub(super) fn awake(scene: &Scene<'_>) -> Vec<AwakePhase> {
    scene.trace.map_or_else(|| scene.timed.awake.clone(), happened::awake)
}

/// The row: down is dark, up is light, and what is between rises and falls.
pub(super) fn band(scene: &Scene<'_>, place: Place, scale: &Scale) -> Group {
    let phases = awake(scene);
    let (top, bottom) = (place.top + 3.0, place.top + place.height - 3.0);
    let night = bar((scale.left, scale.right), top, bottom - top, DOWN);
    let mut group = Group::new().add(night);
    for phase in &phases {
        let [wakeup, up, down, asleep] =
            [phase.wakeup, phase.up, phase.down, phase.asleep].map(|at| scale.place(at));
        let corners = [(wakeup, bottom), (up, top), (down, top), (asleep, bottom)];
        let said = said(scene, *phase);
        group = group.add(Group::new().add(tip(&said)).add(shape(&corners, UP)));
        group = group.add(inside("awake", phase.down.since(phase.up), (up, down), place, INK));
    }
    for (from, until) in sleeps(&phases, scale) {
        let place_of = (scale.place(from), scale.place(until));
        group = group.add(inside("asleep", until.since(from), place_of, place, "white"));
    }
    manual(scene, (top, bottom), scale).into_iter().fold(group, Group::add)
}

fn said(scene: &Scene<'_>, phase: AwakePhase) -> String {
    let words = Words::new(scene.plan, scene.parameters);
    let [wakeup, up, down, asleep] =
        [phase.wakeup, phase.up, phase.down, phase.asleep].map(|at| words.time(at));
    format!("wakes up {wakeup}, is up {up} to {down}, asleep {asleep}")
}

/// Between two awake phases, and before and after them.
pub(super) fn sleeps(phases: &[AwakePhase], scale: &Scale) -> Vec<(Time, Time)> {
    let begins = [scale.from].into_iter().chain(phases.iter().map(|phase| phase.asleep));
    let ends = phases.iter().map(|phase| phase.wakeup).chain([scale.until]);
    begins.zip(ends).filter(|(from, until)| from < until).collect()
}

/// The word, and for how long if there is room, too.
fn inside(what: &str, length_of: Span, x: (f64, f64), place: Place, colour: &str) -> Group {
    let minutes = length_of.get() / 60_000 * 60_000;
    let long = format!("{what} {}", span(minutes));
    let fitting = [long.as_str(), what].into_iter().find(|words| length(words) + 8.0 < x.1 - x.0);
    let Some(words) = fitting else { return Group::new() };
    let words = text((x.0 + x.1) / 2.0, place.middle() + 3.7, words).set("text-anchor", "middle");
    Group::new().add(words.set("fill", colour).set("font-size", SMALL))
}

/// Blocks of the ground's own are framed.
fn manual(scene: &Scene<'_>, (top, bottom): (f64, f64), scale: &Scale) -> Vec<Group> {
    let blocks = scene
        .plan
        .activities
        .iter()
        .filter(|activity| matches!(activity.kind, Kind::ManualShutdown { .. }));
    let spans = blocks.filter_map(|activity| {
        let begin = activity.starts.first()?.from;
        scale.seen(begin, begin.after(activity.duration))
    });
    let frames = spans.map(|span| {
        let frame = bar(span, top + 1.0, bottom - top - 2.0, "none").set("stroke", UP);
        Group::new()
            .add(tip("down by the ground's order"))
            .add(frame.set("stroke-width", 1.6).set("stroke-dasharray", "4 2"))
    });
    frames.collect()
}

/// Communication windows: as last queried, or as they were.
pub(super) fn windows<'a>(scene: &Scene<'a>) -> &'a [Window] {
    scene.trace.map_or(&scene.state.windows, |trace| &trace.windows)
}

/// The row of the radio.
pub(super) fn radio(scene: &Scene<'_>, place: Place, scale: &Scale) -> Group {
    let words = Words::new(scene.plan, scene.parameters);
    if windows(scene).is_empty() {
        let none = text(scale.left + 6.0, place.middle() + 3.7, "none").set("font-size", SMALL);
        return Group::new().add(none.set("fill", GREY));
    }
    let starts: Vec<f64> = windows(scene).iter().map(|window| scale.place(window.start)).collect();
    windows(scene).iter().fold(Group::new(), |group, window| {
        let Some((from, until)) = scale.seen(window.start, window.end) else { return group };
        let block = bar((from, until), place.top + 4.0, place.height - 8.0, RADIO);
        let (start, end) = (words.time(window.start), words.time(window.end));
        let said = format!("{}: {start} to {end}", window.name);
        let group = group.add(Group::new().add(tip(&said)).add(block.set("rx", 1)));
        // A name that would lie on the next window is in the tip alone.
        let wide = until + 8.0 + length(&window.name) * 0.95;
        if wide > scale.right || starts.iter().any(|next| *next > from && *next < wide) {
            return group;
        }
        let name = text(until + 5.0, place.middle() + 3.7, &window.name);
        group.add(name.set("font-size", SMALL).set("fill", GREY))
    })
}

/// Windows through all rows.
pub(super) fn shades(scene: &Scene<'_>, (top, bottom): (f64, f64), scale: &Scale) -> Group {
    let seen = windows(scene).iter().filter_map(|window| scale.seen(window.start, window.end));
    seen.fold(Group::new(), |group, span| group.add(bar(span, top, bottom - top, RADIO_SHADE)))
}
