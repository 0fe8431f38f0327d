//! (stub)
use crate::flight::Flight;
use crate::scene::Scene;
pub(crate) struct Panel<'a> {
    pub(crate) title: &'a str,
    pub(crate) flight: &'a Flight,
    pub(crate) scene: &'a Scene,
}
pub(crate) fn draw(left: &Panel<'_>, right: &Panel<'_>) -> Result<String, std::fmt::Error> {
    Ok(format!(
        "{} {} {:?} {:?} {}",
        left.title,
        right.title,
        left.flight.samples.len(),
        right.flight.lost,
        left.scene.seed
    ))
}
