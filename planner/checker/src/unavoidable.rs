//! Limits that windows, running activities and manual blocks break by
//! themselves.

use faregate_planner::timed::{Excess, Limit};

use crate::brute::listed;
use crate::given::Given;
use crate::lines::{data, engines};
use crate::scene::Scene;
use crate::steps::{Changes, first_past};
use crate::valid::Broken;
use crate::violation::{Rule, Violation};
use crate::world::World;

/// As it is listed.
pub(crate) fn unavoidable(scene: &Scene<'_>, base: &World<'_>) -> Vec<Excess> {
    broken_by_themselves(scene, base).into_iter().map(|broken| listed(None, broken)).collect()
}

/// What is broken whatever is planned: exactly what the world breaks in which
/// nothing was chosen.
pub(crate) fn check(given: &Given<'_>) -> Vec<Violation> {
    let found = broken_by_themselves(given.scene, &given.base);
    let listed = &given.timed.unavoidable;
    let missing = found.iter().filter(|broken| {
        !listed.iter().any(|excess| {
            excess.limit == broken.limit
                && excess.at.get() == broken.at
                && i128::from(excess.amount) == broken.amount
        })
    });
    let judged = |limit: &Limit| {
        matches!(
            limit,
            Limit::SoftMinimum | Limit::Handover | Limit::Data | Limit::Peak | Limit::Engines
        )
    };
    let invented = listed.iter().filter(|excess| {
        judged(&excess.limit) && !found.iter().any(|broken| broken.limit == excess.limit)
    });
    let missing = missing.map(|broken| {
        let detail = format!("{:?} is broken by {} and not listed", broken.limit, broken.amount);
        Violation::new(Rule::Unavoidable, None, broken.at).detail(detail)
    });
    let invented = invented.map(|excess| {
        let detail = format!("{:?} is listed and not broken", excess.limit);
        Violation::new(Rule::Unavoidable, excess.by, excess.at.get()).detail(detail)
    });
    missing.chain(invented).collect()
}

fn broken_by_themselves(scene: &Scene<'_>, base: &World<'_>) -> Vec<Broken> {
    let all = (scene.now, scene.end);
    let of = |limit: Limit, found: Option<(i64, i128)>| {
        found.map(|(at, amount)| Broken { limit, at, amount, with: None })
    };
    let soft = scene.at_least(scene.parameters.soft_min_soc);
    let (handover, least) =
        (scene.plan.handover.get(), scene.at_least(scene.plan.handover_min_soc));
    let short = least - base.charge.at(handover);
    let nothing = Changes::default().from(scene.now);
    let past = |steps, limit: i128| first_past(steps, &nothing, limit, all);
    let data = data(scene, &base.placed);
    let engines = engines(scene, &base.placed);
    [
        of(Limit::SoftMinimum, base.charge.first_below(soft, None, all)),
        of(Limit::Handover, (handover >= scene.now && short > 0).then_some((handover, short))),
        of(Limit::Data, past(&data, scene.plan.max_delta_data.get().into())),
        of(Limit::Peak, past(&base.peak, scene.parameters.peak_limit.get().into())),
        of(Limit::Engines, past(&engines, scene.parameters.engines.into())),
    ]
    .into_iter()
    .flatten()
    .collect()
}
