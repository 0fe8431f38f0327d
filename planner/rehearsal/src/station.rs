//! The ticket agents of the rover, with a place for each running sequence and a
//! gate for each switch.
//!
//! One agent has the places, the power and the conflict categories: a place is
//! declared anew as the activity that has it, with its peak power and its
//! resource bits. Another one has the units and the sequence engines: each is
//! one tenant's at a time. The heaters are with the power, too.

mod gates;
mod seat;
mod sensors;

use faregate_agents::{Broker, Categories, Handle, Redeclared, RequestRefused, Supervisor, Want};
use faregate_devices_sim::SimClock;
use faregate_devices_sim::rover::{PlaceDriver, Rover, SWITCH_LAG, SwitchDriver};
use faregate_tickets::Ticket;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::id::Priority;
use faregate_tickets::lock::Locked;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;
use faregate_tickets::validity::Validity;

pub(crate) use gates::Gates;
use gates::Parts;
use seat::SeatState;
pub(crate) use seat::{Seat, Turn};
use sensors::Sensor;

type Strategy = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;
pub(crate) type Ports = (Strategy, SimClock, NoLane);
pub(crate) type Agents<'g> = Broker<'g, Ports, NoNotify, 64, 64, 40>;
pub(crate) type PlaceTicket<'b, 'g> = Ticket<'b, PlaceDriver, Ports, Agents<'g>>;
pub(crate) type SwitchTicket<'b, 'g> = Ticket<'b, SwitchDriver, Ports, Agents<'g>>;
type Wants<'g> = heapless::Vec<Want<'g, SwitchDriver, Ports>, MOST_SWITCHES>;

/// Beside its place, an activity can have so many units and engines.
pub(crate) const MOST_SWITCHES: usize = 7;

/// What an activity, a window or a phase of the computer needs.
#[derive(Clone, Debug)]
pub(crate) struct Needs {
    pub(crate) draw: Milliwatts,
    pub(crate) categories: Categories,
    pub(crate) switches: Vec<Switch>,
    pub(crate) engines: u32,
    pub(crate) priority: Priority,
}

/// A device that is on or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    /// A unit or an engine, by its number.
    Unit(usize),
    Heater(usize),
    Computer,
}

pub(crate) struct Station<'b, 'g> {
    broker: &'b Agents<'g>,
    supervisor: Supervisor,
    places: Vec<Place<'g>>,
    switches: Vec<Handle<'g, SwitchDriver, Ports>>,
    parts: Parts,
    /// Gates that are to be seen off, and when their sensors say so.
    leaving: Vec<(Instant, Sensor)>,
    clock: SimClock,
    rover: Rover,
}

struct Place<'g> {
    handle: Handle<'g, PlaceDriver, Ports>,
    held: bool,
}

impl<'b, 'g> Station<'b, 'g> {
    pub(crate) fn new(
        broker: &'b Agents<'g>,
        handles: gates::Handles<'g>,
        supervisor: Supervisor,
        clock: SimClock,
        rover: Rover,
    ) -> Self {
        let places = handles.places.into_iter().map(|handle| Place { handle, held: false });
        let mut station = Self {
            broker,
            supervisor,
            places: places.collect(),
            switches: handles.switches,
            parts: handles.parts,
            leaving: Vec::new(),
            clock,
            rover,
        };
        station.see_all_off();
        station
    }

    /// At the begin everything is off, and somebody has to say so: after it was
    /// made safe once.
    fn see_all_off(&mut self) {
        self.broker.service();
        self.clock.advance_to(self.clock.now().after(SWITCH_LAG));
        let places = (0..self.places.len()).map(Sensor::Place);
        let switches = (0..self.switches.len()).map(Sensor::Switch);
        let all: Vec<_> = places.chain(switches).collect();
        for sensor in all {
            self.measure(sensor);
        }
        self.broker.service();
    }

    /// Does what is due at the agents; when something is due next.
    pub(crate) fn service(&mut self) -> Option<Instant> {
        let due = self.broker.service();
        due.filter(|at| *at < Instant::FAR_FUTURE)
    }

