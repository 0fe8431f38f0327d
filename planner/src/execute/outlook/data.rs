//! The data on board from now on, with what is planned.

use std::collections::BTreeMap;

use super::Outlook;
use crate::plan::{Activity, ActivityId};
use crate::timed::{Limit, Slot};
use crate::units::{Bytes, Time};

type Planned = BTreeMap<ActivityId, Slot>;

impl Outlook<'_> {
    /// An optional activity adds no data past the maximum. One that starts before
    /// its time has its data on board sooner: nobody who is planned before that
    /// time may find too much for that.
    pub(super) fn keeps_data(
        &self,
        activity: &Activity,
        planned: &Planned,
        early: bool,
    ) -> Result<(), Limit> {
        if activity.data <= Bytes::ZERO {
            return Ok(());
        }
        let most = i128::from(self.plan.max_delta_data.get());
        let own = i128::from(activity.data.get());
        let fits = |at: Time| self.data_at(at, activity.id, planned) + own <= most;
        let now = (!self.is_mandatory(activity)).then_some(self.state.now);
        let later = if early { self.increases(activity, planned) } else { Vec::new() };
        if now.into_iter().chain(later).all(fits) { Ok(()) } else { Err(Limit::Data) }
    }

    /// When there will be more on board before its planned start, from which on
    /// the plan has counted it. A mandatory one is only in the way of optional
    /// ones.
    fn increases(&self, activity: &Activity, planned: &Planned) -> Vec<Time> {
        let now = self.state.now;
        let until = planned.get(&activity.id).map_or(now, |slot| slot.start);
        let optional = !self.is_mandatory(activity);
        let others = planned.iter().filter(|(id, _)| **id != activity.id);
        let makes = others.filter_map(|(id, slot)| {
            let other = self.activity(*id)?;
            let counts = other.data > Bytes::ZERO && (optional || !self.is_mandatory(other));
            counts.then_some(slot.start)
        });
        let windows = self.state.windows.iter();
        let windows = windows.filter(|window| optional && window.data > Bytes::ZERO);
        let all = makes.chain(windows.map(|window| window.start));
        all.filter(|at| now < *at && *at < until).collect()
    }

    /// What is on board then, without this activity.
    fn data_at(&self, at: Time, but: ActivityId, planned: &Planned) -> i128 {
        let ended = self.state.ended.iter().map(|ended| i128::from(ended.data.get()));
        let running = self.state.running.iter().map(|running| {
            let modelled = self.activity(running.id).map_or(0, |one| one.data.get());
            let sent = modelled < 0 && running.ends <= at && running.ends > self.state.now;
            i128::from(if sent { modelled } else { running.data.get().max(modelled) })
        });
        let windows = self.state.windows.iter();
        let windows = windows.map(|one| by_then(one.data, (one.start, one.end), at));
        let planned = planned.iter();
        let planned = planned.filter(|(id, slot)| **id != but && slot.start > self.state.now);
        let planned = planned.map(|(id, slot)| {
            let data = self.activity(*id).map_or(Bytes::ZERO, |one| one.data);
            by_then(data, (slot.start, slot.end), at)
        });
        ended.chain(running).chain(windows).chain(planned).sum()
    }
}

/// What is made is on board from the start, and what is sent is gone at the end.
fn by_then(data: Bytes, (start, end): (Time, Time), at: Time) -> i128 {
    let since = if data > Bytes::ZERO { start } else { end };
    if since <= at { i128::from(data.get()) } else { 0 }
}
