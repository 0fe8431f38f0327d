//! What both kinds of wake-up promise.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::thread;

use faregate_tickets::clock::{Clock, Duration, Instant};

use super::Woken;
use crate::clock::MonotonicClock;

/// Later than any of these tests takes: a lost wake-up shows as a deadline.
fn far() -> Option<Instant> {
    in_micros(20_000_000)
}

fn in_micros(us: u64) -> Option<Instant> {
    Some(MonotonicClock::new().now().after(Duration::from_micros(us)))
}

macro_rules! claims {
    ($kind:ident) => {
        mod $kind {
            use super::super::$kind::Wakeup;
            use super::*;

            #[test]
            fn a_notification_before_the_wait_is_not_lost() {
                let bell = Wakeup::new().unwrap();
                bell.notify();
                assert_eq!(bell.wait_until(far()).unwrap(), Woken::Notified);
            }

            #[test]
            fn a_notification_wins_over_a_deadline_that_has_passed() {
                let bell = Wakeup::new().unwrap();
                bell.notify();
                assert_eq!(bell.wait_until(Some(Instant::START)).unwrap(), Woken::Notified);
            }

            #[test]
            fn notifications_that_nobody_took_are_one() {
                let bell = Wakeup::new().unwrap();
                bell.notify();
                bell.notify();
                assert_eq!(bell.wait_until(far()).unwrap(), Woken::Notified);
                assert_eq!(bell.wait_until(in_micros(1_000)).unwrap(), Woken::Deadline);
            }

            #[test]
            fn a_wait_never_ends_before_its_deadline() {
                let bell = Wakeup::new().unwrap();
                for us in [0, 1, 999, 1_000, 2_345] {
                    let deadline = in_micros(us);
                    assert_eq!(bell.wait_until(deadline).unwrap(), Woken::Deadline);
                    assert!(Some(MonotonicClock::new().now()) >= deadline);
                }
            }

            #[test]
            fn a_wait_without_deadline_ends_with_a_notification() {
                let bell = Wakeup::new().unwrap();
                thread::scope(|scope| {
                    let waiter = scope.spawn(|| bell.wait_until(None).unwrap());
                    bell.notify();
                    assert_eq!(waiter.join().unwrap(), Woken::Notified);
                });
            }

            #[test]
            fn the_farthest_deadline_is_not_a_past_one() {
                let bell = Wakeup::new().unwrap();
                thread::scope(|scope| {
                    let waiter =
                        scope.spawn(|| bell.wait_until(Some(Instant::FAR_FUTURE)).unwrap());
                    bell.notify();
                    assert_eq!(waiter.join().unwrap(), Woken::Notified);
                });
            }

            /// Two threads hand a number to and fro; one lost wake-up and one
            /// of them sees its deadline.
            #[test]
            fn no_wake_up_is_lost_between_looking_and_sleeping() {
                const ROUNDS: u32 = 10_000;
                let (ping, pong) = (Wakeup::new().unwrap(), Wakeup::new().unwrap());
                let ball = AtomicU32::new(0);
                thread::scope(|scope| {
                    scope.spawn(|| {
                        for round in 0..ROUNDS {
                            assert_eq!(ping.wait_until(far()).unwrap(), Woken::Notified);
                            // Relaxed: the wake-up itself makes it visible.
                            assert_eq!(ball.load(Relaxed), 2 * round + 1);
                            ball.store(2 * round + 2, Relaxed);
                            pong.notify();
                        }
                    });
                    for round in 0..ROUNDS {
                        ball.store(2 * round + 1, Relaxed);
                        ping.notify();
                        assert_eq!(pong.wait_until(far()).unwrap(), Woken::Notified);
                        assert_eq!(ball.load(Relaxed), 2 * round + 2);
                    }
                });
            }

            #[test]
            fn where_two_wait_one_takes_the_notification_and_one_waits_on() {
                let bell = Wakeup::new().unwrap();
                for _ in 0..20 {
                    let deadline = in_micros(5_000);
                    let wait = || {
                        let woken = bell.wait_until(deadline).unwrap();
                        let early = Some(MonotonicClock::new().now()) < deadline;
                        assert!(woken == Woken::Notified || !early, "woken for nothing");
                        woken
                    };
                    let woken = thread::scope(|scope| {
                        let waiters = [(); 2].map(|()| scope.spawn(wait));
                        let _ = Wakeup::new().unwrap().wait_until(in_micros(1_000));
                        bell.notify();
                        waiters.map(|waiter| waiter.join().unwrap())
                    });
                    let took = woken.iter().filter(|woken| **woken == Woken::Notified);
                    assert_eq!(took.count(), 1, "{woken:?}");
                }
            }
        }
    };
}

claims!(condvar);
#[cfg(target_os = "linux")]
claims!(eventfd);
