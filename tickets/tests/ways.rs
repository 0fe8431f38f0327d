//! What the tenant's own way keeps, beside what every lock keeps.
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

use std::hint::black_box;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use faregate_tickets::Gate;
use faregate_tickets::clock::{self, Clock, Duration};
use faregate_tickets::device::{Declaration, Device, Effect, Profile};
use faregate_tickets::fault::GateFault;
use faregate_tickets::gate::{Admission, Blocked};
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::lock::{
    Exclusion, Fenced, Locked, Next, Outcome, Owner, Restartable, Sections, Shut, Strategy, Wait,
    Watch, Way,
};
use faregate_tickets::recorder::{NoLane, Unrecorded};
use faregate_tickets::refusal::{InvokeError, Refusal};
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::{Stamp, Standing};
use faregate_tickets::ticket::{Holder, Issuer, Seat};
use faregate_tickets::validity::Validity;

/// Yields, for as long as it takes or until a deadline.
enum Yielding {}

impl Wait for Yielding {
    fn until(timeout: Duration, mut over: impl FnMut() -> bool) -> bool {
        let start = Instant::now();
        while !over() {
            if Duration::from(start.elapsed()) >= timeout {
                return false;
            }
            thread::yield_now();
        }
        true
    }
}

type Inner = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;
type Lock = <Fenced<Inner, Yielding> as Strategy>::Lock<u64>;
type TicketsWay<'l> = <Lock as Exclusion<u64>>::Way<'l>;

/// Longer than anything here takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

fn way(lock: &Lock) -> TicketsWay<'_> {
    let (standing, scope) =
        (Box::leak(Box::new(Standing::new())), Box::leak(Box::new(Scope::new())));
    let id = TicketId { seat: 0, serial: 1 };
    lock.way(&Seat { id, gate: GateId(0), standing, agent: scope, broker: scope }, PATIENCE)
}

/// Which way a command came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Came {
    Short,
    ByTheLock,
}

/// Inside, the lock itself tells: on the short way it is free, and says only
/// that somebody is in.
fn command(lock: &Lock, way: &TicketsWay<'_>) -> Came {
    let tried = way.with(
        || Ok::<(), ()>(()),
        |value: &mut u64, ()| {
            *value += 1;
            (lock.try_with(|_| ()), Next::Enter)
        },
    );
    match tried.unwrap().unwrap() {
        Err(Shut::Busy) => Came::Short,
        Err(Shut::Reentered) => Came::ByTheLock,
        other => panic!("entered while somebody was inside: {other:?}"),
    }
}

#[test]
fn the_first_command_opens_the_short_way_and_whoever_enters_closes_it() {
    let lock = Lock::new(0);
    let way = way(&lock);
    assert_eq!([(); 3].map(|()| command(&lock, &way)), [Came::ByTheLock, Came::Short, Came::Short]);
    assert_eq!(lock.with(|value| *value), Ok(3));
    assert_eq!([(); 2].map(|()| command(&lock, &way)), [Came::ByTheLock, Came::Short]);
    assert_eq!(lock.with_until(PATIENCE, |value, owner| (*value, owner)), Ok((5, Owner::Sound)));
    assert_eq!([(); 2].map(|()| command(&lock, &way)), [Came::ByTheLock, Came::Short]);
}

#[test]
fn one_short_way_is_open_at_a_time() {
    let lock = Lock::new(0);
    let [one, other] = [way(&lock), way(&lock)];
    for _ in 0..3 {
        assert_eq!([(); 2].map(|()| command(&lock, &one)), [Came::ByTheLock, Came::Short]);
        assert_eq!([(); 2].map(|()| command(&lock, &other)), [Came::ByTheLock, Came::Short]);
    }
}

#[test]
fn a_refused_command_opens_nothing() {
    let lock = Lock::new(0);
    let [valid, refused] = [way(&lock), way(&lock)];
    command(&lock, &valid);
    assert_eq!(
        refused.with(|| Err::<(), _>("no"), |_: &mut u64, ()| ((), Next::Enter)),
        Ok(Err("no"))
    );
    assert_eq!(
        refused.try_with(|| Err::<(), _>("no"), |_: &mut u64, ()| ((), Next::Enter)),
        Ok(Err("no"))
    );
    assert_eq!(command(&lock, &refused), Came::ByTheLock, "its way was never open");
}

