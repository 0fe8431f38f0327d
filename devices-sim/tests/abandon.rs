//! What abandoned runs leave behind. Alone in its process: it counts panics and
//! memory mappings.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use faregate_devices_sim::SimClock;
use faregate_devices_sim::interleave::{self, End, Interleaver};
use faregate_tickets::clock::Instant;
use faregate_tickets::id::Priority;

fn abandoned_run(seed: u64) {
    let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
    threads.spawn("hangs", Priority::SCIENCE, || interleave::wait_until(Instant::FAR_FUTURE));
    threads.spawn("dies", Priority::SCIENCE, || interleave::die());
    let report = threads.run(Instant::from_micros(100));
    assert_eq!(report.end_of("hangs"), Some(End::Abandoned));
    assert_eq!(report.end_of("dies"), Some(End::Died));
}

#[cfg(target_os = "linux")]
fn mappings() -> usize {
    std::fs::read_to_string("/proc/self/maps").expect("Linux shows them").lines().count()
}

#[test]
fn abandoned_and_dead_bodies_say_nothing_and_leave_no_stack_behind() {
    let panics = Arc::new(AtomicU32::new(0));
    let counted = Arc::clone(&panics);
    std::panic::set_hook(Box::new(move |_| {
        counted.fetch_add(1, Ordering::Relaxed);
    }));
    abandoned_run(0);
    #[cfg(target_os = "linux")]
    let before = mappings();
    (1..1_000).for_each(abandoned_run);
    #[cfg(target_os = "linux")]
    assert!(mappings() < before + 20, "{} mappings, {before} before", mappings());
    assert_eq!(panics.load(Ordering::Relaxed), 0, "the panic hook ran");
}
