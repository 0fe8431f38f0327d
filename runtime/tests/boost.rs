//! The default strategy on Linux inherits priorities: a holder that is
//! pre-empted inside a command is boosted by whoever waits for the gate.
#![cfg(target_os = "linux")]

use std::any::TypeId;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use faregate_agents::Policy;
use faregate_runtime::Broker;
use faregate_runtime::host::{Host, HostStrategy, Tid};
use faregate_runtime::realtime::RealTime;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Effect, Profile};
use faregate_tickets::id::Priority;
use faregate_tickets::lock::PiLocked;
use faregate_tickets::{Device, Platform};

const LONG: Duration = Duration::from_secs(20);

#[test]
fn the_default_strategy_is_the_priority_inheriting_lock() {
    assert_eq!(TypeId::of::<HostStrategy>(), TypeId::of::<PiLocked<Tid>>());
    assert_eq!(TypeId::of::<<Host as Platform>::Strategy>(), TypeId::of::<PiLocked<Tid>>());
}

/// A device whose command tells the priority at which it runs: at once, and
/// when it has changed.
struct Mirror {
    inside: Sender<i64>,
    leave: Receiver<()>,
}

impl Device for Mirror {
    type Command = ();
    type Response = i64;
    type Fault = ();

    fn profile(&self) -> Profile {
        let mut profile = Profile::new();
        profile.longest_command = LONG;
        profile
    }

    fn declare((): &()) -> Declaration {
        Declaration { code: 1, wcet: LONG, effect: Effect::Unchanged }
    }

    fn issue(&mut self, (): ()) -> Result<i64, ()> {
        let before = own_priority();
        self.inside.send(before).map_err(drop)?;
        loop {
            let now = own_priority();
            if now != before || self.leave.try_recv().is_ok() {
                return Ok(now);
            }
            thread::yield_now();
        }
    }

    fn safe(&mut self) -> Result<(), ()> {
        Ok(())
    }
}

/// The calling thread's effective real-time priority, as the kernel tells it:
/// field 18 of `stat` is minus one minus that.
fn own_priority() -> i64 {
    let stat = std::fs::read_to_string("/proc/thread-self/stat").expect("procfs is mounted");
    let after_name = stat.rsplit(')').next().expect("a name in parentheses");
    let field = after_name.split_whitespace().nth(15).expect("field 18");
    -1 - field.parse::<i64>().expect("a number")
}

#[test]
fn a_holder_inside_a_command_is_boosted_by_the_requester() {
    let (inside, told) = channel();
    let (_leave, leaving) = channel();
    let mut builder = Broker::builder().expect("the host has wake-ups").real_time(30);
    let agent = builder.agent(Policy::exclusive()).expect("room");
    let mirror = Mirror { inside, leave: leaving };
    let mirror = builder.gate(agent, "mirror", mirror).expect("room");
    let broker = builder.start().expect("the host has threads");

    let permitted = RealTime::request().fifo(10).apply();
    if !permitted.is_complete() {
        assert!(std::env::var_os("CI").is_none(), "in CI this must be permitted: {permitted}");
        eprintln!("SKIPPED, because not permitted: {permitted}");
        return;
    }
    let ticket = broker.request(Priority::SCIENCE, &mirror).expect("it fits");
    broker.wait(&ticket, LONG).expect("nobody else wants it");
    let holder = thread::spawn(move || {
        let _ = RealTime::request().fifo(10).apply();
        ticket.invoke(())
    });
    assert_eq!(told.recv(), Ok(10), "the holder is inside, at its own priority");
    // Revoked; the service thread, at priority 30, waits at the gate.
    let emergency = broker.request(Priority::EMERGENCY, &mirror).expect("it fits");
    let seen = holder.join().expect("the holder does not panic");
    assert_eq!(seen, Ok(30), "boosted to the priority of who waits for it");
    broker.wait(&emergency, LONG).expect("the holder has left");
}
