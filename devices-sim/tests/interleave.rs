//! The interleaver: what a seed decides, and what holds under every seed.

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use faregate_devices_sim::SimClock;
use faregate_devices_sim::interleave::{
    self, End, Interleaver, Over, Report, Schedule, SimLock, SimLocked, WakeFlag,
};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::id::Priority;
use faregate_tickets::lock::{Exclusion, Shut, Strategy};

const SECOND: Instant = Instant::from_micros(1_000_000);

fn at(us: u64) -> Instant {
    Instant::from_micros(us)
}

/// Two bodies that increment a number in two steps; the final number.
fn lost_update(seed: u64) -> u32 {
    let number = AtomicU32::new(0);
    let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
    for name in ["one", "two"] {
        threads.spawn(name, Priority::SCIENCE, || {
            let seen = number.load(Ordering::Relaxed);
            interleave::switch_point("between load and store");
            number.store(seen + 1, Ordering::Relaxed);
        });
    }
    threads.run(SECOND);
    number.load(Ordering::Relaxed)
}

#[test]
fn some_seeds_lose_an_update_and_some_do_not() {
    let numbers: HashSet<u32> = (0..50).map(lost_update).collect();
    assert_eq!(numbers, HashSet::from([1, 2]));
}

fn busy_run(seed: u64) -> (Report, Vec<(u64, &'static str)>) {
    let clock = SimClock::virtual_time();
    let lock = SimLock::new(());
    let order = Mutex::new(Vec::new());
    let mut threads = Interleaver::new(&clock, seed).log();
    for name in ["a", "b", "c"] {
        let (lock, order) = (&lock, &order);
        threads.spawn(name, Priority::SCIENCE, move || {
            for step in 0..5 {
                lock.with(|()| interleave::wait(Duration::from_micros(7)))
                    .expect("nobody died inside");
                order.lock().expect("nobody died inside").push((step, name));
                interleave::switch_point("step");
            }
        });
    }
    let report = threads.run(SECOND);
    (report, order.into_inner().expect("nobody died inside"))
}

#[test]
fn the_same_seed_gives_the_same_run_and_others_give_others() {
    for seed in 0..50 {
        assert_eq!(busy_run(seed), busy_run(seed));
    }
    let fingerprints: HashSet<u64> = (0..50).map(|seed| busy_run(seed).0.fingerprint).collect();
    assert!(fingerprints.len() > 45, "only {} different schedules", fingerprints.len());
}

#[test]
fn time_moves_only_when_everybody_waits_and_then_to_the_earliest_wake() {
    for seed in 0..100 {
        let clock = SimClock::virtual_time();
        let seen = Mutex::new(Vec::new());
        let mut threads = Interleaver::new(&clock, seed);
        for wake in [30, 10, 20] {
            let (seen, clock) = (&seen, &clock);
            threads.spawn("sleeper", Priority::SCIENCE, move || {
                for _ in 0..10 {
                    interleave::switch_point("work takes no time");
                    assert_eq!(clock.now(), Instant::START);
                }
                interleave::wait_until(at(wake));
                seen.lock().unwrap().push(clock.now());
            });
        }
        assert_eq!(threads.run(SECOND).over, Over::Finished);
        assert_eq!(seen.into_inner().unwrap(), [at(10), at(20), at(30)]);
    }
}

#[test]
fn one_body_at_a_time_is_inside_a_lock_even_when_it_sleeps_there() {
    for seed in 0..200 {
        let lock = <SimLocked as Strategy>::Lock::new(0_u32);
        let inside = AtomicU32::new(0);
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        for _ in 0..3 {
            threads.spawn("enters", Priority::SCIENCE, || {
                for _ in 0..4 {
                    lock.with(|count| {
                        assert_eq!(inside.fetch_add(1, Ordering::Relaxed), 0);
                        interleave::wait(Duration::from_micros(5));
                        interleave::switch_point("inside");
                        inside.fetch_sub(1, Ordering::Relaxed);
                        *count += 1;
                    })
                    .unwrap();
                }
            });
        }
        let report = threads.run(SECOND);
        assert_eq!((report.over, report.at), (Over::Finished, at(60)));
        assert_eq!(lock.with(|count| *count), Ok(12));
    }
}

#[test]
fn a_timed_lock_gives_up_at_its_virtual_deadline() {
    for seed in 0..100 {
        let lock = SimLock::new(());
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        threads.spawn("hangs", Priority::SCIENCE, || {
            let _ = lock.with(|()| interleave::wait_until(Instant::FAR_FUTURE));
        });
        threads.spawn("waits", Priority::SCIENCE, || {
            interleave::wait_until(at(10));
            assert_eq!(lock.try_with(|()| ()), Err(Shut::Busy));
            let outcome = lock.with_until(Duration::from_micros(90), |(), _| ());
            assert_eq!((outcome, interleave::now()), (Err(Shut::TimedOut), at(100)));
        });
        let report = threads.run(SECOND);
        assert_eq!(report.over, Over::Stalled);
        assert_eq!(report.end_of("waits"), Some(End::Finished));
        assert_eq!(report.end_of("hangs"), Some(End::Abandoned));
        assert_eq!(lock.try_with(|()| ()), Ok(()), "unwinding left the lock");
    }
}

#[test]
fn a_timed_lock_that_comes_free_in_time_is_entered() {
    for seed in 0..100 {
        let lock = SimLock::new(());
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        threads.spawn("leaves at 50", Priority::SCIENCE, || {
            lock.with(|()| interleave::wait_until(at(50))).unwrap();
        });
        threads.spawn("waits", Priority::SCIENCE, || {
            interleave::wait_until(at(10));
            let entered = lock.with_until(Duration::from_micros(90), |(), _| interleave::now());
            assert_eq!(entered, Ok(at(50)));
        });
        assert_eq!(threads.run(SECOND).over, Over::Finished);
    }
}

#[test]
fn a_lock_entered_again_by_its_own_body_refuses() {
    let lock = SimLock::new(());
    let mut threads = Interleaver::new(&SimClock::virtual_time(), 1);
    threads.spawn("enters twice", Priority::SCIENCE, || {
        let inner = lock.with(|()| lock.with(|()| ())).unwrap();
        assert_eq!(inner, Err(Shut::Reentered));
    });
    assert_eq!(threads.run(SECOND).over, Over::Finished);
    assert_eq!(lock.with(|()| lock.with(|()| ())), Ok(Err(Shut::Reentered)), "outside too");
}

#[test]
fn a_body_that_dies_inside_a_lock_leaves_it_and_drops_what_it_owns() {
    for seed in 0..100 {
        let lock = SimLock::new(());
        let dropped = AtomicBool::new(false);
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        threads.spawn("dies", Priority::SCIENCE, || {
            let _owned = OnDrop(|| dropped.store(true, Ordering::Relaxed));
            let _ = lock.with(|()| {
                interleave::wait(Duration::from_micros(5));
                interleave::die()
            });
        });
        threads.spawn("survives", Priority::SCIENCE, || lock.with(|()| ()).unwrap());
        let report = threads.run(SECOND);
        assert_eq!(report.over, Over::Finished);
        assert_eq!(report.end_of("dies"), Some(End::Died));
        assert_eq!(report.end_of("survives"), Some(End::Finished));
        assert!(dropped.load(Ordering::Relaxed));
    }
}

#[test]
fn a_dying_body_waits_for_a_lock_in_its_destructors_while_others_run() {
    for seed in 0..100 {
        let lock = SimLock::new(0);
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        threads.spawn("inside until 50", Priority::SCIENCE, || {
            lock.with(|count| {
                interleave::wait_until(at(50));
                *count = 1;
            })
            .unwrap();
        });
        threads.spawn("dies", Priority::SCIENCE, || {
            interleave::wait_until(at(10));
            let _gives_back = OnDrop(|| {
                lock.with(|count| assert_eq!(std::mem::replace(count, 2), 1)).unwrap();
            });
            interleave::die();
        });
        let report = threads.run(SECOND);
        assert_eq!((report.over, report.at), (Over::Finished, at(50)));
        assert_eq!(lock.with(|count| *count), Ok(2));
    }
}

#[test]
fn abandoned_bodies_exclude_each_other_to_the_end() {
    for seed in 0..200 {
        let lock = SimLock::new(0_u32);
        let dropped = AtomicU32::new(0);
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        for _ in 0..3 {
            threads.spawn("never ends", Priority::SCIENCE, || {
                let _gives_back = OnDrop(|| {
                    lock.with(|inside| {
                        assert_eq!(*inside, 0, "somebody is inside");
                        dropped.fetch_add(1, Ordering::Relaxed);
                    })
                    .unwrap();
                });
                loop {
                    let _ = lock.with(|inside| {
                        *inside += 1;
                        let _leaves = OnDrop(|| *inside -= 1);
                        interleave::wait(Duration::from_micros(3));
                    });
                    interleave::wait(Duration::from_micros(1));
                }
            });
        }
        let report = threads.run(at(100));
        assert_eq!((report.over, report.at), (Over::Horizon, at(100)));
        assert!(report.ends.iter().all(|(_, end)| *end == End::Abandoned), "{report:?}");
        assert_eq!(dropped.load(Ordering::Relaxed), 3);
    }
}

#[test]
fn a_body_that_dies_when_the_run_ends_is_not_thrown_at_twice() {
    for seed in 0..100 {
        let lock = SimLock::new(());
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        threads.spawn("holds on", Priority::SCIENCE, || {
            let _ = lock.with(|()| interleave::wait_until(at(500)));
        });
        threads.spawn("dies", Priority::SCIENCE, || {
            interleave::wait_until(at(10));
            let _gives_back = OnDrop(|| lock.with(|()| ()).unwrap());
            interleave::die();
        });
        let report = threads.run(at(100));
        assert_eq!(report.over, Over::Horizon);
        assert_eq!(report.end_of("holds on"), Some(End::Abandoned));
        assert_eq!(report.end_of("dies"), Some(End::Died));
    }
}

#[test]
fn an_abandoned_body_that_contains_its_unwinding_still_ends() {
    let mut threads = Interleaver::new(&SimClock::virtual_time(), 3);
    threads.spawn("contains", Priority::SCIENCE, || {
        loop {
            let _ = catch_unwind(|| interleave::wait(Duration::from_micros(10)));
            interleave::wait(Duration::from_micros(10));
        }
    });
    assert_eq!(threads.run(at(100)).end_of("contains"), Some(End::Abandoned));
}

#[test]
fn a_body_that_never_began_is_dropped_unrun() {
    let runs = AtomicBool::new(false);
    let dropped = AtomicBool::new(false);
    let owned = OnDrop(|| dropped.store(true, Ordering::Relaxed));
    let mut threads = Interleaver::new(&SimClock::virtual_time(), 0).schedule(Schedule::Priorities);
    threads.spawn("stops", Priority::EMERGENCY, interleave::stop);
    threads.spawn("never begins", Priority::LEAST, || {
        let _owned = owned;
        runs.store(true, Ordering::Relaxed);
    });
    assert_eq!(threads.run(SECOND).over, Over::Stopped);
    assert!(dropped.load(Ordering::Relaxed) && !runs.load(Ordering::Relaxed));
}

#[test]
fn two_abandoned_bodies_in_a_deadly_embrace_are_leaked_and_reported() {
    let (first, second) = (SimLock::new(()), SimLock::new(()));
    let mut threads = Interleaver::new(&SimClock::virtual_time(), 0);
    for (name, mine, yours) in [("one", &first, &second), ("two", &second, &first)] {
        threads.spawn(name, Priority::SCIENCE, move || {
            let _ = mine.with(|()| {
                let _needs_both = OnDrop(|| yours.with(|()| ()).unwrap());
                interleave::wait_until(Instant::FAR_FUTURE);
            });
        });
    }
    let report = threads.run(SECOND);
    assert_eq!(report.over, Over::Stalled);
    assert_eq!(report.ends.iter().filter(|(_, end)| *end == End::Leaked).count(), 2);
}

#[test]
fn a_panic_in_a_body_is_the_callers_after_the_others_were_unwound() {
    let dropped = AtomicBool::new(false);
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let mut threads = Interleaver::new(&SimClock::virtual_time(), 0);
        threads.spawn("waits", Priority::SCIENCE, || {
            let _owned = OnDrop(|| dropped.store(true, Ordering::Relaxed));
            interleave::wait_until(at(20));
        });
        threads.spawn("fails", Priority::SCIENCE, || {
            interleave::wait_until(at(10));
            std::panic::resume_unwind(Box::new("an assertion failed"));
        });
        threads.run(SECOND);
    }));
    assert_eq!(*outcome.unwrap_err().downcast::<&str>().unwrap(), "an assertion failed");
    assert!(dropped.load(Ordering::Relaxed));
    assert!(!interleave::is_running());
}

