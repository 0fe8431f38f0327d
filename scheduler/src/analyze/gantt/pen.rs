//! What this picture has beside what all have.

use svg::node::element::path::Data;
use svg::node::element::{Path, Pattern};

use crate::analyze::pen::stripes;

pub(super) use crate::analyze::pen::{
    BAD, BLUE as RUN, EDGE, GREEN as WINDOW, GREEN_EDGE as WINDOW_EDGE, GREY, MARGIN,
    ORANGE as WAIT, RULE, SHADE, bar, cross, length, line, note, sheet, shortened, tenth, text,
    tip,
};

pub(super) const RUN_EDGE: &str = "#005A8C";
/// Neighbours in a row of many tasks.
pub(super) const TONES: [&str; 3] = ["#0072B2", "#3E93C6", "#00527F"];

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
    stripes("still", RUN, 2.4)
}