#[test]
fn ways_are_as_many_as_is_said_and_go_back() {
    let lock = Lock::new(0);
    let mut ways: Vec<_> = (0..Lock::SHORT_WAYS).map(|_| way(&lock)).collect();
    for way in &ways {
        assert_eq!([(); 2].map(|()| command(&lock, way)), [Came::ByTheLock, Came::Short]);
    }
    let late = way(&lock);
    assert_eq!([(); 2].map(|()| command(&lock, &late)), [Came::ByTheLock; 2], "none is left");
    ways[3].step_back();
    assert_eq!([(); 2].map(|()| command(&lock, &late)), [Came::ByTheLock, Came::Short]);
    assert_eq!(command(&lock, &ways[3]), Came::ByTheLock, "it gave its way up");
    drop(ways.pop());
    assert_eq!([(); 2].map(|()| command(&lock, &ways[3])), [Came::ByTheLock, Came::Short]);
}

#[test]
fn a_ticket_entered_again_by_its_own_driver_refuses() {
    let lock = Lock::new(0);
    let [way, other] = [way(&lock), way(&lock)];
    let enter = |way: &TicketsWay<'_>| {
        way.try_with(|| Ok::<(), ()>(()), |_: &mut u64, ()| ((), Next::Enter))
    };
    for by in [Shut::Reentered, Shut::Reentered] {
        let again = way.with(|| Ok::<(), ()>(()), |_: &mut u64, ()| (enter(&way), Next::Enter));
        assert_eq!(again, Ok(Ok(Err(by))));
    }
    let other = way.with(|| Ok::<(), ()>(()), |_: &mut u64, ()| (enter(&other), Next::Enter));
    assert_eq!(other, Ok(Ok(Err(Shut::Busy))), "another ticket's is told that somebody is in");
}

#[test]
fn a_command_that_unwinds_leaves_its_way() {
    let lock = Lock::new(0);
    let way = way(&lock);
    for _ in 0..2 {
        command(&lock, &way);
        let unwind = || {
            way.with(
                || Ok::<(), ()>(()),
                |_: &mut u64, ()| -> ((), Next) { resume_unwind(Box::new("gone")) },
            )
        };
        assert!(catch_unwind(AssertUnwindSafe(unwind)).is_err());
        assert_eq!(lock.with(|value| *value).map(|value| value > 0), Ok(true));
    }
}

#[test]
fn a_wait_for_a_command_in_flight_ends_at_its_timeout_and_with_the_command() {
    let lock = Lock::new(0);
    let (entered, is_in) = mpsc::channel();
    let (go_on, may_go) = mpsc::channel::<()>();
    thread::scope(|threads| {
        let way = way(&lock);
        command(&lock, &way);
        threads.spawn(move || {
            let stays = way.with(
                || Ok::<(), ()>(()),
                |value: &mut u64, ()| {
                    entered.send(()).unwrap();
                    may_go.recv().unwrap();
                    *value += 1;
                    ((), Next::Enter)
                },
            );
            assert_eq!(stays, Ok(Ok(())));
        });
        is_in.recv().unwrap();
        for timeout in [Duration::ZERO, Duration::from_millis(20)] {
            assert_eq!(lock.with_until(timeout, |_, _| ()), Err(Shut::TimedOut));
        }
        assert_eq!(lock.try_with(|_| ()), Err(Shut::Busy));
        go_on.send(()).unwrap();
        assert_eq!(lock.with_until(PATIENCE, |value, _| *value), Ok(2), "what it did is seen");
    });
}

