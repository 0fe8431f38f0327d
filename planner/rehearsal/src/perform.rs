//! What the control thread wants done.

mod held;

use faregate_devices_sim::rover::{RoverCommand, RunSpec};
use faregate_planner::execute::{Action, Event, Start};
use faregate_planner::plan::{Activity, Kind, Outcome};
use faregate_planner::state::Mode;
use faregate_planner::trace::{Cause, Happened, Why};
use faregate_planner::units::{Bytes, Span};
use faregate_planner::{ActivityId, Plan, TimedPlan};

use crate::draws::share;
use crate::host::{Heater, Held, Host};
use crate::model::{duration, part};
use crate::rank::{GENERATED, ticket_priority};
use crate::station::{Needs, Switch};
use crate::{NotRehearsed, Planner};

impl Host<'_, '_, '_> {
    pub(crate) fn perform(
        &mut self,
        action: Action,
        planner: &mut dyn Planner,
    ) -> Result<(), NotRehearsed> {
        match action {
            Action::Request(id) => self.request(id),
            Action::Withdraw(id) => self.withdraw(id),
            Action::Start(start) => self.start(&start),
            Action::TellToEnd(id) => {
                self.note(Happened::ToldToEnd(id));
                self.rover.tell_to_end(id.get());
            }
            Action::Abort(id, cause) => self.abort(id, cause),
            Action::Pause(id) => self.pause(id),
            Action::Resume(id) => self.resume(id),
            Action::NotStarted(id, why) => self.note(Happened::NotStarted { id, why }),
            Action::BlockOver(id) => {
                let (outcome, data) = (Outcome::Succeeded, Bytes::ZERO);
                self.note(Happened::Ended { id, outcome, data });
            }
            Action::Heat { zone, on } => self.heat(&zone, on),
            Action::Wake(takes) => self.computer.pending = Some((Mode::WakingUp, takes)),
            Action::ShutDown(takes) => self.computer.pending = Some((Mode::ShuttingDown, takes)),
            Action::Replan(why) => self.replan(why, planner)?,
            Action::LoadNext(name) => {
                let next = self.setup.next.clone();
                let next = next.ok_or_else(|| format!("there is no plan `{name}` on board"));
                self.events.push_back(Event::Next(next));
            }
            Action::HandedOver => {
                let plan = Box::new(Plan::clone(self.control.plan()));
                self.note(Happened::HandedOver(plan));
            }
            Action::NoNextPlan(why) => self.note(Happened::NoNextPlan(why)),
        }
        Ok(())
    }

    fn replan(&mut self, why: Vec<Why>, planner: &mut dyn Planner) -> Result<(), NotRehearsed> {
        let incumbent = self.control.is_timed().then(|| self.control.incumbent());
        if let Some(incumbent) = &incumbent {
            self.note_pushed(incumbent);
        }
        let (plan, parameters) = (self.true_plan(), &self.setup.parameters);
        let state = Box::new(self.control.state().clone());
        let timed = planner.plan(plan, parameters, &state, incumbent.as_ref());
        let timed = Box::new(timed.map_err(NotRehearsed::NoPlan)?);
        self.note(Happened::Planned { why, state, timed: timed.clone() });
        self.events.push_back(Event::Adopt(timed));
        Ok(())
    }

    /// Whoever plans has the plan as it is, whatever the control thread believes.
    fn true_plan(&self) -> &Plan {
        let believes = self.setup.breaks.believes.is_some();
        if believes { &self.setup.plan } else { self.control.plan() }
    }

    fn note_pushed(&mut self, incumbent: &TimedPlan) {
        let before = self.control.timed();
        let slots = incumbent.rows.iter().filter_map(|row| Some((row.id, incumbent.slot(row.id)?)));
        let pushed: Vec<_> = slots.filter(|(id, slot)| before.slot(*id) != Some(*slot)).collect();
        for (id, slot) in pushed {
            self.note(Happened::Pushed { id, slot });
        }
    }

    fn activity(&self, id: ActivityId) -> Option<Activity> {
        self.control.plan().activities.iter().find(|one| one.id == id).cloned()
    }

    pub(crate) fn zone(&self, name: &str) -> Option<usize> {
        self.setup.parameters.zones.iter().position(|zone| zone.name == name)
    }

    /// How warm a zone must be, and how fast it cools.
    pub(crate) fn zone_needs(&self, _: usize) -> (i64, i64) {
        (crate::model::NEEDED, crate::model::COOLS)
    }

    fn request(&mut self, id: ActivityId) {
        self.note(Happened::Requested(id));
        self.unseated.insert(id);
        self.seat(id);
    }

    /// Asks for a place and for devices; again later, if there is no place.
    pub(crate) fn seat(&mut self, id: ActivityId) {
        let Some(activity) = self.activity(id) else { return };
        let units =
            activity.sequence.as_ref().map_or(&[][..], |name| self.setup.sequences.of(name));
        let (plan, parameters) = (self.control.plan(), &self.setup.parameters);
        let needs = Needs {
            draw: activity.peak,
            categories: activity.resources,
            switches: units.iter().map(|unit| Switch::Unit(*unit)).collect(),
            engines: activity.engines,
            priority: ticket_priority(plan, parameters, activity.priority),
        };
        if let Ok(seat) = self.station.request(&needs) {
            self.seats.insert(id, Held { seat, started: false });
            self.unseated.remove(&id);
        }
    }

    fn withdraw(&mut self, id: ActivityId) {
        self.unseated.remove(&id);
        if let Some(held) = self.seats.remove(&id) {
            self.station.release(held.seat);
        }
    }

    fn start(&mut self, start: &Start) {
        let dispatch = self.dispatch(start);
        self.note(Happened::Dispatched(Box::new(dispatch)));
        let Some(activity) = self.activity(start.id) else { return };
        let spec = self.spec(&activity, start.slot.length());
        let Some(held) = self.seats.get_mut(&start.id) else { return };
        held.started = true;
        held.seat.command(RoverCommand::On);
        let spec = RunSpec { place: held.seat.place, ..spec };
        self.rover.start(start.id.get(), spec);
    }

    /// What it really takes: drawn long before. An expanding activity goes as
    /// far as it would in its longest time, if nobody told it to end.
    fn spec(&self, activity: &Activity, planned: Span) -> RunSpec {
        let draw = self.draws.of(activity.id);
        let whole = match activity.kind {
            Kind::Expanding { .. } => activity.duration,
            _ => planned,
        };
        let length = share(whole.get(), draw.length).max(1);
        let zones = activity.zones.iter().filter_map(|name| self.zone(name));
        RunSpec {
            place: 0,
            length: duration(Span::new(length)),
            ending: duration(draw.ending),
            succeeds: draw.succeeds,
            average: part(activity.marginal, draw.power),
            peak: part(activity.peak, draw.power).max(part(activity.marginal, draw.power)),
            engines: activity.engines,
            data: share(activity.data.get(), draw.data),
            zones: zones.collect(),
        }
    }

    /// Its sequence stands still. That its tickets are revoked does not stop it:
    /// what nobody else needs is not made safe until somebody does.
    fn pause(&mut self, id: ActivityId) {
        self.note(Happened::Paused(id));
        if !self.setup.breaks.goes_on {
            self.rover.pause(id.get());
        }
    }

    fn resume(&mut self, id: ActivityId) {
        if let Some(held) = self.seats.get(&id) {
            self.station.see_on(&held.seat);
            held.seat.command(RoverCommand::On);
        }
        self.rover.resume(id.get());
        self.note(Happened::Resumed(id));
    }

    /// Revokes, makes safe, and makes sure that no command is accepted any more.
    fn abort(&mut self, id: ActivityId, cause: Cause) {
        let held = self.seats.remove(&id);
        let revoked = held.as_ref().is_some_and(|held| self.station.revoke(&held.seat));
        self.station.service();
        let stands_still =
            held.as_ref().is_some_and(|held| !self.rover.place_is_on(held.seat.place));
        let refuses = held.as_ref().is_some_and(|held| held.seat.refuses());
        let data = Bytes::new(self.rover.give_up(id.get()));
        self.note(Happened::Aborted { id, cause, data });
        if revoked && refuses {
            self.note(Happened::Revoked(id));
        }
        if stands_still {
            self.note(Happened::Safed(id));
        }
        if let Some(held) = held {
            self.station.release(held.seat);
        }
        self.events.push_back(Event::Data(id, data));
    }

    fn heat(&mut self, name: &str, on: bool) {
        let Some(zone) = self.zone(name) else { return };
        let switch = Switch::Heater(zone);
        if on {
            if let Ok(ticket) = self.station.switch(switch, GENERATED) {
                self.heaters.insert(zone, Heater { ticket, on: false });
            }
        } else if let Some(heater) = self.heaters.remove(&zone) {
            let was_on = heater.on && heater.ticket.invoke(RoverCommand::Off).is_ok();
            drop(heater);
            self.station.switch_released(switch);
            if was_on {
                self.note(Happened::Heater { zone: name.to_owned(), on: false });
            }
        }
    }
}
