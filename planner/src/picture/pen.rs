//! Colours, and the few shapes that the picture is made of.

use svg::node::element::path::Data;
use svg::node::element::{Line, Path, Pattern, Rectangle, Text, Title};

// The colours of Okabe and Ito, which colour-blind people can tell apart. What
// they tell is also told by height, hatch or sign.
pub(super) const MANDATORY: &str = "#0072B2";
pub(super) const OPTIONAL: &str = "#56B4E9";
pub(super) const HEAT: &str = "#E69F00";
pub(super) const RADIO: &str = "#CC79A7";
pub(super) const RADIO_SHADE: &str = "#F8ECF3";
pub(super) const BAD: &str = "#C04F00";
pub(super) const UP: &str = "#F5D97A";
pub(super) const DOWN: &str = "#44546A";
pub(super) const NIGHT: &str = "#EEF1F6";
pub(super) const RANGE: &str = "#DCEBDD";
pub(super) const RANGE_EDGE: &str = "#5F9E6E";
pub(super) const CURVE: &str = "#1B4F72";
pub(super) const INK: &str = "#24292F";
pub(super) const GREY: &str = "#57606A";
pub(super) const RULE: &str = "#E3E7EB";
pub(super) const EDGE: &str = "#C6CDD5";
pub(super) const SHADE: &str = "#F6F8FA";

/// The size of letters.
pub(super) const TEXT: f64 = 11.5;
/// The size of letters beside the point.
pub(super) const SMALL: f64 = 10.5;

/// To a tenth of a pixel: the same digits everywhere.
pub(super) fn tenth(place: f64) -> f64 {
    (place * 10.0).round() / 10.0
}

/// About how long these words are. Nobody knows the reader's font; this is
/// right for Helvetica, in words of many small letters.
pub(super) fn length(words: &str) -> f64 {
    let letters = u32::try_from(words.chars().count()).unwrap_or(u32::MAX);
    f64::from(letters) * TEXT * 0.5
}

/// The beginning of these words, if they are longer than that.
pub(super) fn shortened(words: &str, longest: f64) -> String {
    if length(words) <= longest {
        return words.to_owned();
    }
    let mut short = words.to_owned();
    while length(&short) + TEXT > longest && short.pop().is_some() {}
    format!("{}\u{2026}", short.trim_end())
}

pub(super) fn text(x: f64, y: f64, words: &str) -> Text {
    Text::new(words).set("x", tenth(x)).set("y", tenth(y)).set("fill", INK)
}

/// Words beside the point, that end here.
pub(super) fn note(x: f64, y: f64, words: &str) -> Text {
    text(x, y, words).set("text-anchor", "end").set("fill", GREY).set("font-size", SMALL)
}

/// Words that can be read whatever lies under them.
pub(super) fn haloed(x: f64, y: f64, words: &str) -> Text {
    text(x, y, words)
        .set("stroke", "white")
        .set("stroke-width", 3)
        .set("stroke-linejoin", "round")
        .set("paint-order", "stroke")
        .set("font-size", SMALL)
}

pub(super) fn line(from: (f64, f64), to: (f64, f64), colour: &str) -> Line {
    Line::new()
        .set("x1", tenth(from.0))
        .set("y1", tenth(from.1))
        .set("x2", tenth(to.0))
        .set("y2", tenth(to.1))
        .set("stroke", colour)
}

/// A filled rectangle, never thinner than can be seen.
pub(super) fn bar(x: (f64, f64), top: f64, height: f64, colour: &str) -> Rectangle {
    let (from, until) = (tenth(x.0), tenth(x.1));
    Rectangle::new()
        .set("x", from)
        .set("y", tenth(top))
        .set("width", tenth((until - from).max(0.6)))
        .set("height", tenth(height))
        .set("fill", colour)
}

/// What a pointer that rests on it is shown.
pub(super) fn tip(words: &str) -> Title {
    Title::new(words)
}

/// Straight lines from point to point.
pub(super) fn path(points: &[(f64, f64)]) -> Data {
    let mut points = points.iter().map(|(x, y)| (tenth(*x), tenth(*y)));
    let Some(first) = points.next() else { return Data::new() };
    points.fold(Data::new().move_to(first), Data::line_to)
}

/// A filled shape with these corners.
pub(super) fn shape(corners: &[(f64, f64)], colour: &str) -> Path {
    Path::new().set("d", path(corners).close()).set("fill", colour)
}

/// Straight lines, not filled.
pub(super) fn curve(points: &[(f64, f64)], colour: &str) -> Path {
    Path::new()
        .set("d", path(points))
        .set("fill", "none")
        .set("stroke", colour)
        .set("stroke-linejoin", "round")
}

/// Something that is not to be: a saltire.
pub(super) fn cross(x: f64, y: f64) -> Path {
    let arm = 3.4;
    let data = Data::new()
        .move_to((tenth(x - arm), tenth(y - arm)))
        .line_by((2.0 * arm, 2.0 * arm))
        .move_to((tenth(x + arm), tenth(y - arm)))
        .line_by((-2.0 * arm, 2.0 * arm));
    Path::new().set("d", data).set("stroke", BAD).set("stroke-width", 1.8).set("fill", "none")
}

/// Stripes of this colour on white; `name` is what it is filled by.
pub(super) fn stripes(name: &str, colour: &str) -> Pattern {
    Pattern::new()
        .set("id", name)
        .set("width", 5)
        .set("height", 5)
        .set("patternUnits", "userSpaceOnUse")
        .set("patternTransform", "rotate(45)")
        .add(bar((0.0, 5.0), 0.0, 5.0, "white"))
        .add(line((0.0, 0.0), (0.0, 5.0), colour).set("stroke-width", 4.6))
}
