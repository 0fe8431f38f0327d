//! What the examples on the simulated spacecraft share.

use std::error::Error;
use std::io;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use faregate::prelude::*;
use faregate_devices_sim::{DeviceId, Parameters, SimClock, Spacecraft};

/// Why an example did not come to its end.
pub(crate) type Failure = Box<dyn Error + Send + Sync>;

/// What an example comes to.
pub(crate) type Outcome<T> = Result<T, Failure>;

/// Tells the shell how it went: 1 and the reason, where a claim did not hold.
pub(crate) fn exit(outcome: Outcome<()>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("\nFAILED: {reason}");
            ExitCode::FAILURE
        }
    }
}

/// Makes sure of a claim that the example makes.
pub(crate) fn claim(holds: bool, claim: &str) -> Outcome<()> {
    if holds { Ok(()) } else { Err(format!("this should be so, and is not: {claim}").into()) }
}

/// The spacecraft's numbers for an ordinary host. It may keep a thread from
/// running for many times the millisecond that a command takes, which on a
/// flight computer would be the driver's fault.
pub(crate) fn parameters() -> Parameters {
    Parameters { overrun_factor: 250, ..Parameters::default() }
}

/// Looks every millisecond until `done` agrees; answers whether it did in time.
pub(crate) fn wait_for(
    clock: &SimClock,
    timeout: Duration,
    mut done: impl FnMut() -> bool,
) -> bool {
    let deadline = clock.now().after(timeout);
    loop {
        if done() {
            return true;
        }
        if clock.now() >= deadline {
            return false;
        }
        clock.wait_until(clock.now().after(Duration::from_millis(1)));
    }
}

/// Brings the spacecraft's estimates to the broker, from a thread of its own,
/// until it is dropped.
pub(crate) struct Sensors {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Sensors {
    pub(crate) fn start<const N: usize>(
        broker: &Broker,
        spacecraft: &Spacecraft,
        gates: [(GateId, DeviceId); N],
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, broker, spacecraft) = (Arc::clone(&stop), broker.clone(), spacecraft.clone());
        let offset = offset(&broker, &spacecraft);
        let thread = std::thread::Builder::new().name("sensors".into()).spawn(move || {
            // Relaxed: it says nothing about other memory.
            while !stopped.load(Ordering::Relaxed) {
                for (gate, device) in gates {
                    if let Some(Estimate { state, measured_at }) = spacecraft.estimate(device) {
                        let measured_at = measured_at.after(offset);
                        broker.observe(gate, Estimate { state, measured_at });
                    }
                }
                let clock = spacecraft.clock();
                clock.wait_until(clock.now().after(Duration::from_millis(2)));
            }
        })?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for Sensors {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // If it panicked, that has been printed.
            let _ = thread.join();
        }
    }
}

/// What the broker's clock shows more than the spacecraft's, by which its
/// sensors date their measurements.
///
/// Read in this order, and less one unit for the rounding, it is never too
/// much: a measurement may look a few microseconds too old, which costs a
/// little time, and never too young, which could cost the spacecraft.
fn offset(broker: &Broker, spacecraft: &Spacecraft) -> Duration {
    let ours = broker.clock().now();
    let theirs = spacecraft.clock().now().after(Duration::from_micros(1));
    ours.since(theirs)
}
