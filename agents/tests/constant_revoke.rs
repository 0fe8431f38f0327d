//! **Constant Revoke**: revoking takes no lock, and the same few steps whatever
//! the number of tickets.

mod bench;

use std::marker::PhantomData;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

use bench::{Caught, Hands, Lamp, TICK, Truth, drawing, leak};
use faregate_agents::{Broker, Handle, Policy, Supervisor};
use faregate_tickets::clock::Duration;
use faregate_tickets::id::Priority;
use faregate_tickets::lock::{Exclusion, Locked, Owner, Shut, Strategy};
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;
use faregate_tickets::ticket::Seat;
use faregate_tickets::{Gate, Platform};

type Inner = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

/// How often any lock was entered. One test owns it.
static ENTERED: AtomicUsize = AtomicUsize::new(0);

/// A strategy that counts.
struct Counted(PhantomData<()>);

struct CountedLock<T: Send>(<Inner as Strategy>::Lock<T>);

impl Strategy for Counted {
    type Lock<T: Send> = CountedLock<T>;
}

impl<T: Send> Exclusion<T> for CountedLock<T> {
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
        ENTERED.fetch_add(1, SeqCst);
        self.0.with(f)
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        ENTERED.fetch_add(1, SeqCst);
        self.0.try_with(f)
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        ENTERED.fetch_add(1, SeqCst);
        self.0.with_until(timeout, f)
    }
}

#[derive(Debug)]
struct Counting;

impl Platform for Counting {
    type Strategy = Counted;
    type Clock = &'static Hands;
    type Lane = NoLane;
    type Containment = Caught;
}

type CountingBroker = Broker<'static, Counting, NoNotify, 64, 256, 2>;
type Lamps = Vec<Handle<'static, Lamp, Counting>>;

fn broker_with(gates: usize) -> (Box<CountingBroker>, Lamps, Supervisor) {
    let clock: &'static Hands = leak(Hands::default());
    clock.advance(TICK);
    let mut broker = Box::new(CountingBroker::new(clock, NoLane, NoNotify));
    let agent = broker.agent(Policy::unlimited()).unwrap();
    let lamps = (0..gates).map(|_| {
        let truth: &'static Truth = leak(Truth::default());
        let lamp = Lamp::new(truth, drawing(8));
        let gate: &'static mut Gate<'static, Lamp, Counting> = leak(Gate::new(lamp, clock, NoLane));
        broker.register(agent, gate.key()).unwrap()
    });
    let lamps = lamps.collect();
    let supervisor = broker.supervisor();
    (broker, lamps, supervisor)
}

fn entered(f: impl FnOnce()) -> usize {
    let before = ENTERED.load(SeqCst);
    f();
    ENTERED.load(SeqCst) - before
}

#[test]
fn revoking_one_ticket_or_hundreds_enters_no_lock() {
    for (gates, each) in [(1, 1), (64, 3)] {
        let (broker, lamps, supervisor) = broker_with(gates);
        let tickets: Vec<_> = lamps
            .iter()
            .flat_map(|lamp| (0..each).map(|_| broker.request(Priority::SCIENCE, lamp).unwrap()))
            .collect();
        // One call does a bounded number of steps.
        for _ in 0..4 {
            broker.service();
        }
        let valid = || tickets.iter().filter(|ticket| ticket.check().is_ok()).count();
        assert_eq!(valid(), gates);
        assert!(entered(|| assert!(tickets[0].renew().is_ok())) > 0, "the count counts");

        let floor = Priority::EMERGENCY;
        let barred = || broker.bar(&supervisor, tickets[0].id()).unwrap().without_waiting();
        assert_eq!(entered(barred), 0);
        let all = || broker.enter_safe_mode(&supervisor, floor).unwrap().without_waiting();
        assert_eq!(entered(all), 0);
        let but_me = || {
            let (exempt, revoked) =
                broker.revoke_all_but_me(&supervisor, &tickets[0], floor).unwrap();
            revoked.without_waiting();
            assert!(!exempt, "it had been revoked before");
        };
        assert_eq!(entered(but_me), 0);
        assert_eq!(valid(), 0);
    }
}