#[test]
fn one_thread_at_a_time_is_inside_whichever_way_it_came() {
    const ENTRIES: u64 = 20_000;
    let lock = Lock::new(0);
    // A read and a write, apart: two threads inside together lose a count.
    let count = |value: &mut u64| {
        let read = black_box(*value);
        thread::yield_now();
        *value = black_box(read + 1);
    };
    thread::scope(|threads| {
        let tenant = way(&lock);
        threads.spawn(move || {
            for _ in 0..ENTRIES {
                let issued = tenant
                    .with(|| Ok::<(), ()>(()), |value: &mut u64, ()| (count(value), Next::Enter));
                issued.unwrap().unwrap();
            }
        });
        for _ in 0..2 {
            threads.spawn(|| {
                for _ in 0..ENTRIES / 10 {
                    lock.with_until(PATIENCE, |value, _| count(value)).unwrap();
                    (0..100).for_each(|_| thread::yield_now());
                }
            });
        }
    });
    assert_eq!(lock.with(|value| *value), Ok(ENTRIES + 2 * (ENTRIES / 10)));
}

/// Ways of waiting that do not keep what they are asked for.
#[derive(Debug)]
enum Hasty {}

impl Wait for Hasty {
    fn until(_: Duration, _: impl FnMut() -> bool) -> bool {
        true
    }
}

#[derive(Debug)]
enum Panicky {}

impl Wait for Panicky {
    fn until(_: Duration, _: impl FnMut() -> bool) -> bool {
        resume_unwind(Box::new("cannot wait"))
    }
}

/// Runs `meanwhile` while a tenant is inside by its short way.
fn while_inside<W: Wait>(
    lock: &<Fenced<Inner, W> as Strategy>::Lock<u64>,
    meanwhile: impl FnOnce(),
) {
    let (standing, scope) =
        (Box::leak(Box::new(Standing::new())), Box::leak(Box::new(Scope::new())));
    let id = TicketId { seat: 0, serial: 1 };
    let seat = Seat { id, gate: GateId(0), standing, agent: scope, broker: scope };
    let way = lock.way(&seat, PATIENCE);
    let once = |_: &mut u64, ()| ((), Next::Enter);
    way.with(|| Ok::<(), ()>(()), once).unwrap().unwrap();
    let inside = |_: &mut u64, ()| (meanwhile(), Next::Enter);
    way.with(|| Ok::<(), ()>(()), inside).unwrap().unwrap();
}

#[test]
fn who_is_told_too_early_that_a_command_is_over_does_not_enter() {
    let lock: <Fenced<Inner, Hasty> as Strategy>::Lock<u64> = Exclusion::new(0);
    while_inside::<Hasty>(&lock, || {
        for _ in 0..2 {
            assert_eq!(lock.with(|_| ()), Err(Shut::TimedOut));
            assert_eq!(lock.try_with(|_| ()), Err(Shut::Busy));
            assert_eq!(lock.with_until(PATIENCE, |_, _| ()), Err(Shut::TimedOut));
        }
    });
    assert_eq!(lock.with(|value| *value), Ok(0), "the command is over");
}

#[test]
fn who_comes_after_a_wait_that_unwound_waits_too() {
    let lock: <Fenced<Inner, Panicky> as Strategy>::Lock<u64> = Exclusion::new(0);
    while_inside::<Panicky>(&lock, || {
        for _ in 0..2 {
            let unwound = catch_unwind(AssertUnwindSafe(|| lock.with_until(PATIENCE, |_, _| ())));
            assert!(unwound.is_err(), "entered while somebody was inside");
        }
    });
    assert_eq!(lock.with(|value| *value), Ok(0), "the command is over");
}

/// Sections for one thread, which nobody has to end.
#[derive(Debug)]
enum Alone {}

impl Sections for Alone {
    fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Outcome {
        if !watch.is_as_expected() {
            return Outcome::Refused;
        }
        register.store(word, Relaxed);
        Outcome::Stored
    }

    fn end_all() -> bool {
        true
    }
}

type StoreLock = <Restartable<Inner, Alone> as Strategy>::Lock<u64>;

