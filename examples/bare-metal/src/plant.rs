//! The simulated spacecraft: a bus of 10 W, a camera, a cutoff valve, and a
//! thruster whose own valve sticks open.
//!
//! It obeys two laws. A bus that is asked for more than it supplies trips, and
//! a spacecraft that spins too fast breaks up.

use core::cell::Cell;
use core::fmt;

use critical_section::Mutex;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::Power;

use crate::clock::CLOCK;

/// What the bus supplies.
pub(crate) const SUPPLY: Milliwatts = Milliwatts::from_watts(10);
/// What the camera draws.
pub(crate) const CAMERA: Milliwatts = Milliwatts::from_watts(8);
/// What the cutoff valve's coil draws.
pub(crate) const COIL: Milliwatts = Milliwatts::from_watts(7);
/// How long a device draws after it was told to go off.
pub(crate) const FADES: Duration = Duration::from_millis(30);
/// How long the coil must be on until the cutoff valve is shut.
const TRAVEL: Duration = Duration::from_millis(80);
/// The body rate at which the sensors raise the alarm, and at which it is over.
const ALARM: u32 = 8;
const BREAKS_UP: u32 = 200;

/// By which law the spacecraft was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Loss {
    BusTrip,
    SpinUp,
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BusTrip => "bus trip: more was drawn than the bus supplies",
            Self::SpinUp => "spin-up: the thruster was not cut off in time",
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Draw {
    Off,
    On,
    /// Told to go off, and drawing until then.
    Until(Instant),
}

impl Draw {
    fn draws(self, now: Instant) -> bool {
        match self {
            Self::Off => false,
            Self::On => true,
            Self::Until(end) => now < end,
        }
    }

    fn fade(&mut self, now: Instant) {
        if *self == Self::On {
            *self = Self::Until(now.after(FADES));
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct State {
    camera: Draw,
    /// What the camera was told, which is not what it is.
    told_on: bool,
    coil: Draw,
    coil_since: Instant,
    shut: bool,
    thruster_stuck: bool,
    rate: u32,
    deaf_to_safing: u8,
    lost: Option<Loss>,
}

/// The spacecraft.
#[derive(Debug)]
pub(crate) struct Plant(Mutex<Cell<State>>);

/// The only one, as with hardware.
pub(crate) static PLANT: Plant = Plant(Mutex::new(Cell::new(State {
    camera: Draw::Off,
    told_on: false,
    coil: Draw::Off,
    coil_since: Instant::START,
    shut: false,
    thruster_stuck: false,
    rate: 0,
    deaf_to_safing: 0,
    lost: None,
})));

impl Plant {
    fn with<R>(&self, f: impl FnOnce(&mut State, Instant) -> R) -> R {
        critical_section::with(|masked| {
            let cell = self.0.borrow(masked);
            let mut state = cell.get();
            let now = CLOCK.now();
            let result = f(&mut state, now);
            state.obey_the_bus(now);
            cell.set(state);
            result
        })
    }

    pub(crate) fn switch_camera(&self, on: bool) {
        self.with(|state, now| {
            state.told_on = on;
            if on { state.camera = Draw::On } else { state.camera.fade(now) }
        });
    }

    /// A transient fault may defeat it.
    pub(crate) fn safe_camera(&self) {
        self.with(|state, now| {
            state.told_on = false;
            match state.deaf_to_safing.checked_sub(1) {
                Some(left) => state.deaf_to_safing = left,
                None => state.camera.fade(now),
            }
        });
    }

    pub(crate) fn switch_coil(&self, on: bool) {
        self.with(|state, now| {
            if on && state.coil != Draw::On {
                (state.coil, state.coil_since) = (Draw::On, now);
            } else if !on {
                state.coil.fade(now);
            }
        });
    }

    /// The sensors' period has passed.
    pub(crate) fn pass(&self) {
        self.with(|state, now| {
            state.shut |= state.coil == Draw::On && now >= state.coil_since.after(TRAVEL);
            if state.thruster_stuck && !state.shut {
                state.rate += 1;
            }
            if state.rate >= BREAKS_UP {
                state.lost = state.lost.or(Some(Loss::SpinUp));
            }
        });
    }

    /// The cutoff valve is open, and the next safing commands of the camera are
    /// lost on their way.
    pub(crate) fn make_ready(&self, deaf_to_safing: u8) {
        self.with(|state, _| {
            state.shut = false;
            state.thruster_stuck = false;
            state.rate = 0;
            state.deaf_to_safing = deaf_to_safing;
        });
    }

    pub(crate) fn stick_the_thruster(&self) {
        self.with(|state, _| state.thruster_stuck = true);
    }

    /// What the sensors measure of the camera and of the coil.
    pub(crate) fn measure(&self) -> (Power, Power) {
        self.with(|state, now| {
            let power = |on| if on { Power::On } else { Power::Off };
            // The break: what it was told counts for what it is.
            let told = cfg!(feature = "break-confirmation");
            let camera = if told { state.told_on } else { state.camera.draws(now) };
            (power(camera), power(state.coil.draws(now)))
        })
    }

    pub(crate) fn alarm(&self) -> bool {
        self.with(|state, _| state.rate >= ALARM && !state.shut)
    }

    pub(crate) fn is_shut(&self) -> bool {
        self.with(|state, _| state.shut)
    }

    pub(crate) fn camera_is_on(&self) -> bool {
        self.with(|state, _| state.camera == Draw::On)
    }

    pub(crate) fn lost(&self) -> Option<Loss> {
        self.with(|state, _| state.lost)
    }
}

impl State {
    fn obey_the_bus(&mut self, now: Instant) {
        let camera = if self.camera.draws(now) { CAMERA } else { Milliwatts::ZERO };
        let coil = if self.coil.draws(now) { COIL } else { Milliwatts::ZERO };
        if camera.saturating_add(coil) > SUPPLY {
            self.lost = self.lost.or(Some(Loss::BusTrip));
        }
    }
}
