//! Flight control: periodic threads at absolute times, and an emergency in
//! their midst.
//!
//! Attitude control at 100 Hz (a wheel, and thruster pulses to unload it),
//! heater control, a camera monitor and a fault response share the devices
//! through tickets. Little after a second the thruster valve sticks open. The fault
//! response asks for the cutoff valve, and knows nothing of cameras and heaters:
//! they lose their tickets, are made safe and seen off, the valve is shut, and
//! all goes on as before. No other thread has a line of code for it.
//!
//! Cycle slips are counted and shown: whether there are any is up to the host,
//! and it is said which real-time rights the host gives. What Faregate itself
//! guarantees is checked; if it is seen broken, the exit code is 1.
//!
//! ```sh
//! cargo run --example flight_control            # or, with the flight recorder:
//! cargo run --example flight_control -- --log
//! ```

mod checks;
mod craft;
mod rhythm;
#[path = "../support/mod.rs"]
mod support;
mod tally;
mod threads;

use std::io::{self, IsTerminal};
use std::process::ExitCode;
use std::thread::{self, Scope, ScopedJoinHandle};

use clap::Parser;
use faregate::prelude::*;
use tracing_subscriber::filter::LevelFilter;

use craft::Craft;
use support::Outcome;
use tally::Tally;

/// How long the flight lasts.
const FLIGHT: Duration = Duration::from_secs(3);

/// Flies a spacecraft on periodic threads, through a stuck thruster.
#[derive(Parser)]
#[command(after_help = "Exit code: 0 if every guarantee held; 1 if one was seen broken.")]
struct Options {
    /// Show the notable events of the flight recorder as they happen.
    #[arg(long)]
    log: bool,
}

fn main() -> ExitCode {
    if Options::parse().log {
        // Records have their own times: when it happened, not when it was told.
        let shown = tracing_subscriber::fmt().with_max_level(LevelFilter::INFO).without_time();
        shown.with_ansi(io::stderr().is_terminal()).with_writer(io::stderr).init();
    }
    support::exit(fly())
}

fn fly() -> Outcome<()> {
    let craft = Craft::new()?;
    println!("Flying for {FLIGHT}; the thruster valve sticks open at {}.\n", craft::STICKS_AT);
    let until = craft.spacecraft.clock().now().after(FLIGHT);
    let flown = thread::scope(|scope| {
        let craft = &craft;
        let attitude = spawn(scope, "attitude", move || threads::attitude_control(craft, until))?;
        let heaters = spawn(scope, "heaters", move || threads::heater_control(craft, until))?;
        let camera = spawn(scope, "camera", move || threads::camera_monitor(craft, until))?;
        let fault = spawn(scope, "fault", move || threads::fault_response(craft, until))?;
        let (fault, rescue) = ended(fault)?;
        Ok::<_, support::Failure>((
            [ended(attitude)?, ended(heaters)?, ended(camera)?, fault],
            rescue,
        ))
    });
    checks::margin_kept(&craft)?;
    let (tallies, rescue) = flown?;

    println!("{}", tally::table(&tallies.each_ref()));
    print_real_time(&craft.broker, &tallies);
    let rescue = rescue.ok_or("the fault response did not notice the stuck valve")?;
    checks::tell(&craft, &rescue, &tallies[2]);
    checks::check(&craft, &rescue, &tallies)
}

fn spawn<'scope, R: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    name: &str,
    body: impl FnOnce() -> R + Send + 'scope,
) -> io::Result<ScopedJoinHandle<'scope, R>> {
    thread::Builder::new().name(name.into()).spawn_scoped(scope, body)
}

fn ended<R>(thread: ScopedJoinHandle<'_, Outcome<R>>) -> Outcome<R> {
    thread.join().map_err(|_| "a thread panicked")?
}

/// What the host permits, and once what it refuses and what to do about it.
fn print_real_time(broker: &Broker, tallies: &[Tally]) {
    let refused = tallies.iter().find_map(|tally| tally.fifo.as_ref().err());
    println!("service thread: {}", broker.real_time_report().unwrap_or("not asked for"));
    match refused {
        None => println!("other threads: all have the priorities that they asked for"),
        Some(refused) => println!("other threads, for example: {refused}"),
    }
}
