//! A port on a real broker, with lamps whose truth the test sees.

pub(crate) mod lamp;
mod needs;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;
use std::time::Duration as Patience;

use faregate_agents::{AgentId, Supervisor};
use faregate_scheduler::Mission;
use faregate_scheduler::executive::{Commands, HostClock, TicketPort, Waker};
use faregate_scheduler::manager::{Event, Needs};
use faregate_scheduler::mission::AgentSpec;
use faregate_scheduler::tickets::{Commander, Installation, Named, Tickets};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Clock;
use faregate_tickets::device::{Estimate, Power};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use lamp::{Lamp, Switch, Truth, spec};
pub(crate) use needs::{Needing, attempt, needs, task};

/// How long nothing may happen before a test gives up.
const GIVE_UP: Patience = Patience::from_secs(30);
/// How often the sensors are read while nothing happens.
const SENSOR_PERIOD: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };
/// Readings, and turns of the port, after which what has not happened is not
/// under way either.
const ROUNDS: usize = 50;

pub(crate) struct Rig {
    pub(crate) tickets: Tickets,
    pub(crate) commander: Commander,
    pub(crate) supervisor: Supervisor,
    agent: AgentId,
    pub(crate) lamps: BTreeMap<String, Arc<Truth>>,
    clock: HostClock,
    waker: Waker,
    /// What was told and not waited for yet.
    pub(crate) events: Vec<Event>,
}

pub(crate) const SUPPLY: u32 = 42;

impl Rig {
    /// Lamps of these names, on 42 W.
    pub(crate) fn new(lamps: &[&str]) -> Self {
        Self::with_lease(lamps, Duration::from_secs(60))
    }

    pub(crate) fn with_lease(lamps: &[&str], lease: Duration) -> Self {
        Self::put_together(lamps, lease, false)
    }

    pub(crate) fn on_at_start(lamps: &[&str]) -> Self {
        Self::put_together(lamps, Duration::from_secs(60), true)
    }

    fn put_together(lamps: &[&str], lease: Duration, on: bool) -> Self {
        let supply = Some(Milliwatts::from_watts(SUPPLY));
        let agents = vec![AgentSpec { name: "power".into(), supply }];
        let mission = Mission { agents, lease, ..Mission::default() };
        let waker = Waker::new().unwrap();
        let mut installation = Installation::new(&mission, &waker).unwrap();
        let supervisor = installation.supervisor();
        let agent = installation.agent("power").unwrap();
        let mut truths = BTreeMap::new();
        for name in lamps {
            let truth = Arc::new(Truth { on: on.into(), ..Truth::default() });
            let lamp = Named::new(Lamp(Arc::clone(&truth)))
                .command("on", Switch::On, "light it")
                .command("off", Switch::Off, "darken it")
                .command("break", Switch::Break, "");
            installation.device(&spec(name), Box::new(lamp)).unwrap();
            truths.insert((*name).to_owned(), truth);
        }
        let tickets = installation.start().unwrap();
        let commander = tickets.commander();
        let clock = HostClock::start();
        let events = Vec::new();
        Self { tickets, commander, supervisor, agent, lamps: truths, clock, waker, events }
    }

    pub(crate) fn request(&mut self, number: u32, needs: &Needs, victims: &[u32]) {
        let victims: Vec<_> = victims.iter().map(|victim| task(*victim)).collect();
        self.tickets.request(task(number), needs, &victims, self.clock.now());
    }

    /// Requests, is granted, and its body starts.
    pub(crate) fn run(&mut self, number: u32, needs: &Needs) {
        self.request(number, needs, &[]);
        self.granted(number);
        self.start(number);
    }

    pub(crate) fn start(&mut self, number: u32) {
        self.tickets.started(attempt(number), self.clock.now());
    }

    pub(crate) fn stop(&mut self, number: u32) {
        self.tickets.stopped(task(number), self.clock.now());
    }

    /// Its body is over, and its tickets go back.
    pub(crate) fn end(&mut self, number: u32) {
        self.stop(number);
        self.relinquish(number);
    }

    pub(crate) fn relinquish(&mut self, number: u32) {
        self.tickets.relinquish(task(number), self.clock.now());
    }

