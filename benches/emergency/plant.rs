//! The simulated devices of the emergency: a truth, a bell for the sensors, and
//! drivers that take no time.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use faregate_runtime::clock::MonotonicClock;
use faregate_runtime::wake::Wakeup;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::{Declaration, Device, Effect, Estimate, Power, Profile};
use faregate_tickets::id::GateId;

/// What each device draws.
pub(crate) const DRAW: Milliwatts = Milliwatts::from_watts(10);

/// What is true of the devices, by the numbers of their gates, and what their
/// sensors hear of.
#[derive(Debug)]
pub(crate) struct Plant {
    on: AtomicU64,
    /// Made safe, and not measured since.
    safed: AtomicU64,
    /// So many safing commands have no effect.
    deaf: AtomicU32,
    pub(crate) sensors: Wakeup,
}

impl Plant {
    pub(crate) fn new() -> std::io::Result<Self> {
        let [on, safed] = [AtomicU64::new(0), AtomicU64::new(0)];
        Ok(Self { on, safed, deaf: AtomicU32::new(0), sensors: Wakeup::new()? })
    }

    /// The next so many safing commands fail.
    pub(crate) fn deafen(&self, attempts: u32) {
        self.deaf.store(attempts, Ordering::SeqCst);
    }

    pub(crate) fn is_on(&self, gate: GateId) -> bool {
        self.on.load(Ordering::SeqCst) & bit(gate) != 0
    }

    /// The devices that were made safe since somebody asked.
    pub(crate) fn take_safed(&self) -> impl Iterator<Item = GateId> + use<> {
        let safed = self.safed.swap(0, Ordering::SeqCst);
        (0..64).map(GateId).filter(move |gate| safed & bit(*gate) != 0)
    }

    /// What the sensors say now.
    pub(crate) fn measure(&self, gate: GateId) -> Estimate {
        let state = if self.is_on(gate) { Power::On } else { Power::Off };
        Estimate { state, measured_at: MonotonicClock::new().now() }
    }

    fn set(&self, gate: GateId, on: bool) {
        if on {
            self.on.fetch_or(bit(gate), Ordering::SeqCst);
        } else {
            self.on.fetch_and(!bit(gate), Ordering::SeqCst);
        }
    }
}

const fn bit(gate: GateId) -> u64 {
    1 << gate.0
}

/// A driver, behind a gate or bare.
#[derive(Debug)]
pub(crate) struct Switch {
    pub(crate) plant: &'static Plant,
    pub(crate) gate: GateId,
    pub(crate) profile: Profile,
}

/// What is declared of the devices where nothing but the machine takes time.
pub(crate) fn patient() -> Profile {
    // An ordinary host may keep a thread from running for longer than a flight
    // computer would.
    Profile { overrun_factor: 250, ..declared() }
}

/// What is declared of the devices for a flight computer.
pub(crate) fn declared() -> Profile {
    // Nobody renews a lease while other emergencies are measured.
    Profile { lease: Duration::from_secs(3_600), ..Profile::new() }.drawing(DRAW)
}

impl Device for Switch {
    type Command = bool;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        self.profile
    }

    fn declare(on: &bool) -> Declaration {
        let effect = if *on { Effect::on(DRAW) } else { Effect::Off };
        Declaration { code: (*on).into(), wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, on: bool) -> Result<(), ()> {
        self.plant.set(self.gate, on);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        let spend = |left: u32| left.checked_sub(1);
        let heard =
            self.plant.deaf.fetch_update(Ordering::SeqCst, Ordering::SeqCst, spend).is_err();
        if heard {
            self.plant.set(self.gate, false);
        }
        self.plant.safed.fetch_or(bit(self.gate), Ordering::SeqCst);
        self.plant.sensors.notify();
        Ok(())
    }
}
