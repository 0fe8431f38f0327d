//! Relaxations in words: what would have to be different, and what then.

use crate::explain::{Change, Relaxation};
use crate::timed::Limit;
use crate::units::Ppm;
use crate::words::{Words, amount};

impl Words<'_> {
    /// The smallest change of one limit, and the start that it allows.
    #[must_use]
    pub fn relaxation(&self, relaxation: &Relaxation) -> String {
        let Some(change) = &relaxation.change else {
            return format!("no change of {} alone", self.limit(&relaxation.limit));
        };
        let changed = self.changed(&relaxation.limit, change);
        format!("{changed}: {}", self.time(change.start))
    }

    fn changed(&self, limit: &Limit, change: &Change) -> String {
        let much = || amount(limit, change.by);
        let name = || self.limit(limit);
        match limit {
            Limit::SoftMinimum | Limit::Handover => {
                format!("{} lower by {}", name(), Ppm::new(change.by))
            }
            Limit::Data => format!("data volume larger by {}", bytes(change.by)),
            Limit::Peak => format!("peak power limit higher by {}", much()),
            Limit::Engines => format!("{} more", much()),
            Limit::Resources(_) => format!("without {}{}", name(), self.held(change)),
            Limit::Timeline(name) => format!("a range of {name} wider by {}", much()),
            Limit::Computer => "without the manual shutdown".into(),
            Limit::Lead => format!("{} more before it", much()),
            Limit::Range => format!("{} longer by {}", self.range(change), much()),
            Limit::Dependency => format!("without the dependency{}", self.on(change)),
        }
    }

    fn held(&self, change: &Change) -> String {
        change.with.map(|id| format!(", held by {}", self.activity(id))).unwrap_or_default()
    }

    fn on(&self, change: &Change) -> String {
        change.with.map(|id| format!(" on {}", self.activity(id))).unwrap_or_default()
    }

    /// Which of its ranges, counted from 1, where there can be several.
    fn range(&self, change: &Change) -> String {
        match change.range {
            Some(index) => format!("start range {}", index.saturating_add(1)),
            None => "start range".into(),
        }
    }
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
    use crate::plan::{Activity, ActivityId, Plan};
    use crate::units::{Span, Time};

    fn said(limit: Limit, by: i64) -> String {
        let id = ActivityId::FIRST;
        let drive = Activity { name: Some("drive".into()), ..Activity::new(id, Span::ZERO) };
        let plan = Plan { activities: vec![drive], ..Plan::default() };
        let change = Change { by, start: Time::new(36_000_000), with: Some(id), range: Some(1) };
        let relaxation = Relaxation { limit, change: Some(change) };
        Words::new(&plan, &Parameters::default()).relaxation(&relaxation)
    }

    #[test]
    fn a_change_is_exact_and_says_when_it_would_start() {
        assert_eq!(said(Limit::SoftMinimum, 70_846), "soft minimum lower by 7.0846 %: 10:00");
        assert_eq!(said(Limit::Data, 41_000_001), "data volume larger by 41000001 B: 10:00");
        assert_eq!(said(Limit::Data, 41_000_000), "data volume larger by 41 MB: 10:00");
        assert_eq!(said(Limit::Peak, 90_000), "peak power limit higher by 90 W: 10:00");
        assert_eq!(said(Limit::Range, 60_000), "start range 2 longer by 1 min: 10:00");
        assert_eq!(said(Limit::Resources(8), 0), "without resource 3, held by drive: 10:00");
        assert_eq!(said(Limit::Dependency, 0), "without the dependency on drive: 10:00");
    }

    #[test]
    fn what_no_single_change_helps_says_so() {
        let (plan, parameters) = (Plan::default(), Parameters::default());
        let alone = Relaxation { limit: Limit::Peak, change: None };
        let said = Words::new(&plan, &parameters).relaxation(&alone);
        assert_eq!(said, "no change of peak power alone");
    }
}
