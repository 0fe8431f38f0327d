//! Activities by the dozen.

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;

use crate::draws::Draws;
use crate::plan::{
    Activity, ActivityId, Constraint, Dependency, Effect, Impact, Kind, StartRange, Status,
};
use crate::units::{Bytes, Span, Time};

pub(super) const MB: i64 = 1_000_000;
const SECOND: i64 = 1_000;
pub(super) const MINUTE: i64 = 60_000;
const HOUR: i64 = 3_600_000;

/// Priorities from here on are mandatory.
pub(super) const MANDATORY: i64 = 128;

/// What a crowd has in common.
#[derive(Clone, Copy)]
pub(super) struct Crowd {
    pub(super) sols: i64,
    pub(super) day: i64,
    /// In percent of what is usual.
    pub(super) draw: u64,
}

pub(super) fn id(number: usize) -> ActivityId {
    let number = u32::try_from(number).unwrap_or(u32::MAX).saturating_add(1);
    ActivityId::new(number).unwrap_or(ActivityId::FIRST)
}

pub(super) fn unsigned(number: i64) -> u64 {
    number.unsigned_abs()
}

/// Activities of all types, spread over the sols.
pub(super) fn crowd(count: usize, crowd: Crowd, draws: &mut Draws) -> Vec<Activity> {
    let mut all: Vec<Activity> = Vec::with_capacity(count);
    for number in 0..count {
        let sol =
            i64::try_from(number).unwrap_or(0) * crowd.sols / i64::try_from(count).unwrap_or(1);
        let mut one = plain(id(number), sol * crowd.day, crowd.draw, draws);
        special(&mut one, draws);
        named(&mut one, draws);
        if let Some(before) = all.last() {
            related(&mut one, before, sol * crowd.day, draws);
        }
        all.push(one);
    }
    all
}

/// Runs for a few minutes, some time by day.
fn plain(id: ActivityId, midnight: i64, draw: u64, draws: &mut Draws) -> Activity {
    let mut one = Activity::new(id, Span::new(draws.between(120, 840) * SECOND));
    let mandatory = draws.percent(10);
    let priority = if mandatory { draws.between(MANDATORY, 200) } else { draws.between(1, 127) };
    one.priority = u32::try_from(priority).unwrap_or(0);
    let watts = unsigned(draws.between(5, 60)) * 10 * draw;
    one.marginal = Milliwatts::new(watts);
    one.peak = Milliwatts::new(watts + watts * unsigned(draws.between(2, 10)) / 10);
    one.data = Bytes::new(draws.between(0, 12) * MB);
    one.engines = u32::from(draws.percent(60));
    let bits = (0..=draws.below(2)).fold(0, |mask, _| mask | 1_u128 << draws.below(12));
    one.resources = Categories::from_mask(bits);
    let ranges = 1 + draws.below(3);
    one.starts = (0..ranges).map(|_| range(midnight, one.duration, draws)).collect();
    one.starts.sort_by_key(|range| range.from);
    one
}

fn range(midnight: i64, duration: Span, draws: &mut Draws) -> StartRange {
    let from = midnight + 6 * HOUR + draws.between(0, 14 * 3_600) * SECOND;
    let to = from + draws.between(10, 120) * MINUTE;
    let cutoff = to + duration.get() + draws.between(0, 20) * MINUTE;
    StartRange { from: Time::new(from), to: Time::new(to), cutoff: Time::new(cutoff) }
}

fn special(one: &mut Activity, draws: &mut Draws) {
    match draws.below(100) {
        0..10 => one.kind = Kind::Expanding { minimum: Span::new(one.duration.get() / 2) },
        10..13 => one.kind = Kind::StayAwake,
        13..26 => one.zones = vec!["mast".into()],
        26..32 => one.zones = vec!["wheels".into()],
        32..34 => one.zones = vec!["mast".into(), "wheels".into()],
        _ => {}
    }
    one.pausable = draws.percent(20);
}

fn named(one: &mut Activity, draws: &mut Draws) {
    let impact = |timeline: &str, effect| Impact { timeline: timeline.into(), effect };
    let value = draws.between(0, 3);
    match draws.below(100) {
        0..6 => one.impacts.push(impact("arm", Effect::SetAtStart(value))),
        6..12 => one.constraints.push(Constraint { timeline: "arm".into(), min: 0, max: value }),
        12..20 => one.impacts.push(impact("memory", Effect::Hold(1 + value / 2))),
        20..24 => one.impacts.push(impact("sieve", Effect::Hold(1))),
        24..26 => one.impacts.push(impact("tubes", Effect::AddAtEnd(1))),
        _ => {}
    }
}

/// What it has to do with the one before it in the plan.
fn related(one: &mut Activity, before: &Activity, midnight: i64, draws: &mut Draws) {
    let same_sol = before.starts.first().is_some_and(|range| range.from.get() >= midnight);
    if !same_sol {
        return;
    }
    match draws.below(100) {
        0..8 => {
            let (statuses, prior) = (vec![Status::Succeeded], before.id);
            one.after = vec![Dependency { prior, statuses }];
            // A dependant is never the more important one.
            one.priority = one.priority.min(before.priority);
        }
        8..14 => one.group = Some(before.group.clone().unwrap_or_else(|| before.id.to_string())),
        14..16 => {
            let statuses = vec![Status::Failed, Status::Aborted];
            one.after = vec![Dependency { prior: before.id, statuses }];
            (one.kind, one.priority) = (Kind::Cleanup, one.priority.min(before.priority));
        }
        _ => {}
    }
}
