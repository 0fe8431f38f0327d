//! A port on a real broker, with lamps whose truth the test sees.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::time::Duration as Patience;

use faregate_agents::{AgentId, Categories, Supervisor};
use faregate_scheduler::Mission;
use faregate_scheduler::executive::{Commands, HostClock, TicketPort, Waker};
use faregate_scheduler::manager::{Attempt, Event, Needs, Occurrence};
use faregate_scheduler::mission::{AgentSpec, DeviceSpec};
use faregate_scheduler::task::{TaskId, TaskPriority};
use faregate_scheduler::tickets::{Commander, Installation, Named, Tickets};
use faregate_scheduler::time::Duration;
use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Clock;
use faregate_tickets::device::{Declaration, Effect, Estimate, Power, Profile};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// How long nothing may happen before a test gives up.
const GIVE_UP: Patience = Patience::from_secs(30);
/// How often the sensors are read while nothing happens.
const SENSOR_PERIOD: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };
/// Readings, and turns of the port, after which what has not happened is not
/// under way either.
const ROUNDS: usize = 50;

pub(crate) const LAMP: Milliwatts = Milliwatts::from_watts(8);

#[derive(Debug, Default)]
pub(crate) struct Truth {
    pub(crate) on: AtomicBool,
    /// Whether a command waits until this is false.
    pub(crate) slow: AtomicBool,
    pub(crate) inside: AtomicBool,
}

pub(crate) struct Lamp(Arc<Truth>);

#[derive(Clone, Copy)]
pub(crate) enum Switch {
    On,
    Off,
    Break,
}

impl Device for Lamp {
    type Command = Switch;
    type Response = ();
    type Fault = &'static str;

    fn profile(&self) -> Profile {
        let mut profile = Profile::new().drawing(LAMP);
        profile.longest_command = Duration::from_secs(20);
        profile.longest_safing = Duration::from_secs(20);
        profile.estimate_lag = Duration::from_secs(5);
        profile
    }
    fn declare(command: &Switch) -> Declaration {
        let effect = match command {
            Switch::On => Effect::on(LAMP),
            Switch::Off => Effect::Off,
            Switch::Break => Effect::Unchanged,
        };
        Declaration { code: *command as u16, wcet: Duration::from_secs(20), effect }
    }
    fn issue(&mut self, command: Switch) -> Result<(), &'static str> {
        self.0.inside.store(true, SeqCst);
        while self.0.slow.load(SeqCst) {
            std::thread::yield_now();
        }
        self.0.inside.store(false, SeqCst);
        match command {
            Switch::Break => return Err("its filament broke"),
            _ => self.0.on.store(matches!(command, Switch::On), SeqCst),
        }
        Ok(())
    }
    fn safe(&mut self) -> Result<(), &'static str> {
        self.0.on.store(false, SeqCst);
        Ok(())
    }
}

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

/// The occurrence of the task of this number.
pub(crate) fn task(number: u32) -> Occurrence {
    Occurrence { task: TaskId::new(number).unwrap(), load: 0, number: 0 }
}

pub(crate) fn attempt(number: u32) -> Attempt {
    Attempt { occurrence: task(number), number: 1 }
}

pub(crate) fn needs(priority: u8) -> Needs {
    Needs {
        priority: TaskPriority::new(priority).unwrap(),
        categories: Categories::NONE,
        draw: Milliwatts::ZERO,
        gates: Vec::new(),
        grace: Duration::ZERO,
    }
}

pub(crate) trait Needing {
    fn using(self, category: u32) -> Needs;
    fn drawing(self, watts: u32) -> Needs;
    fn commanding(self, gates: &[&str]) -> Needs;
}

impl Needing for Needs {
    fn using(self, category: u32) -> Needs {
        Needs { categories: Categories::from_mask(1 << category), ..self }
    }
    fn drawing(self, watts: u32) -> Needs {
        Needs { draw: Milliwatts::from_watts(watts), ..self }
    }
    fn commanding(self, gates: &[&str]) -> Needs {
        Needs { gates: gates.iter().map(|gate| (*gate).to_owned()).collect(), ..self }
    }
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

fn spec(name: &str) -> DeviceSpec {
    DeviceSpec {
        name: name.into(),
        kind: "lamp".into(),
        agent: "power".into(),
        draw: None,
        categories: Categories::NONE,
        parameters: BTreeMap::new(),
    }
}
