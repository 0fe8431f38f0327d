//! The simulated spacecraft: one payload for each agent that has a supply, all
//! of them on the host's clock.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use faregate_devices_sim::SimClock;
use faregate_devices_sim::payload::{Payload, Supplies, UnitSpec};
use faregate_scheduler::Mission;
use faregate_scheduler::executive::Waker;
use faregate_scheduler::tickets::{Driver, Tickets};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::Estimate;

use super::devices;
use super::driver::Simulated;
use crate::exit::Failure;
use crate::out;

/// What a bus without a limit gives: more than a spacecraft has.
const UNLIMITED: Milliwatts = Milliwatts::from_watts(u32::MAX);

/// How often the sensors' estimates are brought to the broker.
const ROUND: Duration = Duration::from_millis(5);

/// The simulated spacecraft, and the thread of its sensors, which ends with it.
#[derive(Debug)]
pub(crate) struct Craft {
    payloads: Vec<Bus>,
    clock: SimClock,
    stop: Arc<AtomicBool>,
    sensors: Option<JoinHandle<()>>,
}

/// The payload on the bus of an agent.
#[derive(Clone, Debug)]
struct Bus {
    agent: String,
    limited: bool,
    payload: Payload,
}

impl Craft {
    /// A spacecraft with the devices of this mission, all off.
    pub(crate) fn new(mission: &Mission, seed: u64) -> Result<Self, Failure> {
        let (mut units, wrong) = devices::units(mission);
        if !wrong.is_empty() {
            let named = |(device, why)| format!("device `{device}`: {why}");
            return Err(not_simulated(wrong.into_iter().map(named).collect()));
        }
        let clock = SimClock::real_time();
        let battery = devices::battery(mission).map_err(not_simulated)?;
        let payloads =
            mission.agents.iter().zip(seed..).enumerate().map(|(index, (agent, seed))| {
                let on_it = |unit: &mut UnitSpec| {
                    devices::agent_of(mission, unit.name()) == Some(&agent.name)
                };
                let units = units.extract_if(.., on_it).collect();
                let limit = agent.supply.unwrap_or(UNLIMITED);
                // The battery feeds the first bus, which the tasks' own draws are on.
                let battery = battery.filter(|_| index == 0);
                let supplies = Supplies { battery, ..Supplies::of(limit) };
                let payload = Payload::new(supplies, units, seed, &clock);
                Bus { agent: agent.name.clone(), limited: agent.supply.is_some(), payload }
            });
        let payloads = payloads.collect();
        Ok(Self { payloads, clock, stop: Arc::default(), sensors: None })
    }

    /// The drivers of its devices, each with the device's name. Each can be had
    /// once.
    pub(crate) fn drivers(&self, mission: &Mission) -> Vec<(String, Box<dyn Driver>)> {
        let driver = |name: &String| {
            let driver = self.payloads.iter().find_map(|bus| bus.payload.driver(name))?;
            let driver: Box<dyn Driver> = Box::new(Simulated(driver));
            Some((name.clone(), driver))
        };
        mission.devices.iter().filter_map(|spec| driver(&spec.name)).collect()
    }

    /// Starts the sensors: they bring estimates to the broker, and ring the bell
    /// when the battery's gauge moves, or the spacecraft is lost.
    pub(crate) fn sense(&mut self, tickets: &Tickets, waker: Waker) -> io::Result<()> {
        let broker = tickets.broker().clone();
        let commander = tickets.commander();
        let gates = commander.gates();
        let sensed: Vec<_> = self
            .payloads
            .iter()
            .flat_map(|bus| bus.payload.units().map(|name| (bus.payload.clone(), name.to_owned())))
            .filter_map(|(payload, name)| Some((gates.id(&name)?, payload, name)))
            .collect();
        let offset = offset(broker.clock().now(), &self.clock);
        let (clock, stop) = (self.clock.clone(), Arc::clone(&self.stop));
        let mut gauge = Gauge::new(self.payloads.clone());
        let round = move || {
            // Relaxed: it says nothing about other memory.
            while !stop.load(Ordering::Relaxed) {
                for (gate, payload, name) in &sensed {
                    if let Some(Estimate { state, measured_at }) = payload.estimate(name) {
                        let measured_at = measured_at.after(offset);
                        broker.observe(*gate, Estimate { state, measured_at });
                    }
                }
                if gauge.moved() {
                    waker.wake();
                }
                clock.wait_until(clock.now().after(ROUND));
            }
        };
        let thread = std::thread::Builder::new().name("sensors".into()).spawn(round)?;
        self.sensors = Some(thread);
        Ok(())
    }

