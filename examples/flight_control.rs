//! Flight control: periodic threads at absolute times, and an emergency in
//! their midst.
//!
//! Attitude control at 100 Hz (a wheel, and thruster pulses to unload it), heater
//! control, a camera monitor and a fault response share the devices through
//! tickets. After a second the thruster valve sticks open. The fault response
//! asks for the cutoff valve and knows nothing of cameras and heaters; they
//! lose their tickets, are made safe and seen off, the valve is shut, and all
//! goes on as before. Nobody but the fault response has a line of code for it.
//!
//! Cycle slips are counted and shown: whether there are any is up to the host,
//! and what it permits of the real-time set-up is said. What Faregate itself
//! guarantees is checked; if it is seen broken, the exit code is 1.
//!
//! ```sh
//! cargo run --example flight_control            # or, with the flight recorder:
//! cargo run --example flight_control -- --log
//! ```

use std::collections::BTreeSet;
use std::process::ExitCode;
use std::thread::{self, Scope, ScopedJoinHandle};

use clap::Parser;
use comfy_table::{CellAlignment, Table, presets};
use faregate::prelude::*;
use faregate_devices_sim::{
    CameraCommand, CameraDriver, Command, CutoffCommand, CutoffDriver, DeviceId, Fault,
    FaultScript, HeatersCommand, HeatersDriver, SimClock, Spacecraft, ThrusterCommand,
    ThrusterDriver,
};

use support::rhythm::Rhythm;
use support::{Outcome, Sensors, claim, wait_for};

mod support;
