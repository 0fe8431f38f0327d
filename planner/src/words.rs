//! What the planner answers, in words: limits in units that people use, times
//! of day, and who is in the way.

mod amounts;
mod relaxed;

use crate::parameters::Parameters;
use crate::plan::{ActivityId, Outcome, Plan};
use crate::timed::{Excess, Limit, Reason};
use crate::units::{Span, Time};

pub use amounts::{amount, bytes, energy, percent, power, span};

/// Says it with the names that a plan and its parameters give.
#[derive(Clone, Copy, Debug)]
pub struct Words<'a> {
    plan: &'a Plan,
    parameters: &'a Parameters,
}

impl<'a> Words<'a> {
    /// With the names of this plan and these parameters.
    #[must_use]
    pub const fn new(plan: &'a Plan, parameters: &'a Parameters) -> Self {
        Self { plan, parameters }
    }

    /// An activity by its name, or else by its number.
    #[must_use]
    pub fn activity(&self, id: ActivityId) -> String {
        let named = self.plan.activities.iter().find(|activity| activity.id == id);
        named.and_then(|activity| activity.name.clone()).unwrap_or_else(|| id.to_string())
    }

    /// The time of day, and which day it is, the first excepted: `14:20`,
    /// `1T02:05`. Seconds where there are any.
    #[must_use]
    pub fn time(&self, at: Time) -> String {
        let day = self.parameters.day;
        let (date, of_day) = (day_number(self.parameters, at), day.time_of_day(at).get());
        let (hours, minutes) = (of_day / 3_600_000, of_day / 60_000 % 60);
        let date = if date == 0 { String::new() } else { format!("{date}T") };
        let below = match of_day % 60_000 {
            0 => String::new(),
            ms if ms % 1_000 == 0 => format!(":{:02}", ms / 1_000),
            ms => format!(":{:02}.{:03}", ms / 1_000, ms % 1_000),
        };
        format!("{date}{hours:02}:{minutes:02}{below}")
    }

    /// Why an activity is left out.
    #[must_use]
    pub fn reason(&self, reason: &Reason) -> String {
        match reason {
            Reason::Limit { limit, at, amount, with } => {
                let beside = with.map(|id| self.beside(limit, id)).unwrap_or_default();
                let broken = self.broken(limit, *amount);
                format!("{broken} at {}{beside}", self.second(*at))
            }
            Reason::NoRangeLeft => "no start range is left that ends by its cutoff".into(),
            Reason::PriorOut(prior) => {
                format!("depends on {}, which is left out", self.activity(*prior))
            }
            Reason::PriorEnded(prior, how) => {
                format!("depends on {}, which {}", self.activity(*prior), became(*how))
            }
            Reason::WaitsForOutcome(prior) => {
                format!("waits for an outcome of {}", self.activity(*prior))
            }
            Reason::GroupTaken(other) => {
                format!("{} was selected of its group", self.activity(*other))
            }
            Reason::Committed => "would start within the commit window".into(),
            Reason::HandedOver => "handed over to the next plan before it began".into(),
        }
    }

    /// A limit that is exceeded: by whom if by anybody, which one, by how much,
    /// and when.
    #[must_use]
    pub fn excess(&self, excess: &Excess) -> String {
        let broken = match &excess.limit {
            Limit::Resources(mask) => {
                format!("{} held twice for {}", self.resources(*mask), span(excess.amount))
            }
            Limit::Computer => {
                let needed = span(excess.amount);
                format!("computer needed for {needed} while the ground has it off")
            }
            limit => self.broken(limit, excess.amount),
        };
        let by = excess.by.map(|id| format!("{}: ", self.activity(id))).unwrap_or_default();
        format!("{by}{broken} at {}", self.second(excess.at))
    }

    /// As exact as it says something: the second in which it is.
    fn second(&self, at: Time) -> String {
        let below = self.parameters.day.time_of_day(at).get() % 1_000;
        self.time(at.before(Span::new(below)))
    }

    /// A limit's name.
    #[must_use]
    pub fn limit(&self, limit: &Limit) -> String {
        match limit {
            Limit::SoftMinimum => "soft minimum".into(),
            Limit::Handover => "handover minimum".into(),
            Limit::Data => "data volume".into(),
            Limit::Peak => "peak power".into(),
            Limit::Engines => "sequence engines".into(),
            Limit::Resources(mask) => self.resources(*mask),
            Limit::Timeline(name) => name.clone(),
            Limit::Computer => "manual shutdown".into(),
            Limit::Lead => "lead time".into(),
            Limit::Range => "start range".into(),
            Limit::Dependency => "dependency".into(),
        }
    }

    /// What would be wrong, and by how much.
    fn broken(&self, limit: &Limit, by: i64) -> String {
        let much = amount(limit, by);
        match limit {
            Limit::SoftMinimum => format!("{much} below the soft minimum of charge"),
            Limit::Handover => format!("{much} below the handover minimum of charge"),
            Limit::Data => format!("{much} above the data volume"),
            Limit::Peak => format!("{much} above the peak power limit"),
            Limit::Engines => format!("{much} too many"),
            Limit::Resources(mask) => format!("{} in use", self.resources(*mask)),
            Limit::Timeline(name) => format!("{name} out of its range by {much}"),
            Limit::Computer => "the computer is down by the ground's order".into(),
            Limit::Lead => format!("{much} short for waking up or heating"),
            Limit::Range => format!("{much} outside its start range"),
            Limit::Dependency => "a dependency is not satisfied".into(),
        }
    }

