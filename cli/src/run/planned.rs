//! A plan that is executed by the schedule manager: the planner's director
//! hears what becomes of its tasks, plans again, and says what changes.
//!
//! It is the same whatever the clock: whoever drives the manager forwards each
//! change, asks for orders, and gives them all at once.

mod prepared;

use std::sync::Arc;

use faregate_planner::plan::{Kind, Outcome, Plan};
use faregate_planner::project::project;
use faregate_planner::tasks::{Director, Epoch, NotPlanned};
use faregate_planner::timed::{Fate, Projection};
use faregate_planner::trace::Why;
use faregate_planner::units::{Span, Time};
use faregate_planner::words::Words;
use faregate_planner::{Activity, Parameters};
use faregate_scheduler::manager::{Note, Telecommand};
use faregate_scheduler::time::{Duration, Instant, Now};
use faregate_tickets::amount::Microjoules;

use crate::plan::why;
use crate::run::teller::Teller;
pub(crate) use prepared::{Prepared, read};

/// How long the gauge shows the same before that is another sample.
const SAMPLED_EVERY: Span = Span::from_secs(60);

/// A plan, and who has it executed.
#[derive(Debug)]
pub(crate) struct Planned {
    director: Director,
    parameters: Arc<Parameters>,
    /// The plan that takes over, until it does.
    next: Option<Arc<Plan>>,
    epoch: Epoch,
    /// What the present timed plan makes of the charge: believed where the
    /// mission has no battery.
    projection: Projection,
    /// The last sample of the gauge, and when it was taken.
    sample: Option<(Time, u8)>,
    plans: u64,
    /// Why there was no new plan, the last time: said once.
    not_planned: Option<String>,
}

impl Planned {
    /// Something changed in the schedule.
    pub(crate) fn hear(&mut self, now: Now, note: &Note) {
        self.director.heard(self.epoch.time(now.wall), note);
    }

    /// What the manager is to be told, all at once; nothing, if all is well as
    /// it is. The gauge shows percents.
    pub(crate) fn orders(
        &mut self,
        now: Now,
        gauge: Option<u8>,
        teller: &mut Teller,
    ) -> Result<Vec<Telecommand>, NotPlanned> {
        let at = self.epoch.time(now.wall);
        self.hand_over(now, at, teller);
        self.measure(at, gauge);
        let whys: Vec<Why> = self.director.wishes().collect();
        let before = self.director.timed().clone();
        let orders = match self.director.turn(at) {
            Ok(orders) => orders,
            Err(why) if self.plans == 0 => return Err(why),
            Err(why) => {
                self.complain(why.to_string(), now, teller);
                return Ok(Vec::new());
            }
        };
        if *self.director.timed() != before {
            self.planned_anew(now, &whys, teller);
        }
        for order in &orders {
            if let Telecommand::Add(additions) = order {
                additions.iter().for_each(|one| teller.call(&one.task));
            }
        }
        Ok(orders)
    }

    /// When to ask for orders again, if nothing happens before. What is due and
    /// waits, as a plan does while the computer sleeps, waits for a change.
    pub(crate) fn due(&self, now: Now) -> Option<Instant> {
        let sample = self.sample.map(|(at, _)| at.after(SAMPLED_EVERY));
        let due = sample.map_or(self.director.due(), |at| at.min(self.director.due()));
        let ahead = due.since(self.epoch.time(now.wall)).get();
        let ahead = u64::try_from(ahead).ok().filter(|ahead| *ahead > 0)?;
        Some(now.elapsed.after(Duration::from_millis(ahead)))
    }

    /// Each value of the gauge is a sample, and it is one again a while later:
    /// so many samples in a row below a limit have something aborted, and they
    /// must not be as many as there are changes in the schedule.
    fn measure(&mut self, at: Time, gauge: Option<u8>) {
        let Some(percent) = gauge else {
            let line = self.projection.lines.first().and_then(|line| line.at(at));
            let charge = line.and_then(|uj| u64::try_from(uj).ok()).map(Microjoules::new);
            return charge.into_iter().for_each(|charge| self.director.charge(charge));
        };
        let same = self.sample.filter(|(_, before)| *before == percent);
        if same.is_none_or(|(last, _)| at >= last.after(SAMPLED_EVERY)) {
            self.sample = Some((at, percent));
            let capacity = self.director.state().capacity.get();
            self.director.charge(Microjoules::new(capacity / 100 * u64::from(percent)));
        }
    }

