//! The sensors' thread: it measures, and brings what it measured to the broker.

use std::collections::VecDeque;
use std::io;

use faregate_agents::DeviceState;
use faregate_runtime::clock::MonotonicClock;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::id::GateId;
use faregate_tickets::notify::Notify;

use crate::agency::{Agency, Agents};
use crate::plant::Plant;
use crate::roles::Role;

/// How the sensors measure.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sensing {
    /// A device that was made safe, at once; nothing is lost on the way.
    Woken {
        /// The sensors' thread also does what is due then.
        serves: bool,
    },
    /// Every device once per period. What is measured is on its way for a while.
    Periodic {
        /// From one measurement to the next.
        period: Duration,
        /// From the measurement to its arrival.
        lag: Duration,
    },
}

/// Starts the thread, for as long as the bench runs.
pub(crate) fn start<N, const G: usize, const T: usize, const S: usize>(
    agency: &Agency<Agents<N, G, T, S>>,
    sensing: Sensing,
) -> io::Result<()>
where
    N: Notify + Send + 'static,
{
    let (agents, plant) = (agency.agents, agency.plant);
    let gates: Vec<GateId> = agency.devices.iter().map(|device| device.gate()).collect();
    let sense = move || match sensing {
        Sensing::Woken { serves } => when_woken(agents, plant, serves),
        Sensing::Periodic { period, lag } => once_per(period, lag, agents, plant, &gates),
    };
    Role::Sensors.start("sensors", sense).map(drop)
}

fn when_woken<N: Notify, const G: usize, const T: usize, const S: usize>(
    agents: &Agents<N, G, T, S>,
    plant: &Plant,
    serves: bool,
) {
    while plant.sensors.wait_until(None).is_ok() {
        for gate in plant.take_safed() {
            while bring(agents, gate, plant.measure(gate), serves) {}
        }
    }
}

/// Answers whether to measure again: instants are whole microseconds, and what
/// is measured in the microsecond of the safing is not later than it.
fn bring<N: Notify, const G: usize, const T: usize, const S: usize>(
    agents: &Agents<N, G, T, S>,
    gate: GateId,
    estimate: Estimate,
    serves: bool,
) -> bool {
    agents.observe(gate, estimate);
    if serves {
        agents.service();
    }
    let state = agents.device(gate).map(|device| device.state);
    let open = matches!(state, Some(DeviceState::Confirming | DeviceState::Orphaned));
    open && estimate.state == Power::Off
}

fn once_per<N: Notify, const G: usize, const T: usize, const S: usize>(
    period: Duration,
    lag: Duration,
    agents: &Agents<N, G, T, S>,
    plant: &Plant,
    gates: &[GateId],
) {
    let clock = MonotonicClock::new();
    let mut on_the_way = VecDeque::new();
    let mut next = clock.now();
    loop {
        on_the_way.extend(gates.iter().map(|gate| (*gate, plant.measure(*gate))));
        let arrived = |way: &(GateId, Estimate)| way.1.measured_at.after(lag) <= clock.now();
        while let Some((gate, estimate)) = on_the_way.pop_front_if(|way| arrived(way)) {
            agents.observe(gate, estimate);
        }
        next = next.after(period);
        // Not told of anything meanwhile: nobody knows this thread's handle.
        std::thread::park_timeout(next.since(clock.now()).into());
    }
}