    /// Asks for a place and for what else it needs, all or nothing.
    pub(crate) fn request(&mut self, needs: &Needs) -> Result<Seat<'b, 'g>, RequestRefused> {
        let place = self.free_place(needs)?;
        let handle = self.places.get(place).map(|one| one.handle);
        let handle = handle.ok_or(RequestRefused::UnknownGate)?;
        let switches = self.switches_of(needs);
        let mut wants = Wants::new();
        for switch in &switches {
            let full = RequestRefused::NoCapacity(faregate_agents::Capacity::SetGates);
            let want = self.switches.get(*switch).map(|one| one.limited(Validity::always()));
            wants.push(want.ok_or(RequestRefused::UnknownGate)?).map_err(|_| full)?;
        }
        let asked = (handle.limited(Validity::always()), wants);
        let (ticket, tickets) = self.broker.request(needs.priority, &asked)?;
        if let Some(place) = self.places.get_mut(place) {
            place.held = true;
        }
        let devices = switches.into_iter().zip(tickets).collect();
        Ok(Seat { place, ticket, devices, state: SeatState::Waits })
    }

    fn free_place(&mut self, needs: &Needs) -> Result<usize, RequestRefused> {
        let declared = Redeclared {
            draw: needs.draw,
            categories: needs.categories,
            settling: Duration::ZERO,
            estimate_lag: SWITCH_LAG,
        };
        let declares = |place: &Place<'g>| self.broker.redeclare(&place.handle, &declared).is_ok();
        let fits = |(index, place): (usize, &Place<'g>)| {
            // Off, and not measured since it was made safe.
            let measured = || {
                self.measure(Sensor::Place(index));
                declares(place)
            };
            !place.held && (declares(place) || measured())
        };
        let found = self.places.iter().enumerate().position(fits);
        found.ok_or(RequestRefused::NoCapacity(faregate_agents::Capacity::Seats))
    }

    /// Engines are alike: those that nobody has come first.
    fn switches_of(&self, needs: &Needs) -> Vec<usize> {
        let mut engines: Vec<_> = self.parts.engines.clone().collect();
        engines.sort_by_key(|switch| self.tenant_level(*switch));
        let engines = engines.into_iter().take(usize::try_from(needs.engines).unwrap_or(0));
        let others = needs.switches.iter().map(|switch| self.parts.index(*switch));
        let mut all: Vec<_> = others.chain(engines).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn tenant_level(&self, switch: usize) -> bool {
        let gate = self.switches.get(switch).map(Handle::gate);
        let report = gate.and_then(|gate| self.broker.device(gate));
        report.is_some_and(|report| report.tenant.is_some())
    }

    /// Revokes what a seat has: one increment; its devices are made safe by the
    /// service that follows.
    pub(crate) fn revoke(&self, seat: &Seat<'b, 'g>) -> bool {
        let barred = self.broker.bar(&self.supervisor, seat.ticket.id());
        barred.map(faregate_agents::Revoked::without_waiting).is_ok() && seat.check().is_err()
    }

    /// Gives a seat's tickets back. Its devices are seen off when their sensors
    /// say so.
    pub(crate) fn release(&mut self, seat: Seat<'b, 'g>) {
        let Seat { place, ticket, devices, .. } = seat;
        let due = self.clock.now().after(SWITCH_LAG);
        self.leaving.push((due, Sensor::Place(place)));
        self.leaving.extend(devices.iter().map(|(switch, _)| (due, Sensor::Switch(*switch))));
        drop((ticket, devices));
        if let Some(place) = self.places.get_mut(place) {
            place.held = false;
        }
    }

    /// What a seat has stands still, though it is not given back: its tickets
    /// were taken.
    pub(crate) fn expect_off(&mut self, seat: &Seat<'b, 'g>) {
        let due = self.clock.now().after(SWITCH_LAG);
        self.leaving.push((due, Sensor::Place(seat.place)));
        let switches = seat.devices.iter().map(|(switch, _)| (due, Sensor::Switch(*switch)));
        self.leaving.extend(switches);
    }

    /// The place is in use from now on: it is charged until it is seen off.
    pub(crate) fn see_on(&mut self, seat: &Seat<'b, 'g>) {
        let sensor = Sensor::Place(seat.place);
        if let Some(gate) = self.gate(sensor) {
            let measured_at = self.clock.now();
            self.broker.observe(gate, Estimate { state: Power::On, measured_at });
        }
    }

    /// A ticket for one switch alone: a heater, or the computer.
    pub(crate) fn switch(
        &self,
        switch: Switch,
        priority: Priority,
    ) -> Result<SwitchTicket<'b, 'g>, RequestRefused> {
        let handle = self.switches.get(self.parts.index(switch));
        self.broker.request(priority, handle.ok_or(RequestRefused::UnknownGate)?)
    }

    /// A switch alone was given back.
    pub(crate) fn switch_released(&mut self, switch: Switch) {
        let due = self.clock.now().after(SWITCH_LAG);
        self.leaving.push((due, Sensor::Switch(self.parts.index(switch))));
    }
}
