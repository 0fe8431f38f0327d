//! Changes that mutants have in common.

use faregate_planner::plan::{Kind, StartRange};
use faregate_planner::timed::{Fate, Reason, TimedPlan};
use faregate_planner::units::{Ppm, Span};

use crate::worlds::World;

pub(super) fn each(world: &mut World, change: impl FnMut(&mut faregate_planner::Activity)) {
    world.plan.activities.iter_mut().for_each(change);
}

pub(super) fn ranges(world: &mut World, mut change: impl FnMut(&mut StartRange)) {
    each(world, |activity| {
        if !matches!(activity.kind, Kind::ManualShutdown { .. }) {
            activity.starts.iter_mut().for_each(&mut change);
        }
    });
}

pub(super) fn expanding(world: &mut World, mut change: impl FnMut(&mut Span, &mut Span)) {
    each(world, |activity| {
        if let Kind::Expanding { minimum } = &mut activity.kind {
            change(&mut activity.duration, minimum);
        }
    });
}

pub(super) fn heated(world: &mut World, by: i64) {
    for zone in &mut world.parameters.zones {
        for row in &mut zone.table {
            row.duration = Span::new((row.duration.get() + by).max(0));
        }
    }
}

pub(super) fn shorter(span: &mut Span) {
    *span = Span::new((span.get() - 1).max(0));
}

pub(super) fn lower(limit: &mut Ppm, by: i64) {
    *limit = Ppm::new((limit.get() - by).max(0));
}

pub(super) fn out() -> Fate {
    Fate::Out(Reason::NoRangeLeft)
}

pub(super) fn change_row(
    timed: &mut TimedPlan,
    which: impl Fn(&Fate) -> bool,
    change: impl Fn(&Fate) -> Fate,
) {
    if let Some(row) = timed.rows.iter_mut().find(|row| which(&row.fate)) {
        row.fate = change(&row.fate);
    }
}