    fn beside(&self, limit: &Limit, id: ActivityId) -> String {
        let other = self.activity(id);
        match limit {
            Limit::Resources(_) => format!(" by {other}"),
            _ => format!(", beside {other}"),
        }
    }

    /// Resource usage bits by their names, or else their numbers.
    fn resources(&self, mask: u128) -> String {
        let bits = (0_u8..128).filter(|bit| mask >> bit & 1 == 1);
        let named = bits.map(|bit| {
            let mut names = self.parameters.resources.iter();
            let name = names.find(|(_, number)| **number == bit).map(|(name, _)| name.clone());
            name.unwrap_or_else(|| format!("resource {bit}"))
        });
        named.collect::<Vec<_>>().join(" and ")
    }
}

/// Which day an instant is in, counted from the one that begins at the
/// parameters' midnight.
#[must_use]
pub fn day_number(parameters: &Parameters, at: Time) -> i64 {
    let day = parameters.day;
    at.since(day.midnight).get().div_euclid(day.length.get().max(1))
}

pub(crate) const fn became(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Succeeded => "succeeded",
        Outcome::Failed => "failed",
        Outcome::Aborted => "was aborted",
        Outcome::NotStarted => "was not started",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Day;
    use crate::plan::Activity;

    fn named(number: u32, name: &str) -> Activity {
        let id = ActivityId::new(number).expect("not 0");
        Activity { name: Some(name.into()), ..Activity::new(id, Span::from_secs(1)) }
    }

    fn plan() -> Plan {
        Plan { activities: vec![named(1, "drive"), named(2, "mast imaging")], ..Plan::default() }
    }

    fn parameters() -> Parameters {
        Parameters {
            resources: [("arm".to_owned(), 3), ("mast".to_owned(), 7)].into(),
            ..Parameters::default()
        }
    }

    fn limit(limit: Limit, amount: i64, with: u32) -> Reason {
        Reason::Limit { limit, at: Time::new(51_600_000), amount, with: ActivityId::new(with) }
    }

    #[test]
    fn a_reason_says_how_much_when_and_who_is_in_the_way() {
        let (plan, parameters) = (plan(), parameters());
        let said = |reason| Words::new(&plan, &parameters).reason(&reason);
        let soft = said(limit(Limit::SoftMinimum, 43 * 3_600_000_000, 0));
        assert_eq!(soft, "43 Wh below the soft minimum of charge at 14:20");
        let peak = said(limit(Limit::Peak, 25_500, 2));
        assert_eq!(peak, "25.5 W above the peak power limit at 14:20, beside mast imaging");
        let bits = said(limit(Limit::Resources(1 << 3 | 1 << 7 | 1 << 9), 1, 1));
        assert_eq!(bits, "arm and mast and resource 9 in use at 14:20 by drive");
        let prior = Reason::PriorEnded(plan.activities[0].id, Outcome::Aborted);
        assert_eq!(said(prior), "depends on drive, which was aborted");
    }

    #[test]
    fn nobody_is_blamed_for_what_nobody_did() {
        let (plan, parameters) = (plan(), parameters());
        let words = Words::new(&plan, &parameters);
        let mut excess =
            Excess { by: None, limit: Limit::Data, at: Time::new(51_600_999), amount: 1_500_000 };
        assert_eq!(words.excess(&excess), "1.5 MB above the data volume at 14:20");
        excess.at = Time::new(Day::SOL.length.get() + 1_999);
        assert_eq!(words.excess(&excess), "1.5 MB above the data volume at 1T00:00:01");
        excess.at = Time::new(51_600_000);
        excess.by = ActivityId::new(1);
        assert_eq!(words.excess(&excess), "drive: 1.5 MB above the data volume at 14:20");
    }

    #[test]
    fn what_is_held_twice_is_said_with_how_long() {
        let (plan, parameters) = (plan(), parameters());
        let at = Time::new(51_600_000);
        let held = Excess { by: None, limit: Limit::Resources(1 << 3), at, amount: 90_000 };
        let said = Words::new(&plan, &parameters).excess(&held);
        assert_eq!(said, "arm held twice for 1 min 30 s at 14:20");
    }

    #[test]
    fn a_computer_that_is_needed_while_it_is_off_is_said_with_how_long() {
        let (plan, parameters) = (plan(), parameters());
        let at = Time::new(51_600_000);
        let off = Excess { by: None, limit: Limit::Computer, at, amount: 90_000 };
        let said = Words::new(&plan, &parameters).excess(&off);
        assert_eq!(said, "computer needed for 1 min 30 s while the ground has it off at 14:20");
    }

    #[test]
    fn who_has_no_name_is_called_by_the_number() {
        let (plan, parameters) = (plan(), parameters());
        let words = Words::new(&plan, &parameters);
        assert_eq!(words.activity(ActivityId::new(9).expect("not 0")), "activity 9");
    }

    #[test]
    fn a_day_is_as_long_as_the_parameters_say() {
        let (plan, parameters) = (plan(), parameters());
        let time = |ms| Words::new(&plan, &parameters).time(Time::new(ms));
        assert_eq!(time(88_740_000), "24:39");
        assert_eq!(time(88_775_244), "1T00:00");
        assert_eq!(time(88_775_244 + 7_530_250), "1T02:05:30.250");
        assert_eq!(time(-1), "-1T24:39:35.243");
    }
}
