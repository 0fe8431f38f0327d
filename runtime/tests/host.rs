//! The host's ports, taken together.

use std::thread;

use faregate_runtime::host::Host;
use faregate_tickets::Platform;
use faregate_tickets::lock::{Exclusion, Shut, Strategy};

type Lock<T> = <<Host as Platform>::Strategy as Strategy>::Lock<T>;

#[test]
fn the_hosts_lock_tells_its_own_thread_from_another() {
    let lock = Lock::new(0);
    let inside = lock.with(|_| {
        let same = lock.with(|_| ());
        let other = thread::scope(|scope| scope.spawn(|| lock.try_with(|_| ())).join().unwrap());
        (same, other)
    });
    assert_eq!(inside, Ok((Err(Shut::Reentered), Err(Shut::Busy))));
}

#[test]
fn the_hosts_lock_lets_one_thread_in_at_a_time() {
    const ROUNDS: u32 = 20_000;
    let lock = Lock::new(0_u32);
    thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| (0..ROUNDS).for_each(|_| lock.with(|count| *count += 1).unwrap()));
        }
    });
    assert_eq!(lock.with(|count| *count), Ok(3 * ROUNDS));
}
