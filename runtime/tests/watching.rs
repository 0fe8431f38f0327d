//! A program that watches tickets is told of each that changed, whoever did it.

use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use faregate_agents::{Policy, Supervisor};
use faregate_runtime::TicketChange::{GrantedOrEnded, Revoked};
use faregate_runtime::{Broker, Handle, TicketChange};
use faregate_tickets::Device;
use faregate_tickets::clock::Duration as Micros;
use faregate_tickets::device::{Declaration, Effect, Profile};
use faregate_tickets::id::{Priority, TicketId};
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use faregate_tickets::validity::Function;

/// How long the watcher may be silent before the test gives up.
const SILENCE: Duration = Duration::from_secs(20);

/// A device that can do nothing.
struct Stone;

impl Device for Stone {
    type Command = ();
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new()
    }
    fn declare((): &()) -> Declaration {
        Declaration { code: 0, wcet: Micros::from_millis(1), effect: Effect::Unchanged }
    }
    fn issue(&mut self, (): ()) -> Result<(), ()> {
        Ok(())
    }
    fn safe(&mut self) -> Result<(), ()> {
        Ok(())
    }
}

struct Watched {
    broker: Broker,
    stone: Handle<Stone>,
    supervisor: Supervisor,
    told: Receiver<(TicketId, TicketChange)>,
}

fn watched() -> Watched {
    let (tell, told) = channel();
    let mut builder = Broker::builder().expect("the host has wake-ups");
    let agent = builder.agent(Policy::exclusive()).expect("room");
    let stone = builder.gate(agent, "stone", Stone).expect("room");
    let supervisor = builder.supervisor();
    let builder = builder.watch(move |ticket, change| {
        // Nobody hears it any more when the test is over.
        let _ = tell.send((ticket, change));
    });
    Watched { broker: builder.start().expect("the host has threads"), stone, supervisor, told }
}

impl Watched {
    /// Waits until the watcher was told of this ticket when this was so.
    fn told_of(&self, ticket: TicketId, change: TicketChange, and: impl Fn() -> bool) {
        let told = || self.told.recv_timeout(SILENCE).expect("the watcher is told");
        while told() != (ticket, change) || !and() {}
    }
}

#[test]
fn a_watcher_is_told_of_what_is_granted_taken_and_given_back() {
    let watched = watched();
    let request = |priority| watched.broker.request(priority, &watched.stone).unwrap();
    let science = request(Priority::SCIENCE);
    watched.told_of(science.id(), GrantedOrEnded, || science.check().is_ok());
    let emergency = request(Priority::EMERGENCY);
    let by = Why::Preempted { by: emergency.id(), priority: Priority::EMERGENCY };
    watched.told_of(science.id(), Revoked, || science.check() == Err(Refusal::NotValid(by)));
    watched.told_of(emergency.id(), GrantedOrEnded, || emergency.check().is_ok());
    let gone = emergency.id();
    drop(emergency);
    watched.told_of(gone, GrantedOrEnded, || true);
    watched.told_of(science.id(), GrantedOrEnded, || science.check().is_ok());
}

#[test]
fn a_watcher_is_told_of_what_a_supervisor_barred_and_of_safe_mode() {
    let watched = watched();
    let ticket = watched.broker.request(Priority::SCIENCE, &watched.stone).unwrap();
    watched.told_of(ticket.id(), GrantedOrEnded, || ticket.check().is_ok());
    let agents = watched.broker.agents();
    agents.bar(&watched.supervisor, ticket.id()).unwrap().without_waiting();
    watched.told_of(ticket.id(), Revoked, || ticket.check() == Err(Refusal::NotValid(Why::Barred)));
    agents.reinstate(&watched.supervisor, ticket.id()).unwrap();
    watched.told_of(ticket.id(), GrantedOrEnded, || ticket.check().is_ok());
    let floor = Priority::FAULT_RESPONSE;
    agents.enter_safe_mode(&watched.supervisor, floor).unwrap().without_waiting();
    watched.told_of(ticket.id(), Revoked, || ticket.check().is_err());
    agents.leave_safe_mode(&watched.supervisor).unwrap();
    watched.told_of(ticket.id(), GrantedOrEnded, || ticket.check().is_ok());
}

#[test]
fn a_watcher_is_told_of_a_lease_that_ended() {
    let watched = watched();
    let want = watched.stone.limited(Function::lease(Micros::from_millis(5)));
    let ticket = watched.broker.request(Priority::SCIENCE, &want).unwrap();
    let expired = Err(Refusal::NotValid(Why::Expired));
    watched.told_of(ticket.id(), GrantedOrEnded, || ticket.check() == expired);
}

#[test]
fn a_broker_is_put_together_on_a_small_stack() {
    let thread = std::thread::Builder::new().stack_size(64 * 1024);
    let made = thread.spawn(|| Broker::builder().map(drop)).expect("the host has threads");
    made.join().expect("it has room").expect("the host has wake-ups");
}
