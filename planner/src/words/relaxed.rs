//! Relaxations in words: what would have to be different, and what then.

use crate::explain::{Change, Number, Relaxation, Whose};
use crate::plan::ActivityId;
use crate::timed::Limit;
use crate::units::{Ppm, Time};
use crate::words::{Words, amount, span};

impl Words<'_> {
    /// Each change of one number, and the start that it allows; then what is in
    /// the way besides, and needs more than that.
    #[must_use]
    pub fn relaxations(&self, all: &[Relaxation]) -> Vec<String> {
        let helps = all.iter().filter_map(|one| Some((&one.limit, one.change.as_ref()?)));
        let mut said: Vec<String> = helps
            .map(|(limit, change)| {
                let start = self.time(change.start);
                format!("{}; starts at {start}", self.changed(limit, change))
            })
            .collect();
        let others = all.iter().filter(|one| one.change.is_none());
        let others: Vec<_> = others.map(|one| self.limit(&one.limit)).collect();
        if !others.is_empty() {
            said.push(format!("a change of {} alone is not enough", others.join(" or of ")));
        }
        said
    }

    fn changed(&self, limit: &Limit, change: &Change) -> String {
        let by = span(change.by);
        match change.number {
            Number::Limit => self.own(limit, change.by),
            Number::Least(whose) => {
                format!("minimum of {} lower by {}", self.values(limit, whose), change.by)
            }
            Number::Most(whose) => {
                format!("maximum of {} higher by {}", self.values(limit, whose), change.by)
            }
            Number::From(range) => format!("start range {} opens {by} earlier", nth(range)),
            Number::To(range) => format!("start range {} closes {by} later", nth(range)),
            Number::Cutoff(range) => format!("cutoff of start range {} is {by} later", nth(range)),
            Number::Shutdown(block) => {
                format!("manual shutdown {} shorter by {by}", self.activity(block))
            }
            Number::Earlier(block) => {
                format!("manual shutdown {} earlier by {by}", self.activity(block))
            }
            Number::Later(block) => {
                format!("manual shutdown {} later by {by}", self.activity(block))
            }
            Number::Heating(zone, row) => format!("{} shorter by {by}", self.heating(zone, row)),
            Number::Wakeup => format!("wakeup shorter by {by}"),
            Number::MinSleep => format!("minimum sleep shorter by {by}"),
            Number::Without => self.without(limit, change),
        }
    }

    fn own(&self, limit: &Limit, by: i64) -> String {
        let (name, much) = (self.limit(limit), amount(limit, by));
        match limit {
            Limit::SoftMinimum | Limit::Handover => format!("{name} lower by {}", Ppm::new(by)),
            Limit::Data => format!("data volume larger by {}", bytes(by)),
            Limit::Peak => format!("peak power limit higher by {much}"),
            Limit::Engines => format!("{much} more"),
            _ => format!("{name} wider by {much}"),
        }
    }

    /// A timeline, and who asks for which values of it.
    fn values(&self, limit: &Limit, whose: Whose) -> String {
        let name = self.limit(limit);
        match whose {
            Whose::Timeline => name,
            Whose::Constraint(id, _) => format!("{name} that {} asks for", self.activity(id)),
        }
    }

    fn heating(&self, zone: usize, row: usize) -> String {
        let Some(zone) = self.parameters.zones.get(zone) else { return "heating".into() };
        let from = zone.table.get(row).map(|row| self.parameters.day.midnight.after(row.from));
        let from = from.filter(|_| zone.table.len() > 1);
        let from = from.map(|from| format!(" from {} on", self.time(from))).unwrap_or_default();
        format!("heating of {}{from}", zone.name)
    }

    fn without(&self, limit: &Limit, change: &Change) -> String {
        let of = |what: &str, who: Option<ActivityId>| {
            who.map(|id| format!("{what}{}", self.activity(id))).unwrap_or_default()
        };
        match limit {
            Limit::Computer => format!("without the manual shutdown{}", of(" ", change.with)),
            Limit::Dependency => format!("without the dependency{}", of(" on ", change.with)),
            _ => {
                let held = of(", held by ", change.with);
                let until = |at: Time| match held.is_empty() {
                    true => format!(", held until {}", self.time(at)),
                    false => format!(" until {}", self.time(at)),
                };
                let until = change.until.map(until).unwrap_or_default();
                format!("without {}{held}{until}", self.limit(limit))
            }
        }
    }
}

