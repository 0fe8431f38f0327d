//! What is heated, derived from the uses of zones.

use core::fmt::{self, Display, Formatter};

use faregate_planner::units::Time;

use crate::scene::{How, Placed, Scene, zones};

/// A zone is heated over [start, end).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Heating<'a> {
    pub(crate) zone: &'a str,
    pub(crate) start: i64,
    pub(crate) end: i64,
}

impl Display for Heating<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [start, end] = [self.start, self.end].map(Time::new);
        write!(f, "{} heated from {start} to {end}", self.zone)
    }
}

/// Heating that would have had to begin before now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TooLate {
    /// Whose use it is for.
    pub(crate) index: usize,
    pub(crate) at: i64,
    pub(crate) by: i64,
}

/// One use of a zone.
#[derive(Clone, Copy, Debug)]
struct Use {
    index: usize,
    start: i64,
    end: i64,
}

/// All heating of a world, in order of start, then zone, and what comes too late.
pub(crate) fn heatings<'a>(
    scene: &Scene<'a>,
    placed: &[Placed],
) -> (Vec<Heating<'a>>, Vec<TooLate>) {
    let (mut all, mut late) = (Vec::new(), Vec::new());
    for zone in named_zones(scene, placed) {
        let uses = uses(scene, placed, zone);
        for one in uses.iter().filter(|one| one.start >= scene.now) {
            let Some((start, end)) = heating(scene, zone, one, &uses) else { continue };
            let since = scene.state.heating.get(zone).map(|since| since.get());
            if start < scene.now && since.is_none_or(|since| since > start) {
                late.push(TooLate { index: one.index, at: one.start, by: scene.now - start });
            }
            let start = start.max(scene.now);
            if start < end {
                all.push(Heating { zone, start, end });
            }
        }
    }
    all.sort_by(|a, b| (a.start, a.zone, a.end).cmp(&(b.start, b.zone, b.end)));
    (all, late)
}

/// The heating that a use needs: none if another use covers its start.
fn heating(scene: &Scene<'_>, zone: &str, one: &Use, uses: &[Use]) -> Option<(i64, i64)> {
    let mut others = uses.iter().filter(|other| other.index != one.index);
    let covers = |other: &&Use| {
        other.start < one.start && one.start < other.end
            || other.start == one.start && other.index < one.index
    };
    if others.clone().any(|other| covers(&other)) {
        return None;
    }
    let needed = table(scene, zone, one.start);
    let warm_until = others.by_ref().map(|other| other.end).filter(|end| *end <= one.start).max();
    let start = warm_until.map_or(one.start - needed, |end| end.max(one.start - needed));
    (start < one.start).then_some((start, one.start))
}

/// How long the zone is to be heated for a use that starts at `at`.
fn table(scene: &Scene<'_>, zone: &str, at: i64) -> i64 {
    let day = scene.parameters.day;
    let time_of_day = (at - day.midnight.get()).rem_euclid(day.length.get());
    let zone = scene.parameters.zones.iter().find(|known| known.name == zone);
    let rows = zone.map(|zone| zone.table.as_slice()).unwrap_or_default();
    rows.iter().rev().find(|row| row.from.get() <= time_of_day).map_or(0, |row| row.duration.get())
}

fn named_zones<'a>(scene: &Scene<'a>, placed: &[Placed]) -> Vec<&'a str> {
    let mut named: Vec<&str> = placed.iter().flat_map(|p| zones(scene.activity(p.index))).collect();
    named.sort_unstable();
    named.dedup();
    named
}

fn uses(scene: &Scene<'_>, placed: &[Placed], zone: &str) -> Vec<Use> {
    let names = |index: usize| zones(scene.activity(index)).any(|name| name == zone);
    let warm = placed
        .iter()
        .filter(|placed| !matches!(placed.how, How::Block { .. }) && names(placed.index))
        .map(|placed| Use { index: placed.index, start: placed.start, end: placed.end });
    let cold = scene.state.cold.iter().any(|cold| cold == zone);
    let past = scene.state.ended.iter().filter_map(|ended| {
        let index = scene.index(ended.id).filter(|index| names(*index))?;
        let (start, end) = (ended.started?.get(), ended.ended.get());
        (!(cold && end <= scene.now)).then_some(Use { index, start, end })
    });
    past.chain(warm).filter(|one| one.start < one.end).collect()
}
