//! The drivers of a rover: the handles that go into gates.

use std::convert::Infallible;
use std::error::Error;
use std::fmt;
use std::sync::Arc;

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::{Declaration, Device, Effect, Profile, WhenOrphaned};

use super::Shared;

/// How long after a switch was thrown its sensor has said so.
pub const SWITCH_LAG: Duration = Duration::from_millis(5);

/// A place in which sequences run. It has no commands: a sequence that was
/// started there stops when the place is made safe.
pub struct PlaceDriver {
    shared: Arc<Shared>,
    place: usize,
}

impl PlaceDriver {
    pub(super) const fn new(shared: Arc<Shared>, place: usize) -> Self {
        Self { shared, place }
    }
}

impl Device for PlaceDriver {
    type Command = Infallible;
    type Response = Infallible;
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        Profile {
            estimate_lag: SWITCH_LAG,
            when_orphaned: WhenOrphaned::SafeAtOnce,
            // The sequence engine is on the same computer: it dies with whoever
            // holds the ticket.
            lease: Duration::MAX,
            ..Profile::new()
        }
    }

    fn declare(command: &Infallible) -> Declaration {
        match *command {}
    }

    fn issue(&mut self, command: Infallible) -> Result<Infallible, Infallible> {
        match command {}
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        let mut world = self.shared.world.lock();
        let now = self.shared.clock.now();
        world.stop(now, self.place);
        Ok(())
    }
}

/// What a switch can be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RoverCommand {
    /// Begin; of the computer: wake up.
    On,
    /// This, with so much draw declared. Given as a value, so that a gate can
    /// judge it without asking the rover.
    Drawing(Milliwatts),
    /// End; of the computer: shut down.
    Off,
}

#[derive(Clone, Copy, Debug)]
enum Switch {
    Unit(usize),
    Heater(usize),
    Computer,
}

/// A device that is on or off: a unit, a heater, or the computer.
pub struct SwitchDriver {
    shared: Arc<Shared>,
    switch: Switch,
    draw: Milliwatts,
}

impl SwitchDriver {
    pub(super) const fn unit(shared: Arc<Shared>, unit: usize) -> Self {
        Self { shared, switch: Switch::Unit(unit), draw: Milliwatts::ZERO }
    }

    pub(super) const fn heater(shared: Arc<Shared>, zone: usize, draw: Milliwatts) -> Self {
        Self { shared, switch: Switch::Heater(zone), draw }
    }

    pub(super) const fn computer(shared: Arc<Shared>) -> Self {
        Self { shared, switch: Switch::Computer, draw: Milliwatts::ZERO }
    }

    fn throw(&self, on: bool) -> Result<(), NoPower> {
        let mut world = self.shared.world.lock();
        let now = self.shared.clock.now();
        world.advance_to(now);
        let took = match self.switch {
            Switch::Unit(unit) => world.switch_unit(unit, on),
            Switch::Heater(zone) => world.switch_heater(now, zone, on),
            Switch::Computer => world.switch_computer(now, on),
        };
        if took { Ok(()) } else { Err(NoPower) }
    }
}

impl Device for SwitchDriver {
    type Command = RoverCommand;
    type Response = ();
    type Fault = NoPower;

    fn profile(&self) -> Profile {
        Profile {
            estimate_lag: SWITCH_LAG,
            when_orphaned: WhenOrphaned::SafeUnlessHeld,
            lease: Duration::MAX,
            ..Profile::new().drawing(self.draw)
        }
    }

    fn declare(command: &RoverCommand) -> Declaration {
        let (code, effect) = match *command {
            RoverCommand::Off => (0, Effect::Off),
            RoverCommand::On => (1, Effect::on(Milliwatts::ZERO)),
            RoverCommand::Drawing(draw) => (2, Effect::on(draw)),
        };
        Declaration { code, wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, command: RoverCommand) -> Result<(), NoPower> {
        self.throw(command != RoverCommand::Off)
    }

    /// The computer is not shut down because nobody commands it: it is what
    /// would command anything.
    fn safe(&mut self) -> Result<(), NoPower> {
        match self.switch {
            Switch::Computer => Ok(()),
            Switch::Unit(_) | Switch::Heater(_) => self.throw(false),
        }
    }
}

/// The device has no such thing to switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NoPower;

impl fmt::Display for NoPower {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the rover's bus has no power for it")
    }
}

impl Error for NoPower {}

impl fmt::Debug for PlaceDriver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PlaceDriver({})", self.place)
    }
}

impl fmt::Debug for SwitchDriver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SwitchDriver({:?})", self.switch)
    }
}
