//! Shows what a simulated campaign costs: switch points, switches and whole
//! runs per second. Run it with `--release`.

use std::time::Instant as RealInstant;

use faregate_devices_sim::SimClock;
use faregate_devices_sim::interleave::{self, Interleaver, SimLock};
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::id::Priority;
use faregate_tickets::lock::Exclusion;

const RUNS: u64 = 5_000;

fn main() {
    let (mut choices, mut resumes) = (0, 0);
    let start = RealInstant::now();
    for seed in 0..RUNS {
        let lock = SimLock::new(0_u64);
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        for name in ["monitor", "emergency", "service", "thruster"] {
            threads.spawn(name, Priority::SCIENCE, || {
                for _ in 0..25 {
                    let _ = lock.with(|count| {
                        *count += 1;
                        interleave::switch_point("inside");
                    });
                    interleave::wait(Duration::from_micros(50));
                }
            });
        }
        let report = threads.run(Instant::from_micros(1_000_000));
        choices += report.choices;
        resumes += report.resumes;
    }
    let seconds = start.elapsed().as_secs_f64();
    let per_second = |count: u64| count as f64 / seconds;
    println!("{RUNS} runs of 4 bodies in {seconds:.2} s");
    println!("{:.0} runs/s", per_second(RUNS));
    println!("{:.0} choices/s ({} a run)", per_second(choices), choices / RUNS);
    println!("{:.0} switches/s ({} a run)", per_second(resumes), resumes / RUNS);
}
