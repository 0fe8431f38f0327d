//! A plan on the virtual clock: the schedule manager's own decisions and the
//! planner's, and nothing is executed.

use std::collections::BTreeSet;
use std::time::Instant as StdInstant;

use faregate_scheduler::executive::{LoadedFile, Outside, VirtualBodies, VirtualExecutive};
use faregate_scheduler::manager::{Attempt, Event, Note, Reply, Telecommand, TelecommandId};
use faregate_scheduler::time::{Duration, Instant, Now};

use super::planned::{Planned, Prepared};
use super::teller::Teller;
use super::virtual_clock::{Pace, stuck, wait};
use crate::exit::Failure;
use crate::schedule::Schedule;
use crate::times;

/// Who hears of the run.
struct Audience {
    teller: Teller,
    /// Changes that the planner has not heard of.
    changes: Vec<(Now, Note)>,
    /// What the manager may refuse: to remove what is over by now.
    removals: BTreeSet<u64>,
}

impl Outside for Audience {
    fn note(&mut self, now: Now, note: &Note) {
        self.teller.tell(now, note);
        self.changes.push((now, note.clone()));
    }

    fn answer(&mut self, now: Now, id: TelecommandId, reply: Reply) {
        let may_be = self.removals.remove(&id.0);
        if let Reply::Refused(why) = reply
            && !may_be
        {
            self.teller.planner(now, &format!("the manager refused an order: {why}"));
        }
    }

    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        None
    }
}

/// Executes the plan until nothing is left to do, or the time is over.
pub(crate) fn run(
    schedule: Schedule,
    plan: Prepared,
    pace: Pace,
    time: Option<Duration>,
    teller: Teller,
) -> Result<Teller, Failure> {
    let begin = times::now();
    let mut planned = plan.begin(begin);
    let audience = Audience { teller, changes: Vec::new(), removals: BTreeSet::new() };
    let bodies = VirtualBodies::as_expected();
    let mut executive = VirtualExecutive::new(schedule.mission, begin, bodies, audience);
    let began = StdInstant::now();
    let end = time.map_or(Instant::FAR_FUTURE, |time| Instant::START.after(time));
    let mut orders = 0;
    loop {
        settle(&mut executive, &mut planned, &mut orders)?;
        if executive.manager().is_over() {
            break;
        }
        let dues = [executive.next_due(), planned.due(executive.now())];
        let Some(due) = dues.into_iter().flatten().min() else {
            executive.outside().teller.say("Nothing that is left can ever happen.");
            break;
        };
        wait(pace, began, due.min(end));
        if due > end {
            break;
        }
        executive.advance_to(due).map_err(|why| stuck(&why))?;
    }
    let mut teller = executive.into_outside().teller;
    teller.executed(planned.result(), planned.wanting());
    Ok(teller)
}

/// Takes changes to the planner and its orders to the manager, until there are
/// none at this instant.
fn settle(
    executive: &mut VirtualExecutive<Audience>,
    planned: &mut Planned,
    given: &mut u64,
) -> Result<(), Failure> {
    loop {
        let now = executive.now();
        for (at, note) in std::mem::take(&mut executive.outside().changes) {
            planned.hear(at, &note);
        }
        let orders = planned.orders(now, None, &mut executive.outside().teller);
        let orders = orders.map_err(|why| Failure::failed(why.to_string()))?;
        if orders.is_empty() && executive.outside().changes.is_empty() {
            return Ok(());
        }
        for telecommand in orders {
            if matches!(telecommand, Telecommand::Remove(_)) {
                executive.outside().removals.insert(*given);
            }
            executive.tell(Event::Telecommand { id: TelecommandId(*given), telecommand });
            *given += 1;
        }
        executive.advance_to(now.elapsed).map_err(|why| stuck(&why))?;
    }
}
