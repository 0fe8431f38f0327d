//! What is wanted of a rover: random activities.

use faregate_agents::Categories;
use faregate_planner::plan::{Constraint, Dependency, Effect, Impact, Kind, StartRange, Status};
use faregate_planner::units::{Bytes, Span};
use faregate_planner::{Activity, Parameters};

use super::{Make, ZONES, id};

impl Make {
    pub(super) fn manual(&mut self, number: usize) -> Activity {
        let (shutdown, wakeup) = (self.span(1, 2), self.span(1, 3));
        let length = Span::new(shutdown.get() + wakeup.get() + self.span(5, 20).get());
        let from = self.time(40, 85);
        let mut activity = Activity::new(id(number), length);
        activity.kind = Kind::ManualShutdown { shutdown, wakeup };
        activity.starts = vec![StartRange { from, to: from, cutoff: from.after(length) }];
        activity
    }

    pub(super) fn activity(
        &mut self,
        number: usize,
        before: &[Activity],
        p: &Parameters,
    ) -> Activity {
        let duration = self.span(2, 18).max(Span::new(1));
        let mut activity = Activity::new(id(number), duration);
        activity.priority = self.rng.u32(1..11);
        activity.marginal = self.watts(0, 90);
        activity.peak = activity.marginal.saturating_add(self.watts(0, 60));
        activity.starts = self.starts(duration);
        if self.chance(30) {
            activity.data = Bytes::new(self.rng.i64(-40..80));
        }
        if self.chance(40) {
            activity.engines = self.rng.u32(1..=p.engines);
        }
        if self.chance(40) {
            activity.resources = Categories::from_mask(1 << self.rng.u32(0..4));
        }
        activity.zones = ZONES.iter().filter(|_| self.chance(25)).map(|&z| z.to_owned()).collect();
        activity.kind = self.kind(duration);
        self.links(&mut activity, before);
        self.effects(&mut activity);
        activity
    }

    fn starts(&mut self, duration: Span) -> Vec<StartRange> {
        let ranges = 1 + usize::from(self.chance(40));
        let range = |make: &mut Self| {
            let from = make.time(0, 120);
            let to = from.after(make.span(0, 60));
            StartRange { from, to, cutoff: from.after(duration).after(make.span(0, 60)) }
        };
        let mut all: Vec<StartRange> = (0..ranges).map(|_| range(self)).collect();
        if self.chance(80) {
            all.sort_by_key(|range| range.from);
        }
        all
    }

    fn kind(&mut self, duration: Span) -> Kind {
        match self.rng.u8(0..20) {
            0..4 => Kind::Expanding { minimum: Span::new((duration.get() / 2).max(1)) },
            4 => Kind::StayAwake,
            _ => Kind::Generic,
        }
    }

    fn links(&mut self, activity: &mut Activity, before: &[Activity]) {
        if self.chance(20) {
            activity.group = Some(["a", "b"][self.rng.usize(0..2)].into());
        }
        let Some(prior) = self.rng.choice(before).filter(|_| self.rng.u8(0..100) < 30) else {
            return;
        };
        let statuses = match self.rng.u8(0..6) {
            0 => vec![Status::Failed, Status::Aborted],
            1 => vec![Status::Completed],
            _ => vec![Status::Succeeded],
        };
        if statuses.contains(&Status::Aborted) && activity.kind == Kind::Generic {
            activity.kind = Kind::Cleanup;
        }
        // Most of the ground's dependants are less important than their priors.
        if self.chance(80) {
            activity.priority = activity.priority.min(prior.priority);
        }
        activity.after = vec![Dependency { prior: prior.id, statuses }];
    }

    fn effects(&mut self, activity: &mut Activity) {
        if !self.chance(25) {
            return;
        }
        let amount = self.rng.i64(1..=3);
        let (name, effect) = match self.rng.u8(0..6) {
            0 => ("mode", Effect::SetAtStart(amount)),
            1 => ("mode", Effect::SetAtEnd(amount)),
            2 => ("bus", Effect::Hold(1)),
            3 => ("seats", Effect::Hold(amount)),
            4 => ("fuel", Effect::AddAtStart(-amount * 10 * self.scale.fuel())),
            _ => {
                let for_each_unit = -amount * self.scale.fuel();
                ("fuel", Effect::Rate(for_each_unit * 1_000 / self.scale.unit))
            }
        };
        activity.impacts.push(Impact { timeline: name.into(), effect });
        if self.chance(40) {
            let constraint = Constraint { timeline: "mode".into(), min: 0, max: amount };
            activity.constraints.push(constraint);
        }
    }
}