    /// What the battery's gauge says; none without a battery.
    pub(crate) fn state_of_charge(&self) -> Option<u8> {
        self.payloads.iter().find_map(|bus| bus.payload.state_of_charge())
    }

    /// The tasks themselves draw this much from now on.
    pub(crate) fn set_tasks_draw(&self, draw: Milliwatts) {
        if let Some(first) = self.payloads.first() {
            first.payload.set_other_draw(draw);
        }
    }

    /// How the spacecraft was lost, if it was.
    pub(crate) fn lost(&self) -> Option<String> {
        let lost = self.payloads.iter().find_map(|bus| Some((bus, bus.payload.broken_law()?)));
        lost.map(|(bus, (at, law))| {
            format!("the spacecraft is lost: {law} on {} at {at}", bus.agent)
        })
    }

    /// What was drawn and made, in lines for people.
    pub(crate) fn report(&self) -> Vec<String> {
        self.payloads.iter().flat_map(Bus::report).collect()
    }
}

fn not_simulated(wrong: Vec<String>) -> Failure {
    Failure::failed(format!("the mission cannot be simulated:\n{}", wrong.join("\n")))
}

impl Bus {
    fn report(&self) -> Vec<String> {
        let truth = self.payload.truth();
        let mut lines = Vec::new();
        if self.limited && truth.largest_draw.is_zero() {
            lines.push(format!("{}: nothing was drawn of {}", self.agent, truth.supply));
        } else if self.limited {
            let us = truth.at.since(Instant::START).as_micros().max(1);
            let mean = u128::from(truth.energy.get()) * 1_000 / u128::from(us);
            let mean = Milliwatts::new(u64::try_from(mean).unwrap_or(u64::MAX));
            let part = mean.get() * 100 / truth.supply.get().max(1);
            lines.push(format!(
                "{}: never more than {} of {}; {} on average, {part} %",
                self.agent,
                truth.largest_draw,
                truth.supply,
                out::about(mean)
            ));
        }
        for unit in truth.units.iter().filter(|unit| unit.finished + unit.lost > 0) {
            lines.push(format!("{}: {} finished, {} lost", unit.name, unit.finished, unit.lost));
        }
        lines
    }
}

/// What is watched beside the switches.
struct Gauge {
    payloads: Vec<Bus>,
    shown: BTreeMap<usize, (Option<u8>, bool)>,
}

impl Gauge {
    fn new(payloads: Vec<Bus>) -> Self {
        Self { payloads, shown: BTreeMap::new() }
    }

    /// Whether it shows something else than last time.
    fn moved(&mut self) -> bool {
        let mut moved = false;
        for (index, Bus { payload, .. }) in self.payloads.iter().enumerate() {
            let shows = (payload.state_of_charge(), payload.broken_law().is_some());
            moved |= self.shown.insert(index, shows) != Some(shows);
        }
        moved
    }
}

/// What the broker's clock shows more than the spacecraft's, by which its
/// sensors date their measurements.
///
/// Read in this order, and less one unit for the rounding, it is never too
/// much: a measurement may look a few microseconds too old, which costs a
/// little time, and never too young, which could cost the spacecraft.
fn offset(ours: Instant, clock: &SimClock) -> Duration {
    ours.since(clock.now().after(Duration::from_micros(1)))
}

impl Drop for Craft {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(sensors) = self.sensors.take() {
            // If it panicked, that has been printed.
            let _ = sensors.join();
        }
    }
}
