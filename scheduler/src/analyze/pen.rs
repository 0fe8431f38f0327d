//! What the project's pictures are made of: colours, a few shapes, the sheet
//! that they are drawn on.
//!
//! The same for a schedule and for a plan, so that a sign means the same in
//! both. Places are rounded to tenths of a pixel, so that a picture is the same
//! wherever it is drawn.

use svg::Document;
use svg::node::element::path::Data;
use svg::node::element::{
    Definitions, Description, Group, Line, Path, Pattern, Rectangle, Text, Title,
};

// The colours of Okabe and Ito, which colour-blind people can tell apart. What
// they tell is also told by height, hatch or sign.
/// What runs.
pub const BLUE: &str = "#0072B2";
/// What has to wait, or to be warm.
pub const ORANGE: &str = "#E69F00";
/// Where something can be.
pub const GREEN: &str = "#DCEBDD";
/// Where that begins and ends.
pub const GREEN_EDGE: &str = "#5F9E6E";
/// What is not to be.
pub const BAD: &str = "#C04F00";
/// Words.
pub const INK: &str = "#24292F";
/// Words beside the point.
pub const GREY: &str = "#57606A";
/// Lines of a scale.
pub const RULE: &str = "#E3E7EB";
/// Where a part of the picture ends.
pub const EDGE: &str = "#D0D7DE";
/// Behind headings.
pub const SHADE: &str = "#F6F8FA";

/// The size of letters.
pub const TEXT: f64 = 11.5;
/// The size of letters beside the point.
pub const SMALL: f64 = 10.5;
/// What is left free at the edges.
pub const MARGIN: f64 = 18.0;

/// A sheet of this size, with a title and what there is to say of the whole.
#[must_use]
pub fn sheet(
    (width, height): (f64, f64),
    (title, about): (&str, &str),
    patterns: impl IntoIterator<Item = Pattern>,
) -> Document {
    let frame = bar((0.5, width - 0.5), 0.5, height - 1.0, "white");
    let patterns = patterns.into_iter().fold(Definitions::new(), Definitions::add);
    Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .set("role", "img")
        .set("font-family", "Helvetica, Arial, 'Liberation Sans', sans-serif")
        .set("font-size", TEXT)
        .add(Title::new(title))
        .add(Description::new().add(svg::node::Text::new(about)))
        .add(patterns)
        .add(frame.set("rx", 8).set("stroke", EDGE))
        .add(text(MARGIN, 30.0, title).set("font-size", 17).set("font-weight", "bold"))
        .add(text(MARGIN, 48.0, about).set("fill", GREY))
}

/// To a tenth of a pixel: the same digits everywhere.
#[must_use]
pub fn tenth(place: f64) -> f64 {
    (place * 10.0).round() / 10.0
}

/// About how long these words are. Nobody knows the reader's font; this is
/// right for Helvetica, in words of many small letters.
#[must_use]
pub fn length(words: &str) -> f64 {
    let letters = u32::try_from(words.chars().count()).unwrap_or(u32::MAX);
    f64::from(letters) * TEXT * 0.5
}

/// The beginning of these words, if they are longer than that.
#[must_use]
pub fn shortened(words: &str, longest: f64) -> String {
    if length(words) <= longest {
        return words.to_owned();
    }
    let mut short = words.to_owned();
    while length(&short) + TEXT > longest && short.pop().is_some() {}
    format!("{}\u{2026}", short.trim_end())
}

/// Words that begin here.
#[must_use]
pub fn text(x: f64, y: f64, words: &str) -> Text {
    Text::new(words).set("x", tenth(x)).set("y", tenth(y)).set("fill", INK)
}

/// Words beside the point, that end here.
#[must_use]
pub fn note(x: f64, y: f64, words: &str) -> Text {
    text(x, y, words).set("text-anchor", "end").set("fill", GREY).set("font-size", SMALL)
}

/// Words that can be read whatever lies under them: on a halo of their own,
/// since not every program draws an outline before what it encloses.
#[must_use]
pub fn haloed(x: f64, y: f64, words: &str) -> Group {
    let halo = text(x, y, words)
        .set("stroke", "white")
        .set("stroke-width", 3)
        .set("stroke-linejoin", "round")
        .set("aria-hidden", "true");
    Group::new().set("font-size", SMALL).add(halo).add(text(x, y, words))
}

/// A straight line.
#[must_use]
pub fn line(from: (f64, f64), to: (f64, f64), colour: &str) -> Line {
    Line::new()
        .set("x1", tenth(from.0))
        .set("y1", tenth(from.1))
        .set("x2", tenth(to.0))
        .set("y2", tenth(to.1))
        .set("stroke", colour)
}

/// A filled rectangle, never thinner than can be seen.
#[must_use]
pub fn bar(x: (f64, f64), top: f64, height: f64, colour: &str) -> Rectangle {
    let (from, until) = (tenth(x.0), tenth(x.1));
    Rectangle::new()
        .set("x", from)
        .set("y", tenth(top))
        .set("width", tenth((until - from).max(0.6)))
        .set("height", tenth(height))
        .set("fill", colour)
}

/// What a pointer that rests on it is shown.
#[must_use]
pub fn tip(words: &str) -> Title {
    Title::new(words)
}

/// Straight lines from point to point.
#[must_use]
pub fn path(points: &[(f64, f64)]) -> Data {
    let mut points = points.iter().map(|(x, y)| (tenth(*x), tenth(*y)));
    let Some(first) = points.next() else { return Data::new() };
    points.fold(Data::new().move_to(first), Data::line_to)
}

/// A filled shape with these corners.
#[must_use]
pub fn shape(corners: &[(f64, f64)], colour: &str) -> Path {
    Path::new().set("d", path(corners).close()).set("fill", colour)
}

/// Straight lines, not filled.
#[must_use]
pub fn curve(points: &[(f64, f64)], colour: &str) -> Path {
    Path::new()
        .set("d", path(points))
        .set("fill", "none")
        .set("stroke", colour)
        .set("stroke-linejoin", "round")
}

/// Something that is not to be: a saltire.
#[must_use]
pub fn cross(x: f64, y: f64) -> Path {
    let arm = 3.6;
    let data = Data::new()
        .move_to((tenth(x - arm), tenth(y - arm)))
        .line_by((2.0 * arm, 2.0 * arm))
        .move_to((tenth(x + arm), tenth(y - arm)))
        .line_by((-2.0 * arm, 2.0 * arm));
    Path::new().set("d", data).set("stroke", BAD).set("stroke-width", 2).set("fill", "none")
}

/// Stripes of this colour and width on white; `name` is what it is filled by.
#[must_use]
pub fn stripes(name: &str, colour: &str, width: f64) -> Pattern {
    Pattern::new()
        .set("id", name)
        .set("width", 5)
        .set("height", 5)
        .set("patternUnits", "userSpaceOnUse")
        .set("patternTransform", "rotate(45)")
        .add(bar((0.0, 5.0), 0.0, 5.0, "white"))
        .add(line((0.0, 0.0), (0.0, 5.0), colour).set("stroke-width", width))
}