/// A middle hog never lets go of the processor; yet the most important body
/// gets a lock that the least important one holds.
#[test]
fn whoever_holds_a_lock_inherits_the_priority_of_who_waits_for_it() {
    let lock = SimLock::new(());
    let high_got_it = AtomicBool::new(false);
    let mut threads = Interleaver::new(&SimClock::virtual_time(), 0).schedule(Schedule::Priorities);
    threads.spawn("low", Priority::LEAST, || {
        lock.with(|()| {
            interleave::wait_until(at(10));
            for _ in 0..5 {
                interleave::switch_point("a long command");
            }
        })
        .unwrap();
    });
    threads.spawn("middle", Priority::SCIENCE, || {
        interleave::wait_until(at(10));
        while !high_got_it.load(Ordering::Relaxed) {
            interleave::switch_point("hogs");
        }
    });
    threads.spawn("high", Priority::EMERGENCY, || {
        interleave::wait_until(at(10));
        lock.with(|()| high_got_it.store(true, Ordering::Relaxed)).unwrap();
    });
    assert_eq!(threads.run(SECOND).over, Over::Finished);
}

#[test]
fn under_priorities_a_spinning_body_keeps_out_a_less_important_one() {
    let over = AtomicBool::new(false);
    let mut threads = Interleaver::new(&SimClock::virtual_time(), 0).schedule(Schedule::Priorities);
    threads.spawn("spins", Priority::EMERGENCY, || {
        while !over.load(Ordering::Relaxed) {
            interleave::switch_point("spins");
        }
    });
    threads.spawn("would end it", Priority::LEAST, || over.store(true, Ordering::Relaxed));
    assert_eq!(threads.run(SECOND).over, Over::Livelocked);
}

