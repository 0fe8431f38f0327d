//! What activities share: power, engines, bits, data, timelines and charge.

use faregate_planner::plan::ActivityId;
use faregate_planner::timed::{Excess, Limit};

use crate::given::Given;
use crate::scene::Placed;
use crate::valid::{Broken, beside, handover, peak, too_much_data};
use crate::violation::{Rule, Violation};

/// Which rule a limit belongs to.
pub(crate) const fn rule(limit: &Limit) -> Rule {
    match limit {
        Limit::SoftMinimum => Rule::SoftMinimum,
        Limit::Handover => Rule::Handover,
        Limit::Data => Rule::Data,
        Limit::Peak => Rule::Peak,
        Limit::Engines => Rule::Engines,
        Limit::Resources(_) => Rule::Resources,
        Limit::Timeline(_) => Rule::Timeline,
        Limit::Computer => Rule::Manual,
        Limit::Lead => Rule::Generated,
        Limit::Range => Rule::Range,
        Limit::Dependency => Rule::Dependency,
    }
}

pub(crate) fn violation(broken: Broken, who: Option<ActivityId>) -> Violation {
    let detail = match (&broken.limit, broken.with) {
        (Limit::Timeline(name), _) => name.clone(),
        (Limit::Resources(mask), Some(with)) => format!("bits {mask:#x}, with {with}"),
        (Limit::Resources(mask), None) => format!("bits {mask:#x}"),
        (Limit::Lead, _) => "there is no time for a wakeup or for heating".into(),
        _ => String::new(),
    };
    Violation::new(rule(&broken.limit), who, broken.at).by(broken.amount).detail(detail)
}

/// The whole plan against the world in which nothing was chosen: what was
/// broken there does not count unless it got worse.
pub(crate) fn check(given: &Given<'_>) -> Vec<Violation> {
    let (scene, base, world) = (given.scene, &given.base, &given.world);
    let mut all: Vec<Violation> = Vec::new();
    let chosen: Vec<Placed> = given.chosen().copied().collect();
    all.extend(beside(scene, base, world, &chosen).into_iter().map(|b| violation(b, None)));
    all.extend(peak(scene, base, world).map(|broken| violation(broken, None)));
    let least = scene.at_least(scene.parameters.soft_min_soc);
    let soft = world.charge.first_below(least, Some(&base.charge), (scene.now, scene.end));
    all.extend(soft.map(|(at, by)| Violation::new(Rule::SoftMinimum, None, at).by(by)));
    all.extend(may_exceed(given, handover(scene, base, world), Rule::Handover));
    all.extend(may_exceed(given, too_much_data(scene, base, world), Rule::Data));
    all
}

/// Mandatory activities may exceed it, if it is listed.
fn may_exceed(given: &Given<'_>, broken: Option<Broken>, rule: Rule) -> Option<Violation> {
    let broken = broken?;
    let listed = given.timed.excess.iter().any(|excess| excess.limit == broken.limit);
    let mandatory = given.decided().any(|placed| !given.scene.is_optional(placed.index));
    let rule = if mandatory && !listed { Rule::Excess } else { rule };
    (!(mandatory && listed)).then(|| violation(broken, None)).map(|v| Violation { rule, ..v })
}

/// Every excess is a chosen mandatory activity's.
pub(crate) fn excess(given: &Given<'_>) -> Vec<Violation> {
    let wrong = given.timed.excess.iter().filter(|excess| !could_exceed(given, excess));
    wrong
        .map(|excess| {
            let detail = format!("{:?} listed by {}", excess.limit, excess.amount);
            Violation::new(Rule::Excess, excess.by, excess.at.get()).detail(detail)
        })
        .collect()
}

fn could_exceed(given: &Given<'_>, excess: &Excess) -> bool {
    let Some(index) = excess.by.and_then(|by| given.scene.index(by)) else { return false };
    let decided = given.decided().any(|placed| placed.index == index);
    let limit = matches!(excess.limit, Limit::Handover | Limit::Data);
    decided && limit && excess.amount > 0 && !given.scene.is_optional(index)
}
