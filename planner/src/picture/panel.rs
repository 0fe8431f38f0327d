//! A timeline's values, with its limits.

use svg::node::element::Group;

use crate::picture::pen::{
    BAD, CURVE, EDGE, GREY, NIGHT, RULE, SMALL, bar, curve, length, line, note, shape, shortened,
    text,
};
use crate::picture::scale::{Scale, float};
use crate::units::Time;

/// What is drawn.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub(super) title: String,
    /// What the numbers count.
    pub(super) unit: &'static str,
    /// Whether they count what has no parts.
    pub(super) whole: bool,
    pub(super) height: f64,
    pub(super) points: Vec<(Time, f64)>,
    /// Whether values change at once.
    pub(super) steps: bool,
    /// As planned, where the points are what happened.
    pub(super) planned: Vec<(Time, f64)>,
    pub(super) limits: Vec<Line>,
    /// The numbers at the top and the bottom.
    pub(super) range: (f64, f64),
}

/// A limit.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) words: String,
    pub(super) value: f64,
    pub(super) kind: Kind,
}

/// What a limit forbids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// What lies above it.
    Above,
    /// What lies below it.
    Below,
    /// What lies below it, and ends what runs.
    Hard,
    /// What lies below it at one instant.
    At(Time),
}

/// Where things of the panel are.
struct Frame<'a> {
    panel: &'a Panel,
    top: f64,
    scale: &'a Scale,
}

/// Space above the curve for nothing but air.
const AIR: f64 = 4.0;

pub(super) fn draw(
    panel: &Panel,
    top: f64,
    label: (f64, f64),
    sleeps: &[(Time, Time)],
    scale: &Scale,
) -> Group {
    let frame = Frame { panel, top, scale };
    let group = Group::new();
    let group = sleeps.iter().fold(group, |group, (from, until)| {
        group.add(bar((scale.place(*from), scale.place(*until)), top, panel.height, NIGHT))
    });
    let group = frame.numbers(group);
    let group = frame.curves(group);
    let group = frame.limits(group, label);
    let title = shortened(&panel.title, label.1 - label.0 - frame.names());
    let title = text(label.0, top + 14.0, &title).set("font-weight", "bold");
    let unit = text(label.0, top + 29.0, panel.unit).set("fill", GREY).set("font-size", SMALL);
    group.add(title).add(unit)
}

