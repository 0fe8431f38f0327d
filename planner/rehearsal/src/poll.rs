//! What has happened since the last look: at the rover, and at the tickets.

use std::collections::BTreeMap;

use faregate_devices_sim::rover::{ComputerMode, RoverCommand, RoverEvent};
use faregate_planner::ActivityId;
use faregate_planner::execute::Event;
use faregate_planner::plan::Outcome;
use faregate_planner::state::{Mode, Window};
use faregate_planner::trace::Happened;
use faregate_planner::units::Bytes;
use faregate_tickets::clock::Instant;

use crate::host::Host;
use crate::model;
use crate::rank::EMERGENCY;
use crate::script::Mishap;
use crate::station::{Needs, Seat, Switch, Turn};

impl<'b, 'g> Host<'_, 'b, 'g> {
    pub(crate) fn poll(&mut self) {
        self.hear();
        self.poll_script();
        self.poll_computer();
        self.poll_heaters();
        self.poll_seats();
        // What followed from these commands at once.
        self.hear();
    }

    fn hear(&mut self) {
        for (_, event) in self.rover.take_events() {
            self.rover_says(event);
        }
    }

    fn rover_says(&mut self, event: RoverEvent) {
        match event {
            RoverEvent::Finished { key, succeeded, data } => self.finished(key, succeeded, data),
            // Found at its ticket.
            RoverEvent::Stopped(_) => {}
            RoverEvent::Computer(mode) => self.computer_does(mode),
            RoverEvent::Sensed => self.sensed(),
            RoverEvent::Variable(name) => {
                let value = self.rover.variable(&name);
                self.note(Happened::Variable { name: name.clone(), value });
                self.events.push_back(Event::Variable(name, value));
            }
            RoverEvent::Window { index, open } => self.window(index, open),
            RoverEvent::Replanned => self.windows_changed(),
        }
    }

    fn finished(&mut self, key: u32, succeeded: bool, data: i64) {
        let Some(id) = ActivityId::new(key) else { return };
        if let Some(held) = self.seats.remove(&id) {
            held.seat.command(RoverCommand::Off);
            self.station.release(held.seat);
        }
        let outcome = if succeeded { Outcome::Succeeded } else { Outcome::Failed };
        let data = Bytes::new(data);
        self.note(Happened::Ended { id, outcome, data });
        self.events.push_back(Event::Ended(id, outcome, data));
    }

    fn sensed(&mut self) {
        let running: Vec<_> = self.control.state().running.iter().map(|one| one.id).collect();
        for id in running {
            let data = Bytes::new(self.rover.data_of(id.get()));
            self.events.push_back(Event::Data(id, data));
        }
        let Some(charge) = self.rover.charge().map(|measured| measured.value) else { return };
        self.note(Happened::Estimate { charge });
        let zones = self.setup.parameters.zones.iter().enumerate().map(|(index, zone)| {
            let (needed, _) = self.zone_needs(index);
            let warm = self.rover.temperature(index).is_some_and(|one| one.value >= needed);
            (zone.name.clone(), warm)
        });
        let zones: BTreeMap<_, _> = zones.collect();
        self.events.push_back(Event::Estimate { charge, zones });
    }

    fn computer_does(&mut self, mode: ComputerMode) {
        let mode = match mode {
            ComputerMode::Asleep => Mode::Asleep,
            ComputerMode::WakingUp => Mode::WakingUp,
            ComputerMode::Awake => Mode::Awake,
            ComputerMode::ShuttingDown => Mode::ShuttingDown,
        };
        self.note(Happened::Mode(mode));
        self.hold_phase(mode);
        self.events.push_back(Event::Mode(mode));
    }

    fn windows_changed(&mut self) {
        let models = self.rover.windows();
        let setup = self.setup;
        for (window, model) in self.known.iter_mut().zip(models) {
            window.start = model::time(setup, model.start);
            window.end = model::time(setup, model.end);
            (window.marginal, window.peak) = (model.average, model.peak);
            window.data = Bytes::new(model.data);
        }
        let open = |window: &&Window| window.start < window.end;
        let windows = self.known.iter().filter(open).cloned().collect();
        self.events.push_back(Event::Windows(windows));
    }

    fn poll_seats(&mut self) {
        for id in self.unseated.clone() {
            self.seat(id);
        }
        let mut turns: Vec<_> = self
            .seats
            .iter_mut()
            .filter_map(|(id, held)| Some((*id, held.seat.turn()?, held.started)))
            .collect();
        // What was taken makes room for what is granted.
        turns.sort_by_key(|(_, turn, _)| *turn != Turn::Taken);
        for (id, turn, started) in turns {
            match (turn, started) {
                (Turn::Taken, true) => {
                    if let Some(held) = self.seats.get(&id) {
                        self.station.expect_off(&held.seat);
                    }
                    self.note(Happened::Revoked(id));
                    self.events.push_back(Event::Taken(id));
                }
                (Turn::Returned, true) => self.events.push_back(Event::Returned(id)),
                (Turn::Granted | Turn::Returned, false) => {
                    if let Some(held) = self.seats.get(&id) {
                        self.station.see_on(&held.seat);
                    }
                    self.events.push_back(Event::Granted(id));
                }
                (Turn::Granted, true) | (Turn::Taken, false) => {}
            }
        }
    }

    /// Heaters whose tickets came, went, or came back.
    fn poll_heaters(&mut self) {
        let mut changed = Vec::new();
        for (zone, heater) in &mut self.heaters {
            let peak = self.setup.parameters.zones.get(*zone).map(|zone| zone.load.peak);
            let valid = heater.ticket.check().is_ok();
            if valid == heater.on {
                continue;
            }
            let command = RoverCommand::Drawing(peak.unwrap_or_default());
            heater.on = valid && heater.ticket.invoke(command).is_ok();
            changed.push((*zone, heater.on));
        }
        for (index, on) in changed {
            if !on {
                self.station.switch_released(Switch::Heater(index));
            }
            let zone = self.setup.parameters.zones.get(index).map(|zone| zone.name.clone());
            self.note(Happened::Heater { zone: zone.unwrap_or_default(), on });
        }
    }

    fn poll_script(&mut self) {
        let now = self.now();
        let setup = self.setup;
        self.notice_leaks();
        for (index, mishap) in setup.script.0.iter().enumerate() {
            let (from, until) = match mishap {
                Mishap::Veto { at, .. }
                | Mishap::Stop { at, .. }
                | Mishap::Discharge { at, .. } => (*at, *at),
                Mishap::Commandeered { from, until, .. } => (*from, *until),
                _ => continue,
            };
            if from <= now && !self.others.contains_key(&index) {
                let seat = self.begin_mishap(mishap);
                self.others.insert(index, seat);
            } else if until <= now
                && let Some(seat) = self.others.get_mut(&index).and_then(Option::take)
            {
                self.station.release(seat);
            }
        }
    }

    /// The rover drains itself: here it is put on record, for whoever adds up.
    fn notice_leaks(&mut self) {
        let leak = self.setup.script.leak(self.now());
        if leak != std::mem::replace(&mut self.leak, leak) {
            self.note(Happened::Leak(leak));
        }
    }

    fn begin_mishap(&mut self, mishap: &Mishap) -> Option<Seat<'b, 'g>> {
        match mishap {
            Mishap::Veto { id, .. } => self.events.push_back(Event::Veto(*id)),
            Mishap::Stop { id, .. } => self.events.push_back(Event::Stop(*id)),
            Mishap::Discharge { energy, .. } => self.note(Happened::Lost(*energy)),
            Mishap::Commandeered { draw, resources, .. } => {
                let needs = Needs {
                    draw: *draw,
                    categories: *resources,
                    switches: Vec::new(),
                    engines: 0,
                    priority: EMERGENCY,
                };
                return self.station.request(&needs).ok();
            }
            _ => {}
        }
        None
    }

    pub(crate) fn next_of_script(&self) -> Option<Instant> {
        let now = self.now();
        let instants = self.setup.script.0.iter().flat_map(|mishap| match mishap {
            Mishap::Veto { at, .. } | Mishap::Stop { at, .. } => [*at, *at],
            Mishap::Commandeered { from, until, .. } => [*from, *until],
            _ => [now, now],
        });
        let next = instants.filter(|at| *at > now).min();
        next.map(|at| model::instant(self.setup, at))
    }
}