    fn hand_over(&mut self, now: Now, at: Time, teller: &mut Teller) {
        let Some(name) = self.director.wants_next(at) else { return };
        let next = self.next.take();
        let none = || format!("there is no plan `{name}` on board");
        match self.director.take_over(at, next.ok_or_else(none)) {
            Ok(_) => {
                teller.planner(now, "the next plan takes over");
                self.planned_anew(now, &[Why::HandOver], teller);
            }
            Err(why) => teller.planner(now, &format!("this plan goes on: {why}")),
        }
    }

    fn planned_anew(&mut self, now: Now, whys: &[Why], teller: &mut Teller) {
        self.plans += 1;
        self.not_planned = None;
        let words = Words::new(self.director.plan(), &self.parameters);
        let periodic = [Why::Periodic];
        let whys = if whys.is_empty() { &periodic } else { whys };
        let whys: Vec<_> = whys.iter().map(|one| why(&words, *one)).collect();
        let timed = self.director.timed();
        let count = |is: fn(&Fate) -> bool| timed.rows.iter().filter(|row| is(&row.fate)).count();
        let ahead = count(|fate| matches!(fate, Fate::Scheduled(_)));
        let out = count(|fate| matches!(fate, Fate::Out(_)));
        let said = format!("{} ({ahead} ahead, {out} left out)", whys.join(", "));
        teller.planner(now, &said);
        let state = self.director.state();
        // A plan that cannot be projected is still executed: the charge is the
        // last one known.
        self.projection =
            project(self.director.plan(), &self.parameters, state, timed).unwrap_or_default();
    }

    fn complain(&mut self, why: String, now: Now, teller: &mut Teller) {
        if self.not_planned.as_ref() != Some(&why) {
            teller.planner(now, &why);
            self.not_planned = Some(why);
        }
    }

    /// What came of it, in numbers.
    pub(crate) fn result(&self) -> String {
        let ended = &self.director.state().ended;
        let count = |outcome| ended.iter().filter(|one| one.outcome == outcome).count();
        let never = self
            .director
            .plan()
            .activities
            .iter()
            .filter(|one| self.outcome(one).is_none())
            .count();
        let new = match self.plans.saturating_sub(1) {
            1 => "1 new plan".to_owned(),
            new => format!("{new} new plans"),
        };
        let counts = [
            (count(Outcome::Succeeded), "succeeded"),
            (count(Outcome::Failed), "failed"),
            (count(Outcome::Aborted), "aborted"),
            (never + count(Outcome::NotStarted), "not started"),
        ];
        let told: Vec<_> = counts.iter().map(|(count, word)| format!("{count} {word}")).collect();
        format!("activities: {}; {new}", told.join(", "))
    }

    /// Mandatory activities that did not succeed, with what became of them. A
    /// cleanup that nothing failed for is not missed, nor is one of a group of
    /// which another member started.
    pub(crate) fn wanting(&self) -> Option<String> {
        let words = Words::new(self.director.plan(), &self.parameters);
        let mandatory = self.director.plan().activities.iter().filter(|one| {
            one.priority >= self.parameters.mandatory_from && one.kind != Kind::Cleanup
        });
        let wanting = mandatory.filter_map(|one| {
            let how = match self.outcome(one) {
                Some(Outcome::Succeeded) => return None,
                Some(Outcome::Failed) => "failed",
                Some(Outcome::Aborted) => "was aborted",
                _ if self.is_replaced(one) => return None,
                _ => "was not started",
            };
            Some(format!("{} {how}", words.activity(one.id)))
        });
        let wanting: Vec<_> = wanting.collect();
        (!wanting.is_empty()).then(|| format!("the mission needs it, but {}", wanting.join(", ")))
    }

    fn outcome(&self, activity: &Activity) -> Option<Outcome> {
        // The ground's own shutdown is no task: it has happened.
        if matches!(activity.kind, Kind::ManualShutdown { .. }) {
            return Some(Outcome::Succeeded);
        }
        let ended = &self.director.state().ended;
        ended.iter().find(|one| one.id == activity.id).map(|one| one.outcome)
    }

    fn is_replaced(&self, one: &Activity) -> bool {
        let members =
            self.director.plan().activities.iter().filter(|other| other.group == one.group);
        let mut started = members.filter_map(|other| self.outcome(other));
        one.group.is_some() && started.any(|outcome| outcome != Outcome::NotStarted)
    }
}
