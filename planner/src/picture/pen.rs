//! The colours that this picture has beside those that all have.

use svg::node::element::Pattern;

pub(super) use faregate_scheduler::analyze::pen::{
    BAD, BLUE as MANDATORY, EDGE, GREEN as RANGE, GREEN_EDGE as RANGE_EDGE, GREY, INK, MARGIN,
    ORANGE as HEAT, RULE, SHADE, SMALL, bar, cross, curve, haloed, length, line, note, shape,
    sheet, shortened, text, tip,
};

pub(super) const OPTIONAL: &str = "#56B4E9";
pub(super) const RADIO: &str = "#CC79A7";
pub(super) const RADIO_SHADE: &str = "#F8ECF3";
pub(super) const UP: &str = "#F5D97A";
pub(super) const DOWN: &str = "#44546A";
pub(super) const NIGHT: &str = "#EEF1F6";
pub(super) const CURVE: &str = "#1B4F72";

/// What an activity is filled with where it was given more than its minimum;
/// `name` is what it is filled by.
pub(super) fn more(name: &str, colour: &str) -> Pattern {
    faregate_scheduler::analyze::pen::stripes(name, colour, 4.6)
}
