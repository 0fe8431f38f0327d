//! A broker with one gate, in which whoever comes for the agent stays as long
//! as the test wants.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use faregate_agents::{Broker, Handle, Policy, Supervisor};
use faregate_tickets::clock::Duration;
use faregate_tickets::device::Profile;
use faregate_tickets::lock::{Exclusion, Locked, Owner, Shut, Strategy};
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;
use faregate_tickets::ticket::Seat;
use faregate_tickets::{Gate, Platform};

use super::bench::{Caught, Hands, Lamp, Truth, drawing, leak};

/// Whoever comes to a deadline stays inside until this is false.
pub(crate) static HOLD: AtomicBool = AtomicBool::new(false);
/// Somebody stays.
pub(crate) static INSIDE: AtomicBool = AtomicBool::new(false);
/// Somebody came meanwhile who waits as long as it takes.
pub(crate) static WAITING: AtomicBool = AtomicBool::new(false);

pub(crate) fn wait_for(flag: &AtomicBool) {
    while !flag.load(SeqCst) {
        std::thread::yield_now();
    }
}

type Inner = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

pub(crate) struct Slow(PhantomData<()>);

pub(crate) struct SlowLock<T: Send>(<Inner as Strategy>::Lock<T>);

impl Strategy for Slow {
    type Lock<T: Send> = SlowLock<T>;
}

impl<T: Send> Exclusion<T> for SlowLock<T> {
    type Way<'l>
        = &'l Self
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, _: Duration) -> &'l Self {
        self
    }

    fn new(value: T) -> Self {
        Self(Exclusion::new(value))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        if INSIDE.load(SeqCst) {
            WAITING.store(true, SeqCst);
        }
        self.0.with(f)
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.0.try_with(f)
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        self.0.with_until(timeout, |value, owner| {
            INSIDE.store(HOLD.load(SeqCst), SeqCst);
            while HOLD.load(SeqCst) {
                std::thread::yield_now();
            }
            f(value, owner)
        })
    }
}

#[derive(Debug)]
pub(crate) struct Stays;

impl Platform for Stays {
    type Strategy = Slow;
    type Clock = &'static Hands;
    type Lane = NoLane;
    type Containment = Caught;
}

pub(crate) type SlowBroker = Broker<'static, Stays, NoNotify, 1, 2, 0>;

pub(crate) fn broker() -> (&'static SlowBroker, Handle<'static, Lamp, Stays>, Supervisor) {
    let clock: &'static Hands = leak(Hands::default());
    let broker = leak(SlowBroker::new(clock, NoLane, NoNotify));
    let agent = broker.agent(Policy::unlimited()).unwrap();
    let truth: &'static Truth = leak(Truth::default());
    let profile = Profile { longest_command: Duration::from_secs(60), ..drawing(8) };
    let gate: &'static mut Gate<'static, Lamp, Stays> =
        leak(Gate::new(Lamp::new(truth, profile), clock, NoLane));
    let lamp = broker.register(agent, gate.key()).unwrap();
    let supervisor = broker.supervisor();
    (broker, lamp, supervisor)
}