fn store_way(lock: &StoreLock) -> <StoreLock as Exclusion<u64>>::Way<'_> {
    let (standing, scope) =
        (Box::leak(Box::new(Standing::new())), Box::leak(Box::new(Scope::new())));
    let id = TicketId { seat: 0, serial: 1 };
    lock.way(&Seat { id, gate: GateId(0), standing, agent: scope, broker: scope }, PATIENCE)
}

#[test]
fn no_store_is_in_order_while_its_own_ticket_is_inside_or_after_it_unwound() {
    let lock = StoreLock::new(0);
    let (way, register) = (store_way(&lock), AtomicU32::new(0));
    let way = &way;
    let opens = |_: &mut u64, ()| (way.store(&register, 1), Next::Store);
    for _ in 0..2 {
        let inside = way.with(|| Ok::<(), ()>(()), opens).unwrap();
        assert_eq!(inside, Ok(false), "stored by the driver that runs");
        assert!(way.store(&register, 2));
    }
    let unwind = || {
        way.with(
            || Ok::<(), ()>(()),
            |_: &mut u64, ()| -> ((), Next) { resume_unwind(Box::new("gone")) },
        )
    };
    assert!(catch_unwind(AssertUnwindSafe(unwind)).is_err());
    assert!(!way.store(&register, 3), "stored after its command unwound");
    assert_eq!(register.into_inner(), 2);
}

/// Sections that nobody can end.
#[derive(Debug)]
enum Endless {}

impl Sections for Endless {
    fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Outcome {
        Alone::store(watch, register, word)
    }

    fn end_all() -> bool {
        false
    }
}

/// A register, and nothing else.
struct Register(&'static AtomicU32);

impl Device for Register {
    type Command = u32;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new()
    }
    fn declare(_: &u32) -> Declaration {
        Declaration { code: 0, wcet: Duration::from_millis(1), effect: Effect::Unchanged }
    }
    fn issue(&mut self, word: u32) -> Result<(), ()> {
        self.0.store(word, Relaxed);
        Ok(())
    }
    fn safe(&mut self) -> Result<(), ()> {
        Ok(())
    }
    fn register(&self) -> Option<&'static AtomicU32> {
        Some(self.0)
    }
    fn word(word: &u32) -> Option<(u32, ())> {
        Some((*word, ()))
    }
}

/// It is always the start.
struct Stopped;

impl Clock for Stopped {
    fn now(&self) -> clock::Instant {
        clock::Instant::START
    }
}

struct Nobody;

impl Issuer for Nobody {
    fn relinquish(&self, _: &Seat<'_>, _: Unrecorded, _: Holder) {}
}

#[test]
fn a_faulted_gate_takes_no_store() {
    let register: &AtomicU32 = Box::leak(Box::default());
    let (standing, scope) = (Standing::new(), Scope::new());
    let id = TicketId { seat: 0, serial: 1 };
    standing.seat(id.serial, 1);
    let mut gate =
        Gate::<_, (Restartable<Inner, Endless>, _, _)>::new(Register(register), Stopped, NoLane);
    let (key, handle) = gate.key().split();
    let seat = Seat { id, gate: GateId(0), standing: &standing, agent: &scope, broker: &scope };
    let ticket = key.ticket(handle, seat, &Nobody).unwrap();
    let stamp = Stamp { own: standing.epoch_seen(), broker: scope.read().epoch };
    let admission = Admission {
        serial: id.serial,
        tenure: 0,
        agent: stamp.broker,
        validity: Validity::always(),
        stamp: Some((&standing, stamp)),
    };
    key.admit(admission, PATIENCE).unwrap();
    for word in 1..=2 {
        assert_eq!(ticket.invoke(word), Ok(()));
    }
    // Nothing is revoked: the gate is faulted by who could not pass.
    assert_eq!(key.pass(PATIENCE), Err(Blocked::Hung));
    let faulted = Err(InvokeError::Refused(Refusal::Faulted(GateFault::Hung)));
    assert_eq!(ticket.invoke(3), faulted);
    assert_eq!(ticket.try_invoke(4), faulted);
    assert_eq!(register.load(Relaxed), 2);
}
