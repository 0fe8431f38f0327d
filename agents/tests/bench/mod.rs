//! A bench with two lamps on one supply: devices whose truth the test sets.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use faregate_agents::{AgentId, Broker, Handle, Policy};
use faregate_tickets::Gate;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Device, Effect, Estimate, Power, Profile};
use faregate_tickets::lock::Locked;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;

pub type Platform =
    (Locked<parking_lot::RawMutex, parking_lot::RawThreadId>, &'static Hands, NoLane);
pub type TestBroker = Broker<'static, Platform, NoNotify, 4, 8, 2>;
pub type Ticket = faregate_tickets::Ticket<'static, Lamp, Platform, TestBroker>;

/// A clock whose hands the test moves.
#[derive(Debug, Default)]
pub struct Hands(AtomicU64);

impl Clock for Hands {
    fn now(&self) -> Instant {
        Instant::from_micros(self.0.load(Ordering::SeqCst))
    }
}

impl Hands {
    pub fn advance(&self, by: Duration) {
        self.0.fetch_add(by.as_micros(), Ordering::SeqCst);
    }
}

/// What is true of a lamp, whatever anybody thinks.
#[derive(Debug, Default)]
pub struct Truth {
    pub on: AtomicBool,
    pub safed: AtomicUsize,
    pub deaf_to_safing: AtomicUsize,
}

#[derive(Debug)]
pub struct Lamp(&'static Truth, Milliwatts);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    On,
    Off,
    Fault,
    Panic,
}

impl Device for Lamp {
    type Command = Switch;
    type Response = ();
    type Fault = &'static str;

    fn profile(&self) -> Profile {
        Profile::new().drawing(self.1)
    }

    fn declare(command: &Switch) -> Declaration {
        let effect = match command {
            Switch::On => Effect::on(Milliwatts::from_watts(5)),
            Switch::Off => Effect::Off,
            Switch::Fault | Switch::Panic => Effect::Unchanged,
        };
        Declaration { code: *command as u16, wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, command: Switch) -> Result<(), &'static str> {
        match command {
            Switch::Fault => return Err("blown"),
            Switch::Panic => panic!("the driver panicked, as the test wants"),
            Switch::On | Switch::Off => self.0.on.store(command == Switch::On, Ordering::SeqCst),
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), &'static str> {
        self.0.safed.fetch_add(1, Ordering::SeqCst);
        let deaf = &self.0.deaf_to_safing;
        if deaf.load(Ordering::SeqCst) > 0 {
            deaf.fetch_sub(1, Ordering::SeqCst);
        } else {
            self.0.on.store(false, Ordering::SeqCst);
        }
        Ok(())
    }
}

pub struct Bench {
    pub broker: &'static TestBroker,
    pub agent: AgentId,
    pub clock: &'static Hands,
    pub lamps: Vec<Handle<'static, Lamp, Platform>>,
    pub truths: Vec<&'static Truth>,
}

impl Bench {
    /// Lamps that draw so many watts, seen off at the start.
    pub fn new(policy: Policy, watts: &[u32]) -> (Self, faregate_agents::Supervisor) {
        let clock: &'static Hands = Box::leak(Box::default());
        let mut broker = Box::new(TestBroker::new(clock, NoLane, NoNotify));
        let agent = broker.agent(policy).unwrap();
        let (mut lamps, mut truths) = (Vec::new(), Vec::new());
        for watts in watts {
            let truth: &'static Truth = Box::leak(Box::default());
            let lamp = Lamp(truth, Milliwatts::from_watts(*watts));
            let gate: &'static mut Gate<'static, Lamp, Platform> =
                Box::leak(Box::new(Gate::new(lamp, clock, NoLane)));
            lamps.push(broker.register(agent, gate.key()).unwrap());
            truths.push(truth);
        }
        let supervisor = broker.supervisor();
        let bench = Self { broker: Box::leak(broker), agent, clock, lamps, truths };
        bench.pass(Duration::from_millis(1));
        (bench, supervisor)
    }

    /// Time passes, the sensors measure, and service does what is due.
    pub fn pass(&self, time: Duration) {
        self.broker.service();
        self.clock.advance(time);
        for (lamp, truth) in self.lamps.iter().zip(&self.truths) {
            let state = if truth.on.load(Ordering::SeqCst) { Power::On } else { Power::Off };
            self.broker.observe(lamp.gate(), Estimate { state, measured_at: self.clock.now() });
        }
        self.broker.service();
    }

    pub fn is_on(&self, lamp: usize) -> bool {
        self.truths[lamp].on.load(Ordering::SeqCst)
    }

    /// What the agent charges, in watts.
    pub fn charged(&self) -> u64 {
        self.broker.margin(self.agent).unwrap().1.get() / 1000
    }
}
