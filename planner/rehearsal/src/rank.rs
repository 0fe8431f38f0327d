//! From an activity's priority to its tickets'.

use faregate_planner::{Parameters, Plan};
use faregate_tickets::id::Priority;

/// The priority of the computer's and the heaters' tickets: above all
/// activities, below whoever answers an emergency.
pub(crate) const GENERATED: Priority = Priority::FAULT_RESPONSE;
/// The priority of a communication window: nobody moves it.
pub(crate) const WINDOW: Priority = Priority::new(250);
/// The priority of somebody else, who takes what he needs.
pub(crate) const EMERGENCY: Priority = Priority::EMERGENCY;

const CLASS: usize = 120;

/// The ticket priority of an activity: in the order of the plan's priorities,
/// every mandatory one above every optional one, all below 240.
///
/// A plan with more than 120 different priorities in a class has equal ones
/// among its tickets: whoever came first keeps them.
#[must_use]
pub fn ticket_priority(plan: &Plan, parameters: &Parameters, priority: u32) -> Priority {
    let mandatory = priority >= parameters.mandatory_from;
    let same_class = |other: &u32| (*other >= parameters.mandatory_from) == mandatory;
    let mut class: Vec<_> =
        plan.activities.iter().map(|one| one.priority).filter(same_class).collect();
    class.sort_unstable();
    class.dedup();
    let below = class.partition_point(|other| *other < priority);
    let level = if class.len() <= CLASS { below } else { below * CLASS / class.len() };
    let level = level.min(CLASS - 1) + if mandatory { CLASS } else { 0 };
    Priority::new(u8::try_from(level).unwrap_or(u8::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use faregate_planner::units::Span;
    use faregate_planner::{Activity, ActivityId};

    #[test]
    fn mandatory_tickets_are_above_optional_ones_in_order() {
        let parameters = Parameters { mandatory_from: 1_000, ..Default::default() };
        let priorities = (0..2_000).step_by(7);
        let activities = (1..).zip(priorities.clone()).map(|(id, priority)| {
            let id = ActivityId::new(id).expect("not 0");
            Activity { priority, ..Activity::new(id, Span::from_secs(1)) }
        });
        let plan = Plan { activities: activities.collect(), ..Default::default() };
        let levels: Vec<_> =
            priorities.map(|one| ticket_priority(&plan, &parameters, one).level()).collect();
        assert!(levels.is_sorted());
        let (optional, mandatory) = levels.split_at(143);
        assert!(optional.iter().all(|level| *level < 120));
        assert!(mandatory.iter().all(|level| (120..240).contains(level)));
    }
}
