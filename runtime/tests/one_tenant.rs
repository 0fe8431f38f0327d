//! **One Tenant**, as a witness: whatever safe code does with a gate's key, two
//! tickets of the gate are never valid together, behind any strategy.
#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

use std::sync::atomic::AtomicU32;

use faregate_runtime::clock::MonotonicClock;
use faregate_runtime::host::{HostFenced, HostRestartable, HostStrategy, Supported};
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Device, Effect, Profile};
use faregate_tickets::gate::{Admission, Key};
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::lock::Strategy;
use faregate_tickets::recorder::{NoLane, Unrecorded};
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::{Stamp, Standing, Why};
use faregate_tickets::ticket::{Holder, Issuer, Seat};
use faregate_tickets::validity::Validity;
use faregate_tickets::{Gate, Ticket};

/// A register, which remembers who wrote it.
struct Register(&'static AtomicU32);

impl Device for Register {
    type Command = u32;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        // A thread that is pre-empted here must not fault the gate.
        Profile { longest_command: PATIENCE, ..Profile::new() }
    }
    fn declare(_: &u32) -> Declaration {
        Declaration { code: 1, wcet: PATIENCE, effect: Effect::Unchanged }
    }
    fn issue(&mut self, word: u32) -> Result<(), ()> {
        self.0.store(word, std::sync::atomic::Ordering::Relaxed);
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

struct Nobody;

impl Issuer for Nobody {
    fn relinquish(&self, _: &Seat<'_>, _: Unrecorded, _: Holder) {}
}

type Ports<S> = (S, MonotonicClock, NoLane);

/// What safe code with a key can do, well or badly.
#[derive(Clone, Copy, Debug)]
enum Act {
    Admit(usize),
    Vacate,
    Revoke(usize),
    RevokeAll,
    Invoke(usize),
}

const ACTS: [Act; 8] = [
    Act::Admit(0),
    Act::Admit(1),
    Act::Vacate,
    Act::Revoke(0),
    Act::Revoke(1),
    Act::RevokeAll,
    Act::Invoke(0),
    Act::Invoke(1),
];

/// A gate with two tickets and a policy that revokes nobody.
struct Bench<'g, S: Strategy> {
    key: &'g Key<'g>,
    standings: &'g [Standing; 2],
    agent: &'g Scope,
    broker: &'g Scope,
    tickets: [Ticket<'g, Register, Ports<S>, Nobody>; 2],
    tenure: usize,
    /// How often either was valid, so that the test is about something.
    valid: usize,
}

const PATIENCE: Duration = Duration::from_secs(20);

impl<S: Strategy> Bench<'_, S> {
    fn act(&mut self, act: Act) {
        match act {
            Act::Admit(holder) => {
                let standing = &self.standings[holder];
                let stamp = Stamp { own: standing.epoch_seen(), broker: self.broker.read().epoch };
                let admission = Admission {
                    serial: holder + 1,
                    tenure: self.tenure,
                    agent: self.agent.read().epoch,
                    validity: Validity::always(),
                    stamp: Some((standing, stamp)),
                };
                self.tenure = self.key.admit(admission, PATIENCE).unwrap();
            }
            Act::Vacate => self.tenure = self.key.vacate(self.tenure, PATIENCE).unwrap().tenure,
            Act::Revoke(holder) => self.standings[holder].revoke(Why::SupplyFell),
            Act::RevokeAll => self.broker.revoke_all(),
            Act::Invoke(holder) => {
                let valid = self.tickets[holder].check().is_ok();
                let issued = self.tickets[holder].invoke(1).is_ok();
                assert_eq!(issued, valid, "Open Door, Closed Door: holder {holder}");
            }
        }
    }

    fn check(&mut self, done: &[Act]) {
        let valid = self.tickets.each_ref().map(|ticket| ticket.check().is_ok());
        assert_ne!(valid, [true; 2], "One Tenant: both tickets are valid after {done:?}");
        self.valid += usize::from(valid != [false; 2]);
    }
}

fn every_history<S: Strategy>(length: u32) -> usize {
    let register: &'static AtomicU32 = Box::leak(Box::default());
    let mut gate = Gate::<_, Ports<S>>::new(Register(register), MonotonicClock::new(), NoLane);
    let mut valid = 0;
    for history in 0..ACTS.len().pow(length) {
        let (key, handle) = gate.key().split();
        let (agent, broker, standings) =
            (Scope::new(), Scope::new(), [Standing::new(), Standing::new()]);
        let tickets = [0, 1].map(|holder| {
            let standing = &standings[holder];
            standing.seat(holder + 1, 1);
            let id = TicketId { seat: 0, serial: holder + 1 };
            let seat = Seat { id, gate: GateId(0), standing, agent: &agent, broker: &broker };
            key.ticket(handle, seat, &Nobody).unwrap()
        });
        let mut bench = Bench {
            key: &key,
            standings: &standings,
            agent: &agent,
            broker: &broker,
            tickets,
            tenure: 0,
            valid: 0,
        };
        let acts: Vec<Act> =
            (0..length).map(|place| ACTS[history / ACTS.len().pow(place) % ACTS.len()]).collect();
        for done in 1..=acts.len() {
            bench.act(acts[done - 1]);
            bench.check(&acts[..done]);
        }
        valid += bench.valid;
    }
    valid
}

#[test]
fn no_history_makes_two_tickets_of_one_gate_valid_together() {
    HostRestartable::check().unwrap();
    let valid = [
        every_history::<HostStrategy>(5),
        every_history::<HostFenced>(5),
        every_history::<HostRestartable>(5),
    ];
    assert!(valid[0] > 30_000, "too few histories made anybody valid: {valid:?}");
    assert_eq!(valid, [valid[0]; 3], "and all strategies agree about who");
}