#[test]
fn a_ranked_schedule_lets_a_polling_body_see_what_it_polls_for() {
    for seed in 0..50 {
        let flag = AtomicBool::new(false);
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed)
            .schedule(Schedule::Ranked { demote: 0 });
        threads.spawn("polls", Priority::SCIENCE, || {
            while !flag.load(Ordering::Relaxed) {
                interleave::switch_point("polls");
            }
        });
        threads.spawn("raises", Priority::SCIENCE, || flag.store(true, Ordering::Relaxed));
        assert_eq!(threads.run(SECOND).over, Over::Finished);
    }
}

#[test]
fn a_wake_is_never_lost() {
    for seed in 0..200 {
        let (ping, pong) = (WakeFlag::new(), WakeFlag::new());
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        for (mine, yours) in [(ping.clone(), pong.clone()), (pong.clone(), ping.clone())] {
            threads.spawn("plays", Priority::SCIENCE, move || {
                for _ in 0..10 {
                    assert!(mine.wait_until(SECOND));
                    yours.wake();
                }
            });
        }
        ping.wake();
        let report = threads.run(SECOND);
        assert_eq!((report.over, report.at), (Over::Finished, Instant::START));
    }
}

#[test]
fn waiting_for_a_flag_that_stays_down_ends_at_the_deadline() {
    let flag = WakeFlag::new();
    let mut threads = Interleaver::new(&SimClock::virtual_time(), 0);
    threads.spawn("waits", Priority::SCIENCE, || {
        assert!(!flag.wait_until(at(40)));
        assert_eq!(interleave::now(), at(40));
    });
    assert_eq!(threads.run(SECOND).over, Over::Finished);
}

