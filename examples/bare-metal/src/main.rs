//! The emergency on a Cortex-M4 without an operating system.
//!
//! Everything stands in statics, nothing is allocated, and interrupts are the
//! threads. A monitor in SysTick keeps the camera on. The thruster sticks open,
//! and a more urgent interrupt asks for the cutoff valve, for which the bus has
//! no margin. The camera's ticket is revoked, its device made safe and seen
//! off; the valve is shut; the monitor's next command succeeds again. Each step
//! is looked for in the flight recorder. Then the instructions of the operations
//! are counted.
//!
//! ```sh
//! cd examples/bare-metal && cargo run --release   # with qemu-system-arm
//! ci/bare-metal.sh                                # with whatever is here
//! ```
//!
//! Ends with exit code 0; 1 and the claim that did not hold; or 2 and the law by
//! which the spacecraft was lost.
#![no_std]
#![no_main]

mod clock;
mod counts;
mod craft;
mod flight;
mod plant;
mod sizes;
mod sys;
mod tape;
mod threads;

use cortex_m::Peripherals;
use cortex_m_rt::entry;
use faregate_agents::RegisterError;
use faregate_tickets::clock::Duration;
use semihosting::{eprintln, process};

use craft::Craft;
use flight::Flight;
use plant::Loss;

/// The period of the sensors; the monitor's is not a multiple of it, so that
/// the one interrupts the other in different places.
const SENSORS: Duration = Duration::from_micros(20_000);
const MONITOR: Duration = Duration::from_micros(51_300);

/// Why the program does not end well.
#[derive(Clone, Copy, Debug)]
enum Failure {
    /// This does not hold.
    Claim(&'static str),
    /// The spacecraft was lost.
    Lost(Loss),
}

impl From<RegisterError> for Failure {
    fn from(_: RegisterError) -> Self {
        Self::Claim("there is room for all agents and gates")
    }
}

/// What must hold.
fn claim(holds: bool, claim: &'static str) -> Result<(), Failure> {
    if holds { Ok(()) } else { Err(Failure::Claim(claim)) }
}

#[entry]
fn main() -> ! {
    match run() {
        Ok(()) => process::exit(0),
        Err(Failure::Claim(claim)) => give_up(claim),
        Err(Failure::Lost(loss)) => {
            eprintln!("LOST by {loss}");
            process::exit(2)
        }
    }
}

fn run() -> Result<(), Failure> {
    sys::start_clocks();
    let craft = Craft::assemble()?;
    threads::start(craft);
    let board = Peripherals::take().ok_or(Failure::Claim("the board is there, once"))?;
    sys::start_interrupts(board, SENSORS, MONITOR);
    for flight in Flight::ALL {
        flight.fly(craft)?;
    }
    cortex_m::interrupt::disable();
    threads::stop();
    counts::print(craft)?;
    sizes::print()
}

/// Ends with what went wrong.
fn give_up(what: &str) -> ! {
    eprintln!("FAILED: this should be so, and is not: {what}");
    process::exit(1)
}

#[panic_handler]
fn panicked(panic: &core::panic::PanicInfo<'_>) -> ! {
    eprintln!("{panic}");
    process::exit(101)
}