impl Frame<'_> {
    fn place(&self, value: f64) -> f64 {
        let (low, high) = self.panel.range;
        let part = ((value - low) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        self.top + self.panel.height - part * (self.panel.height - AIR)
    }

    /// How much room the names of its limits take.
    fn names(&self) -> f64 {
        let names = self.panel.limits.iter().map(|limit| length(&limit.words));
        names.fold(0.0, f64::max)
    }

    fn bottom(&self) -> f64 {
        self.top + self.panel.height
    }

    /// Round numbers on the right, and faint lines.
    fn numbers(&self, group: Group) -> Group {
        let scale = self.scale;
        let group =
            numbers(self.panel.range, self.panel.whole).into_iter().fold(group, |group, value| {
                let y = self.place(value);
                let number = text(scale.right + 6.0, y + 3.5, &shown(value));
                group
                    .add(line((scale.left, y), (scale.right, y), RULE))
                    .add(number.set("fill", GREY).set("font-size", SMALL))
            });
        [self.top, self.bottom()]
            .into_iter()
            .fold(group, |group, y| group.add(line((scale.left, y), (scale.right, y), EDGE)))
    }

    fn curves(&self, group: Group) -> Group {
        let planned = self.trail(&self.panel.planned);
        let group = if planned.is_empty() {
            group
        } else {
            let dashed = curve(&planned, GREY).set("stroke-dasharray", "4 3");
            group.add(dashed.set("stroke-width", 1.1))
        };
        let trail = self.trail(&self.panel.points);
        let (Some(first), Some(last)) = (trail.first(), trail.last()) else { return group };
        let floor = self.place(0.0_f64.max(self.panel.range.0).min(self.panel.range.1));
        let mut area = vec![(first.0, floor)];
        area.extend(&trail);
        area.push((last.0, floor));
        group
            .add(shape(&area, CURVE).set("fill-opacity", "0.10"))
            .add(curve(&trail, CURVE).set("stroke-width", 1.7))
    }

    /// Where the values are; steps have corners.
    fn trail(&self, points: &[(Time, f64)]) -> Vec<(f64, f64)> {
        let mut trail: Vec<(f64, f64)> = Vec::new();
        for (at, value) in points {
            let (x, y) = (self.scale.place(*at), self.place(*value));
            if let Some((_, before)) = trail.last().filter(|_| self.panel.steps) {
                trail.push((x, *before));
            }
            trail.push((x, y));
        }
        if let Some((x, y)) = trail.last().copied().filter(|_| self.panel.steps) {
            trail.push((self.scale.right.max(x), y));
        }
        trail
    }

    fn limits(&self, group: Group, label: (f64, f64)) -> Group {
        let mut free = self.top + 4.0;
        let mut limits: Vec<&Line> = self.panel.limits.iter().collect();
        limits.sort_by(|a, b| b.value.total_cmp(&a.value));
        let mut group = group;
        for (nth, limit) in limits.iter().enumerate() {
            let y = self.place(limit.value);
            group = self.limit(group, limit, y);
            // Names that would lie on each other move down, and those below the
            // panel up.
            let below = limits.iter().skip(nth + 1).map(|_| 12.0).sum::<f64>();
            let named = (y + 3.5).min(self.bottom() + 3.5 - below).max(free);
            free = named + 12.0;
            group = group.add(note(label.1, named, &limit.words));
        }
        group
    }

    fn limit(&self, group: Group, limit: &Line, y: f64) -> Group {
        let scale = self.scale;
        let across = |colour: &str| line((scale.left - 6.0, y), (scale.right, y), colour);
        match limit.kind {
            Kind::Above | Kind::Below => {
                group.add(across(BAD).set("stroke-width", 1.2).set("stroke-dasharray", "6 3"))
            }
            Kind::Hard => group.add(across(BAD).set("stroke-width", 1.8)),
            Kind::At(at) => {
                let x = scale.place(at);
                let rhomb = [(x - 5.0, y), (x, y - 5.0), (x + 5.0, y), (x, y + 5.0)];
                let stub = line((scale.left - 6.0, y), (scale.left + 4.0, y), BAD);
                group.add(stub.set("stroke-width", 1.2)).add(shape(&rhomb, BAD))
            }
        }
    }
}

/// Two to six round numbers in a range.
fn numbers((low, high): (f64, f64), whole: bool) -> Vec<f64> {
    let raw = (high - low).max(f64::MIN_POSITIVE) / 4.0;
    let raw = if whole { raw.max(1.0) } else { raw };
    let power = 10.0_f64.powf(raw.log10().floor());
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0].map(|round| round * power);
    let fits = |step: &f64| *step >= raw * 0.99 && !(whole && step.fract() > 0.0);
    let step = steps.into_iter().find(fits).unwrap_or(power * 10.0);
    let first = (low / step).ceil();
    let numbers = (0..=6).map(|nth| (first + f64::from(nth)) * step);
    numbers.filter(|value| *value <= high + step * 1e-6).collect()
}

fn shown(value: f64) -> String {
    let value = if value == 0.0 { 0.0 } else { value };
    let shown = format!("{value:.1}");
    shown.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A part of a whole, in percent, for a place in the picture.
pub(super) fn percent(part: i64, whole: u64) -> f64 {
    let whole = i64::try_from(whole.max(1)).unwrap_or(i64::MAX);
    float(part) / float(whole) * 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beside_a_curve_are_round_and_few() {
        assert_eq!(numbers((20.0, 100.0), false), [20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(numbers((0.0, 430.0), false), [0.0, 200.0, 400.0]);
        for high in [1e-9, 0.3, 7.0, 12_345.0, 1e15] {
            assert!((2..=7).contains(&numbers((0.0, high), false).len()), "{high}");
        }
    }

    #[test]
    fn what_has_no_parts_is_counted_by_whole_numbers() {
        assert_eq!(numbers((-0.1, 1.1), true), [0.0, 1.0]);
        assert_eq!(numbers((0.0, 9.5), true), [0.0, 5.0]);
        for high in [1.0, 3.0, 43.0, 1e15] {
            let numbers = numbers((0.0, high), true);
            assert!(numbers.iter().all(|value| value.fract() == 0.0), "{numbers:?}");
            assert!((2..=7).contains(&numbers.len()), "{numbers:?}");
        }
    }

    #[test]
    fn a_number_is_said_without_a_tail() {
        assert_eq!([shown(12.5), shown(40.0), shown(-0.0)], ["12.5", "40", "0"]);
    }
}
