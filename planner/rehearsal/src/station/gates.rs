//! Gates, and the agents that they are given to.

use std::ops::Range;

use faregate_agents::{Handle, Policy, Supervisor};
use faregate_devices_sim::SimClock;
use faregate_devices_sim::rover::{PlaceDriver, Rover, SwitchDriver};
use faregate_tickets::Gate;
use faregate_tickets::recorder::NoLane;

use super::{Agents, Ports, Switch};
use crate::Setup;
use crate::model::{PLACES, units};
use crate::sequences::Sequences;

/// Units, engines, heaters, and the computer last: in this order.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) engines: Range<usize>,
    heaters: Range<usize>,
}

impl Parts {
    fn of(setup: &Setup) -> Self {
        let units = units(setup);
        let heaters = units..units.saturating_add(setup.parameters.zones.len());
        Self { engines: Sequences::units()..units, heaters }
    }

    pub(crate) fn index(&self, switch: Switch) -> usize {
        match switch {
            Switch::Unit(unit) => unit,
            Switch::Heater(zone) => self.heaters.start.saturating_add(zone),
            Switch::Computer => self.heaters.end,
        }
    }

    pub(crate) fn switch(&self, index: usize) -> Switch {
        match index {
            unit if unit < self.heaters.start => Switch::Unit(unit),
            zone if zone < self.heaters.end => Switch::Heater(zone - self.heaters.start),
            _ => Switch::Computer,
        }
    }
}

pub(crate) struct Gates {
    places: Vec<Gate<'static, PlaceDriver, Ports>>,
    switches: Vec<Gate<'static, SwitchDriver, Ports>>,
}

pub(crate) struct Handles<'g> {
    pub(super) places: Vec<Handle<'g, PlaceDriver, Ports>>,
    pub(super) switches: Vec<Handle<'g, SwitchDriver, Ports>>,
    pub(super) parts: Parts,
}

impl Gates {
    pub(crate) fn new(rover: &Rover, setup: &Setup, clock: &SimClock) -> Option<Self> {
        let places = (0..PLACES)
            .map(|place| Some(Gate::new(rover.place_driver(place)?, clock.clone(), NoLane)));
        let units = (0..units(setup)).map(|unit| rover.unit_driver(unit));
        let heaters = (0..setup.parameters.zones.len()).map(|zone| rover.heater_driver(zone));
        let switches = units.chain(heaters).chain([rover.computer_driver()]);
        let switches = switches.map(|driver| Some(Gate::new(driver?, clock.clone(), NoLane)));
        Some(Self {
            places: places.collect::<Option<_>>()?,
            switches: switches.collect::<Option<_>>()?,
        })
    }

    /// Gives all gates to their agents. None: the broker has no room for them.
    pub(crate) fn register<'g>(
        &'g mut self,
        broker: &mut Agents<'g>,
        setup: &Setup,
    ) -> Option<(Handles<'g>, Supervisor)> {
        let parts = Parts::of(setup);
        let limit = Policy::power_margin(setup.parameters.peak_limit).with_categories();
        let power = broker.agent(limit).ok()?;
        let units = broker.agent(Policy::unlimited()).ok()?;
        let supervisor = broker.supervisor();
        let places = self.places.iter_mut().map(|gate| broker.register(power, gate.key()).ok());
        let places = places.collect::<Option<_>>()?;
        let switches = (0..).zip(&mut self.switches).map(|(index, gate)| {
            let heater = matches!(parts.switch(index), Switch::Heater(_));
            broker.register(if heater { power } else { units }, gate.key()).ok()
        });
        let switches = switches.collect::<Option<_>>()?;
        Some((Handles { places, switches, parts }, supervisor))
    }
}
