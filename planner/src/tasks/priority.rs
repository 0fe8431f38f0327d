//! From an activity's priority to its task's, and so to its tickets'.

use faregate_scheduler::task::TaskPriority;

use crate::{Parameters, Plan};

/// How many levels tasks have.
const LEVELS: usize = TaskPriority::TOP.level() as usize + 1;

/// The priority of the task of an activity of this priority.
///
/// The plan's priorities, each counted once and in order, are the levels from 0
/// up: as long as there are no more than 240 of them, tasks are equal where
/// activities are, and nowhere else. Where there are more, neighbours share a
/// level; optional and mandatory ones then have levels in proportion to their
/// numbers, so that every mandatory one is above every optional one.
#[must_use]
pub fn ticket_priority(plan: &Plan, parameters: &Parameters, priority: u32) -> TaskPriority {
    let mut all: Vec<_> = plan.activities.iter().map(|one| one.priority).collect();
    all.sort_unstable();
    all.dedup();
    let optional = all.partition_point(|one| *one < parameters.mandatory_from);
    let mandatory = all.len() - optional;
    let lower = levels_of_optional(optional, mandatory);
    let place = all.partition_point(|one| *one < priority);
    let level = if priority < parameters.mandatory_from {
        shared(place.min(optional), optional, lower)
    } else {
        lower + shared(place.saturating_sub(optional), mandatory, LEVELS - lower)
    };
    let level = u8::try_from(level).unwrap_or(u8::MAX);
    TaskPriority::new(level).unwrap_or(TaskPriority::TOP)
}

fn levels_of_optional(optional: usize, mandatory: usize) -> usize {
    let all = optional + mandatory;
    if all <= LEVELS {
        return optional;
    }
    let share = optional * LEVELS / all;
    share.clamp(usize::from(optional > 0), LEVELS - usize::from(mandatory > 0))
}

/// The level of one of so many, where there are so many levels.
const fn shared(place: usize, of: usize, levels: usize) -> usize {
    if of <= levels { place } else { place * levels / of }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Activity, ActivityId};
    use crate::units::Span;

    fn levels(priorities: impl Iterator<Item = u32> + Clone, mandatory_from: u32) -> Vec<u8> {
        let parameters = Parameters { mandatory_from, ..Parameters::default() };
        let activities = (1..).zip(priorities.clone()).filter_map(|(id, priority)| {
            Some(Activity { priority, ..Activity::new(ActivityId::new(id)?, Span::ZERO) })
        });
        let plan = Plan { activities: activities.collect(), ..Plan::default() };
        priorities.map(|one| ticket_priority(&plan, &parameters, one).level()).collect()
    }

    #[test]
    fn tasks_are_equal_where_activities_are_as_far_as_levels_go() {
        assert_eq!(levels([7, 7, 90, 100, 100, 4_000].into_iter(), 100), [0, 0, 1, 2, 2, 3]);
        let exactly: Vec<_> = (0..240).collect();
        assert_eq!(levels(0..240, 9), exactly);
    }

    #[test]
    fn every_mandatory_task_is_above_every_optional_one_whatever_the_numbers() {
        for (count, from) in [(241, 1), (241, 240), (5_000, 17), (5_000, 4_999), (700, 300)] {
            let levels = levels(0..count, from);
            assert!(levels.is_sorted());
            let (optional, mandatory) = levels.split_at(from as usize);
            assert!(optional.last() < mandatory.first(), "{count} from {from}");
            assert_eq!(levels.first(), Some(&0));
        }
    }
}
