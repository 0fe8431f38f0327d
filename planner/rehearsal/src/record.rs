//! What is written into the trace.

use faregate_devices_sim::rover::RoverTruth;
use faregate_planner::execute::Start;
use faregate_planner::trace::{Dispatch, Truth, ZoneSeen};
use faregate_planner::units::Bytes;
use faregate_tickets::clock::{Clock, Instant};

use crate::host::Host;

pub(crate) fn truth(truth: &RoverTruth) -> Truth {
    Truth {
        charge: truth.charge,
        load: truth.load,
        peak: truth.peak,
        engines: truth.engines,
        data: Bytes::new(truth.data),
    }
}

impl Host<'_, '_, '_> {
    pub(crate) fn dispatch(&self, start: &Start) -> Dispatch {
        let plan = self.control.plan();
        let activity = plan.activities.iter().find(|one| one.id == start.id);
        let zones = activity.into_iter().flat_map(|one| &one.zones);
        let conditions = activity.into_iter().flat_map(|one| &one.conditions);
        let variables = conditions.map(|one| {
            let known = self.control.state().variables.get(&one.name).copied();
            (one.name.clone(), known)
        });
        Dispatch {
            id: start.id,
            range: start.slot.range,
            ends: start.slot.end,
            early: start.early,
            zones: zones.filter_map(|name| self.zone_seen(name)).collect(),
            variables: variables.collect(),
        }
    }

    fn zone_seen(&self, name: &str) -> Option<ZoneSeen> {
        let index = self.zone(name)?;
        let truly = self.rover.truth().zones.get(index)?.temperature;
        let (needed, cools) = self.zone_needs(index);
        let measured = self.rover.temperature(index)?;
        let age = self.rover_now().since(measured.measured_at).as_micros() / 1_000_000;
        let drift = cools.saturating_mul(i64::try_from(age).unwrap_or(0).saturating_add(1));
        let noise = self.setup.senses.temperature_noise;
        Some(ZoneSeen {
            zone: name.to_owned(),
            ok: measured.value >= needed,
            truly,
            needed,
            margin: noise.saturating_add(drift),
        })
    }

    fn rover_now(&self) -> Instant {
        self.clock.now()
    }
}
