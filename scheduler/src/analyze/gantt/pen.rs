//! Colours, and the few shapes that the picture is made of.

use svg::node::Text as Words;
use svg::node::element::path::Data;
use svg::node::element::{Line, Path, Pattern, Rectangle, Text, Title};

// The colours of Okabe and Ito, which colour-blind people can tell apart. What
// they tell is also told by height, hatch or sign.
pub(super) const RUN: &str = "#0072B2";
pub(super) const RUN_EDGE: &str = "#005A8C";
pub(super) const BAD: &str = "#C04F00";
pub(super) const WAIT: &str = "#E69F00";
pub(super) const WINDOW: &str = "#DCEBDD";
pub(super) const WINDOW_EDGE: &str = "#5F9E6E";
pub(super) const INK: &str = "#24292F";
pub(super) const GREY: &str = "#57606A";
pub(super) const RULE: &str = "#E3E7EB";
pub(super) const EDGE: &str = "#D0D7DE";
pub(super) const SHADE: &str = "#F6F8FA";
/// Neighbours in a row of many tasks.
pub(super) const TONES: [&str; 3] = ["#0072B2", "#3E93C6", "#00527F"];

/// The size of letters.
pub(super) const TEXT: f64 = 11.5;

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

/// A miss: a saltire.
pub(super) fn cross(x: f64, y: f64) -> Path {
    let arm = 3.6;
    let data = Data::new()
        .move_to((tenth(x - arm), tenth(y - arm)))
        .line_by((2.0 * arm, 2.0 * arm))
        .move_to((tenth(x + arm), tenth(y - arm)))
        .line_by((-2.0 * arm, 2.0 * arm));
    Path::new().set("d", data).set("stroke", BAD).set("stroke-width", 2).set("fill", "none")
}

/// A run that goes on beyond the picture: its head.
pub(super) fn head(x: f64, top: f64, height: f64, colour: &str) -> Path {
    let data = Data::new()
        .move_to((tenth(x), tenth(top - 1.5)))
        .line_by((6.0, tenth(height / 2.0 + 1.5)))
        .line_by((-6.0, tenth(height / 2.0 + 1.5)))
        .close();
    Path::new().set("d", data).set("fill", colour)
}

/// What a bar that stands still is filled with.
pub(super) fn hatch() -> Pattern {
    let stroke = line((0.0, 0.0), (0.0, 5.0), RUN).set("stroke-width", 2.4);
    Pattern::new()
        .set("id", "still")
        .set("width", 5)
        .set("height", 5)
        .set("patternUnits", "userSpaceOnUse")
        .set("patternTransform", "rotate(45)")
        .add(bar((0.0, 5.0), 0.0, 5.0, "white"))
        .add(stroke)
}

pub(super) fn words(words: &str) -> Words {
    Words::new(words)
}
