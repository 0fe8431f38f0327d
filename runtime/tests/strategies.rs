//! Gates behind the strategies that are not the host's own.
#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc;
use std::thread;

use faregate_agents::Policy;
use faregate_runtime::broker::{Broker, Builder, GateOptions, Handle};
use faregate_runtime::host::{HostFenced, HostRestartable, HostStrategy, Supported};
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Device, Effect, Profile};
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::{InvokeError, Refusal};

/// A wheel whose torque is a register. What the register takes, and what the
/// driver was given, can be told apart.
struct Wheel {
    torque: &'static AtomicU32,
    driven: &'static AtomicU32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Torque {
    Set(u32),
    /// Not a mere store: it is asked what it was.
    Swap(u32),
}

impl Device for Wheel {
    type Command = Torque;
    type Response = u32;
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new()
    }
    fn declare(_: &Torque) -> Declaration {
        Declaration { code: 1, wcet: Duration::from_millis(1), effect: Effect::Unchanged }
    }
    fn issue(&mut self, command: Torque) -> Result<u32, ()> {
        self.driven.fetch_add(1, Ordering::Relaxed);
        match command {
            Torque::Set(torque) => self.torque.store(torque, Ordering::Relaxed),
            Torque::Swap(torque) => return Ok(self.torque.swap(torque, Ordering::Relaxed)),
        }
        Ok(0)
    }
    fn safe(&mut self) -> Result<(), ()> {
        self.torque.store(0, Ordering::Relaxed);
        Ok(())
    }
    fn register(&self) -> Option<&'static AtomicU32> {
        Some(self.torque)
    }
    fn word(command: &Torque) -> Option<(u32, u32)> {
        match command {
            Torque::Set(torque) => Some((*torque, 0)),
            Torque::Swap(_) => None,
        }
    }
}

fn word() -> &'static AtomicU32 {
    Box::leak(Box::default())
}

/// A wheel behind a gate of this strategy, its register, and how often its
/// driver was called.
fn wheel<S: Supported>() -> (Broker, Handle<Wheel, S>, &'static AtomicU32, &'static AtomicU32) {
    let (torque, driven) = (word(), word());
    let mut builder: Builder = Broker::builder().unwrap();
    let agent = builder.agent(Policy::exclusive()).unwrap();
    let driver = Wheel { torque, driven };
    let gate = builder.gate_behind::<S, _>(agent, "wheel", driver, GateOptions::new()).unwrap();
    (builder.start().unwrap(), gate, torque, driven)
}

const SOON: Duration = Duration::from_secs(20);

fn a_ticket_is_valid_revoked_and_restored<S: Supported>() {
    let (broker, wheel, torque, _) = wheel::<S>();
    let science = broker.request(Priority::SCIENCE, &wheel).unwrap();
    broker.wait(&science, SOON).unwrap();
    for set in 1..100 {
        assert_eq!(science.invoke(Torque::Set(set)), Ok(0));
        assert_eq!(torque.load(Ordering::Relaxed), set);
        assert_eq!(science.try_invoke(Torque::Swap(7)), Ok(set));
    }
    let emergency = broker.request(Priority::EMERGENCY, &wheel).unwrap();
    let refused = science.invoke(Torque::Set(8));
    assert!(matches!(refused, Err(InvokeError::Refused(Refusal::NotValid(_)))), "{refused:?}");
    broker.wait(&emergency, SOON).unwrap();
    assert_eq!(torque.load(Ordering::Relaxed), 7, "as the revoked command left it alone");
    for set in 1..100 {
        assert_eq!(emergency.invoke(Torque::Set(set)), Ok(0));
        assert!(science.invoke(Torque::Set(9)).is_err());
        assert_eq!(torque.load(Ordering::Relaxed), set);
    }
    drop(emergency);
    broker.wait(&science, SOON).unwrap();
    assert_eq!(science.invoke(Torque::Set(5)), Ok(0));
    assert_eq!(torque.load(Ordering::Relaxed), 5);
}

#[test]
fn a_ticket_is_valid_revoked_and_restored_behind_every_strategy() {
    a_ticket_is_valid_revoked_and_restored::<HostStrategy>();
    a_ticket_is_valid_revoked_and_restored::<HostFenced>();
    a_ticket_is_valid_revoked_and_restored::<HostRestartable>();
}

#[test]
fn the_first_command_goes_to_the_driver_and_the_next_ones_are_stores() {
    let (broker, wheel, torque, driven) = wheel::<HostRestartable>();
    let ticket = broker.request(Priority::SCIENCE, &wheel).unwrap();
    broker.wait(&ticket, SOON).unwrap();
    for set in 1..=50 {
        ticket.invoke(Torque::Set(set)).unwrap();
    }
    assert_eq!(torque.load(Ordering::Relaxed), 50);
    assert_eq!(driven.load(Ordering::Relaxed), 1);
    ticket.invoke(Torque::Swap(1)).unwrap();
    ticket.invoke(Torque::Set(2)).unwrap();
    assert_eq!(driven.load(Ordering::Relaxed), 2, "its own command did not close its way");
}

fn a_ticket_goes_on_in_another_thread<S: Supported>() {
    let (broker, wheel, torque, _) = wheel::<S>();
    let ticket = broker.request(Priority::SCIENCE, &wheel).unwrap();
    broker.wait(&ticket, SOON).unwrap();
    let (send, receive) = mpsc::channel();
    send.send(ticket).unwrap();
    thread::scope(|threads| {
        for from in [0, 100, 200] {
            let ticket = receive.recv().unwrap();
            let back = send.clone();
            threads
                .spawn(move || {
                    (from..from + 100).for_each(|set| {
                        ticket.invoke(Torque::Set(set)).unwrap();
                    });
                    back.send(ticket).unwrap();
                })
                .join()
                .unwrap();
        }
    });
    assert_eq!(torque.load(Ordering::Relaxed), 299);
}

#[test]
fn a_ticket_goes_on_in_another_thread_behind_every_strategy() {
    a_ticket_goes_on_in_another_thread::<HostStrategy>();
    a_ticket_goes_on_in_another_thread::<HostFenced>();
    a_ticket_goes_on_in_another_thread::<HostRestartable>();
}
