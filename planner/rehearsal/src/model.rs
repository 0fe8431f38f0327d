//! The rover of a plan: what the parameters say, and what really is.

use faregate_devices_sim::Dice;
use faregate_devices_sim::rover::{
    ComputerModel, RoverFault, RoverModel, RoverScript, WindowModel, ZoneModel,
};
use faregate_planner::parameters::{Load, Zone};
use faregate_planner::state::{Mode, Window};
use faregate_planner::units::{Span, Time};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

use crate::script::Mishap;
use crate::sequences::Sequences;
use crate::{LEAD, Setup};

/// How many sequences, windows and others can be active at a time.
pub(crate) const PLACES: usize = 24;
/// How fast a zone warms, in thousandths of a degree in a second.
const WARMS: i64 = 25;
/// How fast it follows its surroundings.
pub(crate) const COOLS: i64 = 8;
/// How warm it must be.
pub(crate) const NEEDED: i64 = -40_000;
/// What heating really takes, in thousandths of what the table says: some zones
/// are slower than their tables.
const HEATING: (u64, u64) = (750, 1_010);

/// The instant on the rover's clock.
pub(crate) fn instant(setup: &Setup, at: Time) -> Instant {
    Instant::START.after(LEAD).after(duration(at.since(setup.state.now)))
}

/// The plan's time at an instant of the rover's clock.
pub(crate) fn time(setup: &Setup, at: Instant) -> Time {
    let us = at.as_micros().saturating_sub(LEAD.as_micros());
    setup.state.now.after(Span::new(i64::try_from(us / 1_000).unwrap_or(i64::MAX)))
}

pub(crate) fn duration(span: Span) -> Duration {
    Duration::from_millis(u64::try_from(span.get()).unwrap_or(0))
}

pub(crate) fn rover(setup: &Setup) -> RoverModel {
    let parameters = &*setup.parameters;
    let state = &setup.state;
    let zones = (0..).zip(&parameters.zones).map(|(number, one)| zone(setup, number, one));
    let before = state.now.before(Span::new(1));
    let windows = state.windows.iter().map(|one| window(setup, one));
    RoverModel {
        generation: parameters.rtg,
        base: parameters.base,
        capacity: state.capacity,
        stored: state.charge,
        computer: computer(setup),
        zones: zones.collect(),
        units: units(setup),
        places: PLACES,
        day: duration(parameters.day.length),
        time_of_day: duration(parameters.day.time_of_day(before)),
        windows: windows.collect(),
        variables: state.variables.clone(),
        senses: setup.senses,
    }
}

/// Units and engines are switches alike: the units first.
pub(crate) fn units(setup: &Setup) -> usize {
    Sequences::units() + usize::try_from(setup.parameters.engines).unwrap_or(usize::MAX / 2)
}

fn computer(setup: &Setup) -> ComputerModel {
    let parameters = &*setup.parameters;
    let load = |load: Load| (load.marginal, load.peak);
    ComputerModel {
        awake: load(parameters.awake),
        wakeup: load(parameters.wakeup.load),
        shutdown: load(parameters.shutdown.load),
        wakeup_time: duration(parameters.wakeup.duration),
        shutdown_time: duration(parameters.shutdown.duration),
        // One that shuts down is told to at once.
        is_awake: matches!(setup.state.mode, Mode::Awake | Mode::ShuttingDown),
    }
}

/// The colder it is outside, the longer the table says that heating takes. How
/// long it really takes is drawn.
fn zone(setup: &Setup, number: u64, zone: &Zone) -> ZoneModel {
    let (low, high) = HEATING;
    let drawn = low + Dice::new(setup.seed, 1 << 40 | number).below(high - low + 1);
    let warmth = |heating: Span| {
        let really = crate::draws::share(heating.get(), drawn);
        NEEDED.saturating_sub(WARMS.saturating_mul(really) / 1_000)
    };
    let rows = zone.table.iter().map(|row| (duration(row.from), warmth(row.duration)));
    ZoneModel {
        heater: zone.load.marginal,
        peak: zone.load.peak,
        needed: NEEDED,
        warms: WARMS,
        cools: COOLS,
        surroundings: rows.collect(),
    }
}

fn window(setup: &Setup, window: &Window) -> WindowModel {
    WindowModel {
        start: instant(setup, window.start.max(setup.state.now)),
        end: instant(setup, window.end.max(setup.state.now)),
        average: window.marginal,
        peak: window.peak,
        data: window.data.get(),
    }
}

pub(crate) fn script(setup: &Setup) -> RoverScript {
    let at = |time: &Time| instant(setup, *time);
    let zone = |name: &String| setup.parameters.zones.iter().position(|zone| zone.name == *name);
    let faults = setup.script.0.iter().filter_map(|mishap| match mishap {
        Mishap::HeaterDead { zone: name, from, until } => {
            let (zone, from, until) = (zone(name)?, at(from), at(until));
            Some(RoverFault::HeaterDead { zone, from, until })
        }
        Mishap::SensorsSilent { from, until } => {
            Some(RoverFault::SensorsSilent { from: at(from), until: at(until) })
        }
        Mishap::Drain { from, until, load } => {
            Some(RoverFault::Drain { from: at(from), until: at(until), load: *load })
        }
        Mishap::Discharge { at: when, energy } => {
            Some(RoverFault::Discharge { at: at(when), energy: *energy })
        }
        Mishap::Variable { at: when, name, value } => {
            Some(RoverFault::Variable { at: at(when), name: name.clone(), value: *value })
        }
        Mishap::Window { at: when, index, becomes } => Some(RoverFault::Window {
            at: at(when),
            index: *index,
            becomes: becomes.as_ref().map(|one| window(setup, one)),
        }),
        Mishap::Commandeered { .. } | Mishap::Veto { .. } | Mishap::Stop { .. } => None,
    });
    RoverScript(faults.collect())
}

/// So many thousandths of a power.
pub(crate) fn part(power: Milliwatts, thousandths: u64) -> Milliwatts {
    Milliwatts::new(power.get().saturating_mul(thousandths) / 1_000)
}