    pub(crate) fn reserve(&mut self, mode: &str, gates: &[&str]) {
        let gates: Vec<String> = gates.iter().map(|gate| (*gate).to_owned()).collect();
        self.tickets.reserve(mode, &gates, self.clock.now());
    }

    pub(crate) fn unreserve(&mut self, mode: &str) {
        self.tickets.unreserve(mode, self.clock.now());
    }

    pub(crate) fn command(&self, number: u32, gate: &str, command: &str) -> Result<String, String> {
        let done = self.commander.command(attempt(number), gate, command, &[]);
        done.map_err(|refused| format!("{:?}: {}", refused.kind, refused.reason))
    }

    /// Who took the gate, as a refused command is told.
    pub(crate) fn taker(&self, number: u32, gate: &str) -> Option<String> {
        self.commander.command(attempt(number), gate, "on", &[]).err()?.taken_by
    }

    pub(crate) fn is_on(&self, lamp: &str) -> bool {
        self.lamps[lamp].on.load(SeqCst)
    }

    /// Charged now, in watts.
    pub(crate) fn charged(&self) -> u64 {
        let (_, charged) = self.tickets.broker().agents().margin(self.agent).unwrap();
        charged.get() / 1000
    }

    /// The sensors measure all lamps, and the port takes a turn.
    pub(crate) fn turn(&mut self) {
        let _ = self.waker.take();
        self.measure();
        self.tickets.poll(self.clock.now(), &mut self.events);
    }

    fn measure(&self) {
        let broker = self.tickets.broker();
        for (name, truth) in &self.lamps {
            let measured_at = broker.clock().now();
            let state = if truth.on.load(SeqCst) { Power::On } else { Power::Off };
            let gate = self.commander.gates().id(name).unwrap();
            broker.observe(gate, Estimate { state, measured_at });
        }
    }

    /// Until the port rings, or the sensors are to be read.
    pub(crate) fn sleep(&self) {
        let mut bell = [PollFd::new(&self.waker, PollFlags::IN)];
        let _ = poll(&mut bell, Some(&SENSOR_PERIOD));
    }

    /// Turns until this event was told, which is taken.
    pub(crate) fn told(&mut self, event: &Event) {
        self.told_one(|told| told == event, &format!("{event:?}"));
    }

    pub(crate) fn told_one(&mut self, is: impl Fn(&Event) -> bool, what: &str) -> Event {
        let begun = std::time::Instant::now();
        loop {
            self.turn();
            if let Some(at) = self.events.iter().position(&is) {
                return self.events.remove(at);
            }
            assert!(begun.elapsed() < GIVE_UP, "not told: {what}, but {:?}", self.events);
            self.sleep();
        }
    }

    pub(crate) fn granted(&mut self, number: u32) {
        self.told(&Event::Granted { occurrence: task(number) });
    }

    /// Is granted, and its body runs to its end.
    pub(crate) fn granted_and_done(&mut self, number: u32) {
        self.granted(number);
        self.start(number);
        self.end(number);
    }

    pub(crate) fn taken(&mut self, number: u32, by: &str) {
        self.told(&Event::Taken { occurrence: task(number), by: by.to_owned() });
    }

    /// Why the request waits, or can never be granted.
    pub(crate) fn why(&mut self, number: u32) -> String {
        let of = |event: &Event| match event {
            Event::Blocked { occurrence, why } | Event::Refused { occurrence, why } => {
                (*occurrence == task(number)).then(|| why.clone())
            }
            _ => None,
        };
        let told = self.told_one(|event| of(event).is_some(), "why it waits");
        of(&told).unwrap()
    }

    /// Nothing is told, however often anybody looks.
    pub(crate) fn nothing_is_told(&mut self) {
        for _ in 0..ROUNDS {
            self.turn();
            assert_eq!(self.events, []);
            self.sleep();
        }
    }

    pub(crate) fn until(&mut self, what: &str, mut is: impl FnMut(&Self) -> bool) {
        let begun = std::time::Instant::now();
        while !is(self) {
            assert!(begun.elapsed() < GIVE_UP, "never: {what}");
            self.turn();
            self.sleep();
        }
    }
}
