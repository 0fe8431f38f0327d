//! Which of two timed plans is the better one.

use core::cmp::{Ordering, Reverse};

use crate::problem::Problem;
use crate::timed::{Fate, TimedPlan};

/// What a timed plan is worth: compared from the first field to the last.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Worth {
    /// How many mandatory activities are in, for each mandatory priority of the
    /// plan, the highest first.
    mandatory: Vec<usize>,
    /// The sum of values of the optional ones that are in.
    optional: u128,
    /// How many are in: one that is worth nothing is still wanted, and makes
    /// the sum of starts later.
    activities: usize,
    /// The sum of starts: the earlier, the better.
    starts: Reverse<i128>,
}

impl Worth {
    /// Of what is scheduled or runs.
    #[must_use]
    pub fn of(problem: &Problem, timed: &TimedPlan) -> Self {
        let from = problem.parameters().mandatory_from;
        let activities = &problem.plan().activities;
        let mut levels: Vec<u32> = activities.iter().map(|activity| activity.priority).collect();
        levels.retain(|&priority| priority >= from);
        levels.sort_unstable_by_key(|&priority| Reverse(priority));
        levels.dedup();
        let mandatory = vec![0; levels.len()];
        let mut worth = Self { mandatory, optional: 0, activities: 0, starts: Reverse(0) };
        for (activity, row) in activities.iter().zip(&timed.rows) {
            let (Fate::Scheduled(slot) | Fate::Running(slot)) = row.fate else { continue };
            worth.activities += 1;
            worth.starts.0 += i128::from(slot.start.get());
            match levels.binary_search_by_key(&Reverse(activity.priority), |&level| Reverse(level))
            {
                Ok(level) => worth.mandatory[level] += 1,
                Err(_) => worth.optional += u128::from(activity.worth()),
            }
        }
        worth
    }

    /// Whether it is worth no less than another, or by no more than so much of
    /// the optional ones; when they start makes no difference.
    pub(super) fn comes_near(&self, other: &Self, less: u128) -> bool {
        match self.mandatory.cmp(&other.mandatory) {
            Ordering::Equal => self.optional + less >= other.optional,
            order => order.is_gt(),
        }
    }

    /// The sum of values of the optional activities that are in.
    #[must_use]
    pub const fn optional(&self) -> u128 {
        self.optional
    }

    /// How many mandatory activities are in.
    #[must_use]
    pub fn mandatory(&self) -> usize {
        self.mandatory.iter().sum()
    }
}
