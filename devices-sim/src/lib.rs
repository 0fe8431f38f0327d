//! A simulated spacecraft, and threads that command it in virtual time.
//!
//! [`Spacecraft`] is a plant of devices with exact physics: a power bus that
//! trips, a camera, a thruster that can stick open, the valve that cuts it off,
//! heaters, and sensors that lag. What goes wrong is a [`FaultScript`]. Its
//! drivers implement the device port of `faregate-tickets`, so they go into
//! gates like real ones; bare switches to the same hardware serve designs
//! without gates.
//!
//! [`interleave`] runs threads of control deterministically: a seed decides who
//! runs when, and time is virtual. The same spacecraft also runs in real time,
//! under real threads: that is up to its [`SimClock`].
//!
//! To command is not to know:
//!
//! ```
//! use faregate_devices_sim::{CameraCommand, DeviceId, FaultScript, Parameters, SimClock, Spacecraft};
//! use faregate_tickets::Device;
//! use faregate_tickets::clock::{Clock, Duration};
//! use faregate_tickets::device::Power;
//!
//! let clock = SimClock::virtual_time();
//! let parameters = Parameters { sensor_unknown_permille: 0, ..Parameters::default() };
//! let spacecraft = Spacecraft::new(parameters, FaultScript::new(), 7, &clock);
//! let mut camera = spacecraft.camera_driver().expect("nobody took it before");
//! assert!(spacecraft.camera_driver().is_none(), "there is one driver");
//!
//! let state = || spacecraft.estimate(DeviceId::Camera).map(|estimate| estimate.state);
//! clock.advance_to(clock.now().after(Duration::from_millis(100)));
//! camera.issue(CameraCommand::On)?;
//! assert!(spacecraft.truth().camera_on);
//! assert_eq!(state(), Some(Power::Off), "the measurement is older than the command");
//! clock.advance_to(clock.now().after(Duration::from_millis(25)));
//! assert_eq!(state(), Some(Power::On));
//! # Ok::<(), faregate_devices_sim::DriverFault>(())
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`interleave`] | threads as coroutines, a seeded schedule, locks and wake flags in virtual time |
//! | [`parameters`] | the numbers, with their reasons |
//! | [`payload`] | a bus, a battery, and whatever units a mission has |
//! | [`rover`] | a generator, zones, sequences and a computer that sleeps, over days |

#![forbid(unsafe_code)]

pub mod interleave;
pub mod parameters;
pub mod payload;
pub mod rover;

mod battery;
mod camera;
mod clock;
mod cutoff;
mod device;
mod drivers;
mod faults;
mod heaters;
mod law;
mod plant;
mod power;
mod propulsion;
mod random;
mod sensors;
mod spacecraft;
mod thruster;
mod trace;

pub use camera::{Camera, CameraCommand};
pub use clock::SimClock;
pub use cutoff::{Cutoff, CutoffCommand};
pub use device::{Command, DeviceId, Kind};
pub use drivers::{
    Bare, BareCamera, BareCutoff, BareHeaters, BareThruster, CameraDriver, CutoffDriver, Driver,
    DriverFault, HeatersDriver, ThrusterDriver,
};
pub use faults::{Failing, Fault, FaultScript};
pub use heaters::{Heaters, HeatersCommand};
pub use law::Law;
pub use parameters::Parameters;
pub use plant::Truth;
pub use random::Dice;
pub use sensors::Measured;
pub use spacecraft::Spacecraft;
pub use thruster::{Thruster, ThrusterCommand};
pub use trace::{Outcome, ReceivedCommand};