/// People count from 1.
const fn nth(index: usize) -> usize {
    index.saturating_add(1)
}

/// Exact, since one byte less is not enough.
fn bytes(bytes: i64) -> String {
    match bytes {
        whole if whole % 1_000_000 == 0 => format!("{} MB", whole / 1_000_000),
        whole if whole % 1_000 == 0 => format!("{} kB", whole / 1_000),
        _ => format!("{bytes} B"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Parameters;
    use crate::parameters::{Load, PreheatRow, Zone};
    use crate::plan::{Activity, Plan};
    use crate::units::Span;

    fn said(limit: Limit, number: Number, by: i64) -> String {
        let id = ActivityId::FIRST;
        let drive = Activity { name: Some("drive".into()), ..Activity::new(id, Span::ZERO) };
        let plan = Plan { activities: vec![drive], ..Plan::default() };
        let row = |minutes| PreheatRow { from: Span::from_mins(minutes), duration: Span::ZERO };
        let arm = Zone { name: "arm".into(), load: Load::default(), table: vec![row(0), row(570)] };
        let parameters = Parameters { zones: vec![arm], ..Parameters::default() };
        let (start, until) = (Time::new(36_000_000), Some(Time::new(37_200_000)));
        let change = Change { number, by, start, with: Some(id), until };
        let relaxation = Relaxation { limit, change: Some(change) };
        let said = Words::new(&plan, &parameters).relaxations(&[relaxation]);
        said[0].strip_suffix("; starts at 10:00").expect("it says when").to_owned()
    }

    #[test]
    fn a_change_is_exact() {
        let own = |limit, by| said(limit, Number::Limit, by);
        assert_eq!(own(Limit::SoftMinimum, 70_846), "soft minimum lower by 7.0846 %");
        assert_eq!(own(Limit::Data, 41_000_001), "data volume larger by 41000001 B");
        assert_eq!(own(Limit::Data, 41_000_000), "data volume larger by 41 MB");
        assert_eq!(own(Limit::Peak, 90_000), "peak power limit higher by 90 W");
        assert_eq!(own(Limit::Engines, 1), "1 sequence engine more");
    }

    #[test]
    fn a_change_of_times_says_which_time() {
        let range = |number| said(Limit::Range, number, 60_000);
        assert_eq!(range(Number::From(1)), "start range 2 opens 1 min earlier");
        assert_eq!(range(Number::To(0)), "start range 1 closes 1 min later");
        assert_eq!(range(Number::Cutoff(0)), "cutoff of start range 1 is 1 min later");
        let heating = said(Limit::Lead, Number::Heating(0, 1), 60_000);
        assert_eq!(heating, "heating of arm from 09:30 on shorter by 1 min");
        let shutdown = said(Limit::Computer, Number::Shutdown(ActivityId::FIRST), 60_000);
        assert_eq!(shutdown, "manual shutdown drive shorter by 1 min");
    }

    #[test]
    fn what_is_in_the_way_is_said_with_who_holds_it_until_when() {
        let without = |limit| said(limit, Number::Without, 0);
        let resource = "without resource 3, held by drive until 10:20";
        assert_eq!(without(Limit::Resources(8)), resource);
        assert_eq!(
            without(Limit::Timeline("bus".into())),
            "without bus, held by drive until 10:20"
        );
        assert_eq!(without(Limit::Dependency), "without the dependency on drive");
        assert_eq!(without(Limit::Computer), "without the manual shutdown drive");
    }

    #[test]
    fn a_timeline_says_whose_values_would_be_wider() {
        let fuel = |number| said(Limit::Timeline("fuel".into()), number, 3);
        assert_eq!(fuel(Number::Least(Whose::Timeline)), "minimum of fuel lower by 3");
        let asked = Whose::Constraint(ActivityId::FIRST, 0);
        assert_eq!(fuel(Number::Most(asked)), "maximum of fuel that drive asks for higher by 3");
    }

    #[test]
    fn what_no_single_change_helps_says_so() {
        let (plan, parameters) = (Plan::default(), Parameters::default());
        let alone = |limit| Relaxation { limit, change: None };
        let all = [alone(Limit::Peak), alone(Limit::Resources(8))];
        let said = Words::new(&plan, &parameters).relaxations(&all);
        assert_eq!(said, ["a change of peak power or of resource 3 alone is not enough"]);
    }
}
