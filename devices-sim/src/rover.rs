//! A rover on another planet: a radioisotope generator and a battery, heaters
//! with thermal zones, units that sequences command, a computer that sleeps, and
//! communication windows.
//!
//! Unlike a [`Payload`](crate::payload::Payload) it is simulated over days: what
//! happens is a list of instants, and between them every load is constant and
//! every temperature a straight line. So a day takes milliseconds, and all of it
//! is exact in integers.
//!
//! What it needs to execute goes in as [`RunSpec`]s, with what it *really* takes:
//! nobody who plans sees them. What the planner may know is what the sensors
//! say: late, now and then, and with noise. The [truth](Rover::truth) is for
//! checkers.
//!
//! ```
//! use faregate_devices_sim::SimClock;
//! use faregate_devices_sim::rover::{ComputerMode, Rover, RoverModel, RoverScript};
//! use faregate_tickets::Device;
//! use faregate_tickets::clock::{Clock, Duration};
//!
//! let clock = SimClock::virtual_time();
//! let rover = Rover::new(RoverModel::default(), RoverScript::default(), 7, &clock);
//! let mut computer = rover.computer_driver().expect("nobody took it before");
//! computer.issue(faregate_devices_sim::rover::RoverCommand::On).expect("it has power");
//! clock.advance_to(clock.now().after(Duration::from_secs(600)));
//! assert_eq!(rover.truth().mode, ComputerMode::Awake);
//! ```

mod driver;
mod faults;
mod gauge;
mod model;
mod run;
mod thermal;
mod world;

use std::fmt;
use std::sync::Arc;

use faregate_tickets::amount::Microjoules;
use faregate_tickets::clock::{Clock, Duration, Instant};
use parking_lot::Mutex;

pub use driver::{NoPower, PlaceDriver, RoverCommand, SWITCH_LAG, SwitchDriver};
pub use faults::{RoverFault, RoverScript};
pub use model::{ComputerModel, RoverModel, Senses, WindowModel, ZoneModel};
pub use run::{RunKey, RunSpec};
pub use world::{ComputerMode, RoverEvent, RoverTruth, ZoneTruth};

use crate::clock::SimClock;
use crate::sensors::Measured;
use world::World;

/// A simulated rover; clones are the same one.
#[derive(Clone)]
pub struct Rover(Arc<Shared>);

/// What the rover and its drivers share. The lock is never held while anybody
/// waits.
pub(crate) struct Shared {
    pub(crate) clock: SimClock,
    pub(crate) world: Mutex<World>,
}

impl Rover {
    /// A rover as the model says, asleep, with every zone as cold as its
    /// surroundings. The seed decides the noise of its sensors.
    #[must_use]
    pub fn new(model: RoverModel, script: RoverScript, seed: u64, clock: &SimClock) -> Self {
        let world = Mutex::new(World::new(model, script, seed, clock.now()));
        Self(Arc::new(Shared { clock: clock.clone(), world }))
    }

    /// The driver of a place in which a sequence runs: to make it safe is to
    /// stop the sequence. None if there is no such place, or it was taken before.
    #[must_use]
    pub fn place_driver(&self, place: usize) -> Option<PlaceDriver> {
        let taken = self.now(|world, _| world.take_place(place));
        taken.then(|| PlaceDriver::new(Arc::clone(&self.0), place))
    }

    /// The driver of a unit, by its place in the model; none if it was taken.
    #[must_use]
    pub fn unit_driver(&self, unit: usize) -> Option<SwitchDriver> {
        let taken = self.now(|world, _| world.take_unit(unit));
        taken.then(|| SwitchDriver::unit(Arc::clone(&self.0), unit))
    }

    /// The driver of a zone's heater, by its place in the model; none if it was
    /// taken.
    #[must_use]
    pub fn heater_driver(&self, zone: usize) -> Option<SwitchDriver> {
        let peak = self.now(|world, _| world.take_heater(zone))?;
        Some(SwitchDriver::heater(Arc::clone(&self.0), zone, peak))
    }

    /// The driver that wakes the computer and shuts it down; none if it was
    /// taken.
    #[must_use]
    pub fn computer_driver(&self) -> Option<SwitchDriver> {
        let taken = self.now(|world, _| world.take_computer());
        taken.then(|| SwitchDriver::computer(Arc::clone(&self.0)))
    }

    /// How long the next wakeup and the next shutdown take: a manual one may
    /// take another time than a planned one.
    pub fn set_computer_times(&self, wakeup: Duration, shutdown: Duration) {
        self.now(|world, _| world.set_computer_times(wakeup, shutdown));
    }

    /// Starts a sequence in a place.
    pub fn start(&self, key: RunKey, spec: RunSpec) {
        self.now(|world, now| world.start(now, key, spec));
    }

    /// A sequence stands still, in its place.
    pub fn pause(&self, key: RunKey) {
        self.now(|world, now| world.pause(now, key));
    }

    /// A sequence that stood still goes on.
    pub fn resume(&self, key: RunKey) {
        self.now(|world, now| world.resume(now, key));
    }

    /// A sequence is told to end: it ends in its own time, with success.
    pub fn tell_to_end(&self, key: RunKey) {
        self.now(|world, now| world.tell_to_end(now, key));
    }

    /// A sequence that stands still will not go on. What it has added to the
    /// data on board.
    pub fn give_up(&self, key: RunKey) -> i64 {
        self.now(|world, now| world.give_up(now, key))
    }

    /// What a sequence has added to the data on board so far.
    #[must_use]
    pub fn data_of(&self, key: RunKey) -> i64 {
        self.now(|world, _| world.data_of(key))
    }

    /// What happened since the last call, in order.
    #[must_use]
    pub fn take_events(&self) -> Vec<(Instant, RoverEvent)> {
        self.now(|world, _| world.take_events())
    }

    /// When something happens next by itself.
    #[must_use]
    pub fn next_event(&self) -> Option<Instant> {
        self.now(|world, _| world.next_event())
    }

    /// What the battery's gauge said last; nothing before it said anything.
    #[must_use]
    pub fn charge(&self) -> Option<Measured<Microjoules>> {
        self.now(|world, _| world.gauged())
    }

    /// What a zone's thermometer said last, in thousandths of a degree.
    #[must_use]
    pub fn temperature(&self, zone: usize) -> Option<Measured<i64>> {
        self.now(|world, _| world.thermometer(zone))
    }

    /// An onboard variable's value; none: nobody knows it.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<i64> {
        self.now(|world, _| world.variable(name))
    }

    /// The communication windows, as the communication behaviour has them now.
    #[must_use]
    pub fn windows(&self) -> Vec<WindowModel> {
        self.now(|world, _| world.windows().to_vec())
    }

    /// Whether anything runs in a place: what a sensor at it says.
    #[must_use]
    pub fn place_is_on(&self, place: usize) -> bool {
        self.now(|world, _| world.place_is_on(place))
    }

    /// How things really stand.
    #[must_use]
    pub fn truth(&self) -> RoverTruth {
        self.now(|world, _| world.truth())
    }

    fn now<R>(&self, look: impl FnOnce(&mut World, Instant) -> R) -> R {
        let mut world = self.0.world.lock();
        let now = self.0.clock.now();
        world.advance_to(now);
        look(&mut world, now)
    }
}

impl fmt::Debug for Rover {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Rover").field(&self.truth()).finish()
    }
}