/// The conditions take locks, which are switch points: looking again must not
/// count as progress, or the two would look for ever and time would stand.
#[test]
fn two_bodies_that_look_at_each_other_let_time_pass() {
    for seed in 0..100 {
        let step = SimLock::new(0);
        let is = |wanted| step.with(|step| *step == wanted).unwrap();
        let mut threads = Interleaver::new(&SimClock::virtual_time(), seed);
        for wanted in [1, 2] {
            let (step, is) = (&step, &is);
            threads.spawn("looks", Priority::SCIENCE, move || {
                interleave::block_on(|| is(wanted));
                step.with(|step| *step += 1).unwrap();
            });
        }
        threads.spawn("begins", Priority::SCIENCE, || {
            interleave::wait_until(at(30));
            step.with(|step| *step = 1).unwrap();
        });
        let report = threads.run(SECOND);
        assert_eq!((report.over, report.at), (Over::Finished, at(30)), "seed {seed}");
    }
}

#[test]
fn a_condition_that_never_holds_ends_at_its_deadline_or_stalls() {
    let mut threads = Interleaver::new(&SimClock::virtual_time(), 0);
    threads.spawn("to a deadline", Priority::SCIENCE, || {
        assert!(!interleave::block_on_until(at(40), || false));
        assert_eq!(interleave::now(), at(40));
    });
    threads.spawn("for ever", Priority::SCIENCE, || interleave::block_on(|| false));
    let report = threads.run(SECOND);
    assert_eq!((report.over, report.at), (Over::Stalled, at(40)));
    assert_eq!(report.end_of("for ever"), Some(End::Abandoned));
}

#[test]
fn outside_an_interleaver_a_lock_is_an_ordinary_one() {
    let (lock, clock) = (SimLock::new(0_u32), SimClock::real_time());
    let (is_inside, inside) = std::sync::mpsc::channel();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            lock.with(|count| {
                is_inside.send(()).unwrap();
                clock.wait_until(clock.now().after(Duration::from_millis(30)));
                *count += 1;
            })
        });
        inside.recv().unwrap();
        assert_eq!(lock.try_with(|_| ()), Err(Shut::Busy));
        assert_eq!(lock.with_until(Duration::from_millis(1), |_, _| ()), Err(Shut::TimedOut));
        assert_eq!(lock.with(|count| *count), Ok(1));
    });
}

struct OnDrop<F: FnMut()>(F);

impl<F: FnMut()> Drop for OnDrop<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}
