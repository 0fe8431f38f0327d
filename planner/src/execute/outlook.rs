//! Limits on the projection: what would be broken if an activity started now,
//! with everything else as it is planned.
//!
//! It looks from the present estimates along the timed plan, without planning:
//! so it costs little, and a plan that was made from older estimates is not
//! trusted with a start that it would not allow today.

mod charge;
mod claims;
mod data;

use std::collections::BTreeMap;

use crate::parameters::Parameters;
use crate::plan::{Activity, ActivityId, Plan};
use crate::state::{Running, State};
use crate::timed::{Limit, Slot, TimedPlan};
use crate::units::{Span, Time};

use claims::Claim;

/// What is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Outlook<'a> {
    plan: &'a Plan,
    parameters: &'a Parameters,
    state: &'a State,
    timed: &'a TimedPlan,
}

impl<'a> Outlook<'a> {
    /// From this state along this timed plan.
    #[must_use]
    pub const fn new(
        plan: &'a Plan,
        parameters: &'a Parameters,
        state: &'a State,
        timed: &'a TimedPlan,
    ) -> Self {
        Self { plan, parameters, state, timed }
    }

    /// Whether an activity can run then, beside what runs and the windows, and
    /// beside what else is planned and has not started: before its time it must
    /// be in nobody's way, at its time in the way of nothing that is more
    /// important.
    ///
    /// # Errors
    /// The limit that would be broken.
    pub fn admits(
        &self,
        activity: &Activity,
        slot: Slot,
        planned: &BTreeMap<ActivityId, Slot>,
        early: bool,
    ) -> Result<(), Limit> {
        let mine = Claim::of(activity, slot);
        let others = self.claims(activity, planned, early);
        claims::beside(&mine, &others, self.parameters)?;
        if early && !self.stays_up(slot) {
            return Err(Limit::Computer);
        }
        self.keeps_data(activity, planned, early)?;
        self.keeps_charge(activity, slot, planned)
    }

    fn is_mandatory(&self, activity: &Activity) -> bool {
        activity.priority >= self.parameters.mandatory_from
    }

    /// Who would be in the way.
    fn claims(
        &self,
        activity: &Activity,
        planned: &BTreeMap<ActivityId, Slot>,
        early: bool,
    ) -> Vec<Claim> {
        let now = self.state.now;
        let windows = self.state.windows.iter().filter(|w| w.end > now).map(Claim::of_window);
        let running = self.state.running.iter().filter_map(|running| {
            let slot = Slot { start: running.started, end: self.likely_end(running), range: 0 };
            Some(Claim::of(self.activity(running.id)?, slot))
        });
        let matters = |other: &Activity| early || other.priority > activity.priority;
        let planned = planned.iter().filter_map(|(id, slot)| {
            let other = self.activity(*id).filter(|other| *id != activity.id && matters(other))?;
            (slot.start > now).then(|| Claim::of(other, *slot))
        });
        // What is heated for it need not be any more.
        let for_it = |zone: &String| activity.zones.contains(zone);
        let heating = self.timed.preheats.iter();
        let heating = heating.filter(|one| one.end > now && !for_it(&one.zone));
        let heating = heating.filter_map(|heating| Claim::of_heating(heating, self.parameters));
        windows.chain(running).chain(planned).chain(heating).collect()
    }

    /// One that runs too long is taken to run on until it is looked at again; a
    /// little too long is what its successor waits for at the agents.
    fn likely_end(&self, running: &Running) -> Time {
        let now = self.state.now;
        let paused = running.paused.map_or(Span::ZERO, |since| now.since(since));
        let ends = running.ends.after(paused);
        if ends > now || now.since(ends) <= self.parameters.handover_tolerance {
            return ends.max(now);
        }
        now.after(Span::new(self.parameters.commit.get().max(1_000)))
    }

    /// Whether the computer is planned to be up all the time.
    fn stays_up(&self, slot: Slot) -> bool {
        self.timed.awake.iter().any(|phase| phase.up <= slot.start && slot.end <= phase.down)
    }

    fn activity(&self, id: ActivityId) -> Option<&'a Activity> {
        self.plan.activities.iter().find(|activity| activity.id == id)
    }
}
