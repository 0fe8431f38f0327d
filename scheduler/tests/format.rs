//! Schedule files as people and spreadsheets write them.

#[path = "format/cases.rs"]
mod cases;
#[path = "format/native.rs"]
mod native;
#[path = "format/smaarte.rs"]
mod smaarte;
#[path = "format/support.rs"]
mod support;
