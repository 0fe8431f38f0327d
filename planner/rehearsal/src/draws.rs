//! What activities really take: drawn before the execution.

use std::collections::BTreeMap;

use faregate_devices_sim::Dice;
use faregate_planner::plan::{Kind, Plan};
use faregate_planner::units::Span;
use faregate_planner::{Activity, ActivityId};

/// How things usually go, in thousandths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Odds {
    /// How many sequences fail.
    pub fail: u64,
    /// How many take longer than planned.
    pub overrun: u64,
    /// The shortest share of its planned time that one takes.
    pub shortest: u64,
    /// The longest, of those that take longer.
    pub longest: u64,
    /// The share of its average power that one draws, at least and at most.
    pub power: (u64, u64),
    /// The share of its data that one makes, at least and at most.
    pub data: (u64, u64),
}

impl Default for Odds {
    /// Most sequences end early, as on Mars: the ground plans with margin. One
    /// in twenty fails, one in twelve takes too long.
    fn default() -> Self {
        Self {
            fail: 50,
            overrun: 80,
            shortest: 600,
            longest: 1_250,
            power: (800, 1_000),
            data: (700, 1_050),
        }
    }
}

impl Odds {
    /// A bad day: one in five takes up to three times as long, so that cutoffs
    /// come; one in ten fails.
    pub const HARSH: Self = Self {
        fail: 100,
        overrun: 200,
        shortest: 500,
        longest: 3_000,
        power: (800, 1_000),
        data: (700, 1_050),
    };

    /// Everything takes exactly what was planned.
    pub const NONE: Self = Self {
        fail: 0,
        overrun: 0,
        shortest: 1_000,
        longest: 1_000,
        power: (1_000, 1_000),
        data: (1_000, 1_000),
    };
}

/// What one activity really takes, in thousandths of what was planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// How long it runs by itself.
    pub length: u64,
    /// Its average power.
    pub power: u64,
    /// Its data.
    pub data: u64,
    /// Whether it does its work.
    pub succeeds: bool,
    /// How long it goes on after it was told to end.
    pub ending: Span,
}

/// What every activity really takes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Draws {
    of: BTreeMap<ActivityId, Draw>,
}

impl Draws {
    /// Drawn for each activity by its number: adding one changes no other.
    #[must_use]
    pub fn new(plan: &Plan, seed: u64, odds: &Odds) -> Self {
        let draws = plan.activities.iter().map(|one| (one.id, Draw::new(one, seed, odds)));
        Self { of: draws.collect() }
    }

    /// Draws for a plan that follows, too. Who was drawn for already keeps that.
    pub fn add(&mut self, plan: &Plan, seed: u64, odds: &Odds) {
        for one in &plan.activities {
            self.of.entry(one.id).or_insert_with(|| Draw::new(one, seed, odds));
        }
    }

    /// What an activity takes; what was planned where nothing was drawn.
    #[must_use]
    pub fn of(&self, id: ActivityId) -> Draw {
        self.of.get(&id).copied().unwrap_or(Draw::AS_PLANNED)
    }

    /// Sets what an activity takes.
    pub fn set(&mut self, id: ActivityId, draw: Draw) {
        self.of.insert(id, draw);
    }
}

impl Draw {
    /// Exactly what was planned.
    pub const AS_PLANNED: Self =
        Self { length: 1_000, power: 1_000, data: 1_000, succeeds: true, ending: Span::ZERO };

    fn new(activity: &Activity, seed: u64, odds: &Odds) -> Self {
        let mut dice = Dice::new(seed, u64::from(activity.id.get()));
        let mut between = |(low, high): (u64, u64)| low + dice.below(high.saturating_sub(low) + 1);
        let (fails, overruns) = (between((0, 999)) < odds.fail, between((0, 999)) < odds.overrun);
        let early = between((odds.shortest, 1_000));
        let late = between((1_000, odds.longest));
        let failed_at = between((50, 950));
        let (power, data) = (between(odds.power), between(odds.data));
        let ending = Span::from_secs(i64::try_from(between((0, 30))).unwrap_or(0));
        // Nothing but time ends what only keeps the computer awake.
        let timed = matches!(activity.kind, Kind::StayAwake | Kind::ManualShutdown { .. });
        let length = match () {
            () if timed => 1_000,
            () if fails => failed_at,
            () if overruns => late,
            () => early,
        };
        Self { length, power, data, succeeds: !fails || timed, ending }
    }
}

/// So many thousandths of an amount, rounded towards nothing.
pub(crate) fn share(amount: i64, thousandths: u64) -> i64 {
    let part = i128::from(amount) * i128::from(thousandths) / 1_000;
    i64::try_from(part).unwrap_or(amount)
}
