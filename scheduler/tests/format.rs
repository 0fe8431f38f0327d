//! Schedule files as people and spreadsheets write them.

#[path = "format/arbitrary.rs"]
mod arbitrary;
#[path = "format/broken.rs"]
mod broken;
#[path = "format/cases.rs"]
mod cases;
#[path = "format/missions.rs"]
mod missions;
#[path = "format/native.rs"]
mod native;
#[path = "format/round_trip.rs"]
mod round_trip;
#[path = "format/smaarte.rs"]
mod smaarte;
#[path = "format/support.rs"]
mod support;
