//! Colours, axes, and the few shapes that the picture is made of.

use std::ops::RangeInclusive;

use svg::node::element::path::Data;
use svg::node::element::{Line, Path, Rectangle, Text};

// The colours of Okabe and Ito, which colour-blind people can tell apart; green
// and vermillion a little darker, so that words in them can be read. What
// colours tell is also told by place, dash or label.
pub(super) const BLUE: &str = "#0072B2";
pub(super) const SKY: &str = "#56B4E9";
pub(super) const ORANGE: &str = "#E69F00";
pub(super) const GREEN: &str = "#007A5A";
pub(super) const VERMILLION: &str = "#C04F00";
pub(super) const PURPLE: &str = "#CC79A7";
pub(super) const INK: &str = "#24292F";
pub(super) const GREY: &str = "#57606A";
pub(super) const LINE: &str = "#8C959F";
pub(super) const RULE: &str = "#D0D7DE";
pub(super) const SHADE: &str = "#EFF1F3";

/// The size of letters.
pub(super) const TEXT: f32 = 11.5;

/// Where values are drawn.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    values: RangeInclusive<f32>,
    at: (f32, f32),
}

impl Axis {
    /// Draws the first of these values at `at.0`, and the last at `at.1`.
    pub(super) fn new(values: RangeInclusive<f32>, at: (f32, f32)) -> Self {
        Self { values, at }
    }

    /// The place of this value, to a tenth of a pixel; at an end of the axis if
    /// the value lies beyond.
    pub(super) fn place(&self, value: f32) -> f32 {
        let (low, high) = (*self.values.start(), *self.values.end());
        let part = (value.clamp(low, high) - low) / (high - low);
        tenth(self.at.0 + part * (self.at.1 - self.at.0))
    }

    pub(super) fn low(&self) -> f32 {
        *self.values.start()
    }

    pub(super) fn high(&self) -> f32 {
        *self.values.end()
    }

    /// Where it begins and ends.
    pub(super) fn ends(&self) -> (f32, f32) {
        self.at
    }

    /// The multiples of `step` on it.
    pub(super) fn ticks(&self, step: u16) -> impl Iterator<Item = f32> {
        let multiples = (0_u16..).map(move |nth| f32::from(nth) * f32::from(step));
        multiples.skip_while(|tick| *tick < self.low()).take_while(|tick| *tick <= self.high())
    }
}

fn tenth(place: f32) -> f32 {
    (place * 10.0).round() / 10.0
}

/// Words of which the first begins at this place. Their white edge keeps lines
/// off them.
pub(super) fn text(x: f32, y: f32, words: &str) -> Text {
    let text = Text::new(words).set("x", tenth(x)).set("y", tenth(y));
    let edged = text.set("stroke", "white").set("stroke-width", 3).set("stroke-linejoin", "round");
    edged.set("paint-order", "stroke")
}

/// About how long these words are. Nobody knows the reader's font; this is
/// right for Helvetica and a little too much for most others.
pub(super) fn length(words: &str) -> f32 {
    f32::from(u16::try_from(words.chars().count()).unwrap_or(u16::MAX)) * TEXT * 0.53
}

pub(super) fn line(from: (f32, f32), to: (f32, f32), colour: &str) -> Line {
    let line = Line::new().set("x1", from.0).set("y1", from.1).set("x2", to.0).set("y2", to.1);
    line.set("stroke", colour)
}

/// A filled rectangle.
pub(super) fn bar(x: (f32, f32), top: f32, height: f32, colour: &str) -> Rectangle {
    let bar = Rectangle::new().set("x", x.0).set("y", top).set("width", tenth(x.1 - x.0));
    bar.set("height", height).set("fill", colour)
}

/// A line of two pixels.
pub(super) fn curve(data: Data, colour: &str) -> Path {
    let path = Path::new().set("d", data).set("fill", "none");
    path.set("stroke", colour).set("stroke-width", 2)
}

/// The line through these points.
pub(super) fn through(points: impl IntoIterator<Item = (f32, f32)>) -> Data {
    let mut points = points.into_iter();
    let start = points.next().map(|first| Data::new().move_to(first)).unwrap_or_default();
    points.fold(start, Data::line_to)
}

/// The line that holds each value until the next.
pub(super) fn steps(points: impl IntoIterator<Item = (f32, f32)>) -> Data {
    let mut points = points.into_iter();
    let Some(first) = points.next() else { return Data::new() };
    let (mut data, mut last) = (Data::new().move_to(first), first);
    for (x, y) in points {
        if y != last.1 {
            data = data.horizontal_line_to(x).vertical_line_to(y);
        }
        last = (x, y);
    }
    data.horizontal_line_to(last.0)
}
