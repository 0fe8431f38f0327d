//! What goes wrong, as a script: values, not flags in the code.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

use crate::device::DeviceId;
use crate::random::Dice;

/// One thing that goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// From then on the thruster valve is open, whatever it is told.
    ThrusterSticksOpen {
        /// When.
        at: Instant,
    },
    /// The camera ignores so many commands to switch off. The driver cannot
    /// tell.
    CameraOffFails {
        /// From when on they are counted.
        from: Instant,
        /// How many.
        attempts: u8,
    },
    /// An upset switches the camera off.
    CameraUpset {
        /// When.
        at: Instant,
    },
    /// The generator's output falls to this.
    GenerationFalls {
        /// When.
        at: Instant,
        /// To what.
        to: Milliwatts,
    },
    /// The device's `nth` command goes wrong inside its driver.
    CommandFails {
        /// Whose.
        device: DeviceId,
        /// Which, counted from 1, safing and bare commands included.
        nth: u32,
        /// In which way.
        how: Failing,
    },
    /// A sensor measures nothing: its last estimate grows old.
    SensorSilent {
        /// Whose.
        device: DeviceId,
        /// From when on.
        from: Instant,
        /// Until when.
        until: Instant,
    },
    /// A sensor measures, and cannot say what.
    SensorBlind {
        /// Whose.
        device: DeviceId,
        /// From when on.
        from: Instant,
        /// Until when.
        until: Instant,
    },
}

/// How a command can fail inside a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Failing {
    /// It takes this much longer, and then reaches the device after all.
    Hangs {
        /// How much longer.
        lasting: Duration,
    },
    /// The driver says that the hardware did not take it, and it is true.
    Faults,
    /// The driver panics, without a message on the terminal.
    Panics,
}

/// Everything that goes wrong in one simulated flight.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FaultScript(Vec<Fault>);

impl FaultScript {
    /// Nothing goes wrong.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// And this goes wrong, too.
    #[must_use]
    pub fn with(mut self, fault: Fault) -> Self {
        self.0.push(fault);
        self
    }

    /// The emergency, as this seed wants it: the thruster sticks open within the
    /// second half second; the camera may ignore up to two commands to switch
    /// off, and may be upset before or after.
    #[must_use]
    pub fn emergency(seed: u64) -> Self {
        let mut dice = Dice::new(seed, 3);
        let mut within = |from_us: u64, until_us: u64| {
            Instant::from_micros(from_us + dice.below(until_us - from_us))
        };
        let at = within(500_000, 1_000_000);
        let upset = Fault::CameraUpset { at: within(100_000, 2_000_000) };
        let attempts = [0, 0, 1, 2][dice.index(4)];
        let script = Self::new()
            .with(Fault::ThrusterSticksOpen { at })
            .with(Fault::CameraOffFails { from: at, attempts });
        if dice.below(2) == 0 { script.with(upset) } else { script }
    }

    /// What goes wrong.
    pub fn iter(&self) -> impl Iterator<Item = Fault> {
        self.0.iter().copied()
    }

    /// How the device's `nth` command fails.
    pub(crate) fn failing(&self, device: DeviceId, nth: u32) -> Option<Failing> {
        self.iter().find_map(|fault| match fault {
            Fault::CommandFails { device: d, nth: n, how } if (d, n) == (device, nth) => Some(how),
            _ => None,
        })
    }

    /// How many commands to switch off the camera ignores from `from` to `now`.
    pub(crate) fn ignored_offs(&self, now: Instant) -> u32 {
        let ignored = self.iter().filter_map(|fault| match fault {
            Fault::CameraOffFails { from, attempts } if from <= now => Some(u32::from(attempts)),
            _ => None,
        });
        ignored.sum()
    }

    /// The next thing that happens by itself after `now`.
    pub(crate) fn next_event(&self, now: Instant) -> Option<Instant> {
        self.iter().filter_map(|fault| fault.happens_at()).filter(|at| *at > now).min()
    }
}

impl Fault {
    /// When it happens, if it happens by itself.
    pub(crate) fn happens_at(self) -> Option<Instant> {
        match self {
            Self::ThrusterSticksOpen { at }
            | Self::CameraUpset { at }
            | Self::GenerationFalls { at, .. } => Some(at),
            _ => None,
        }
    }
}
