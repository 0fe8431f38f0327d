//! A bench of lamps: devices whose truth the test sets, on a clock whose hands
//! the test moves, with a flight recorder that the test can read.
#![allow(dead_code, unused_imports, reason = "each promise uses its own part of the bench")]

mod lamp;
mod tape;

use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};

use faregate_agents::{AgentId, Broker, Categories, Handle, Policy, Supervisor, Waiting};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Estimate, Power, Profile};
use faregate_tickets::gate::KeyOf;
use faregate_tickets::id::TicketId;
use faregate_tickets::lock::Locked;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::platform::{Containment, Panicked, Uncontained};
use faregate_tickets::{Gate, Platform as Ports};

pub(crate) use lamp::{Lamp, Switch, Truth};
pub(crate) use tape::Tape;

/// A platform with a readable recorder, and this containment.
#[derive(Debug)]
pub(crate) struct Rig<C>(PhantomData<C>);

impl<C: Containment> Ports for Rig<C> {
    type Strategy = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;
    type Clock = &'static Hands;
    type Lane = &'static Tape;
    type Containment = C;
}

/// Turns a driver's panic into a value.
#[derive(Debug)]
pub(crate) struct Caught;

impl Containment for Caught {
    fn contain<R>(f: impl FnOnce() -> R) -> Result<R, Panicked> {
        catch_unwind(AssertUnwindSafe(f)).map_err(|_| Panicked)
    }
}

pub(crate) type Platform = Rig<Caught>;
pub(crate) type Bare = Rig<Uncontained>;
pub(crate) type TestBroker = Broker<'static, Platform, NoNotify, 4, 8, 2>;
pub(crate) type Ticket = faregate_tickets::Ticket<'static, Lamp, Platform, TestBroker>;
pub(crate) type LampHandle = Handle<'static, Lamp, Platform>;

/// A clock whose hands the test moves.
#[derive(Debug, Default)]
pub(crate) struct Hands(AtomicU64);

impl Clock for Hands {
    fn now(&self) -> Instant {
        Instant::from_micros(self.0.load(Ordering::SeqCst))
    }
}

impl Hands {
    pub(crate) fn advance(&self, by: Duration) {
        self.0.fetch_add(by.as_micros(), Ordering::SeqCst);
    }

    pub(crate) fn go_back(&self, by: Duration) {
        self.0.fetch_sub(by.as_micros(), Ordering::SeqCst);
    }
}

pub(crate) const TICK: Duration = Duration::from_millis(1);

pub(crate) const fn watts(watts: u32) -> Milliwatts {
    Milliwatts::from_watts(watts)
}

pub(crate) fn margin(supply: u32) -> Policy {
    Policy::power_margin(watts(supply))
}

/// What is declared of a lamp that draws so many watts.
pub(crate) fn drawing(draw: u32) -> Profile {
    Profile::new().drawing(watts(draw))
}

pub(crate) fn leak<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

/// A bench while it is put together.
pub(crate) struct Kit {
    pub(crate) broker: Box<TestBroker>,
    pub(crate) clock: &'static Hands,
    pub(crate) tape: &'static Tape,
    pub(crate) lamps: Vec<LampHandle>,
    pub(crate) truths: Vec<&'static Truth>,
    pub(crate) tapes: Vec<&'static Tape>,
}

impl Kit {
    pub(crate) fn new() -> Self {
        let clock: &'static Hands = leak(Hands::default());
        let tape: &'static Tape = leak(Tape::default());
        let broker = Box::new(TestBroker::new(clock, tape, NoNotify));
        Self { broker, clock, tape, lamps: vec![], truths: vec![], tapes: vec![] }
    }

    pub(crate) fn agent(&mut self, policy: Policy) -> AgentId {
        self.broker.agent(policy).unwrap()
    }

    /// A gate with a lamp behind it, and the lamp's truth.
    pub(crate) fn gate<C: Containment>(
        &self,
        profile: Profile,
    ) -> (Gate<'static, Lamp, Rig<C>>, &'static Truth, &'static Tape) {
        let truth: &'static Truth = leak(Truth::default());
        let tape: &'static Tape = leak(Tape::default());
        (Gate::new(Lamp::new(truth, profile), self.clock, tape), truth, tape)
    }

    pub(crate) fn lamp(&mut self, agent: AgentId, profile: Profile) {
        self.fitted(agent, profile, Categories::NONE, |gate| gate);
    }

    /// A lamp whose gate is fitted with something more.
    pub(crate) fn fitted(
        &mut self,
        agent: AgentId,
        profile: Profile,
        categories: Categories,
        fit: impl FnOnce(Gate<'static, Lamp, Platform>) -> Gate<'static, Lamp, Platform>,
    ) {
        let (gate, truth, tape) = self.gate(profile);
        let key: KeyOf<'static, Lamp, Platform> = leak(fit(gate)).key();
        let lamp = self.broker.register_with_categories(agent, key, categories).unwrap();
        self.lamps.push(lamp);
        self.truths.push(truth);
        self.tapes.push(tape);
    }

    /// The bench, its devices seen off.
    pub(crate) fn finish(mut self, agent: AgentId) -> (Bench, Supervisor) {
        let supervisor = self.broker.supervisor();
        let Self { broker, clock, tape, lamps, truths, tapes } = self;
        let bench = Bench { broker: Box::leak(broker), agent, clock, tape, lamps, truths, tapes };
        bench.pass(TICK);
        (bench, supervisor)
    }
}

pub(crate) struct Bench {
    pub(crate) broker: &'static TestBroker,
    pub(crate) agent: AgentId,
    pub(crate) clock: &'static Hands,
    /// The broker's own lane.
    pub(crate) tape: &'static Tape,
    pub(crate) lamps: Vec<LampHandle>,
    pub(crate) truths: Vec<&'static Truth>,
    /// The gates' lanes.
    pub(crate) tapes: Vec<&'static Tape>,
}

impl Bench {
    /// One agent's lamps that draw so many watts, seen off at the start.
    pub(crate) fn new(policy: Policy, watts: &[u32]) -> (Self, Supervisor) {
        let profiles: Vec<Profile> = watts.iter().map(|watts| drawing(*watts)).collect();
        Self::with(policy, &profiles)
    }

    /// One agent's lamps of which this is declared.
    pub(crate) fn with(policy: Policy, profiles: &[Profile]) -> (Self, Supervisor) {
        let mut kit = Kit::new();
        let agent = kit.agent(policy);
        for profile in profiles {
            kit.lamp(agent, *profile);
        }
        kit.finish(agent)
    }

    /// Time passes, the sensors measure, and service does what is due.
    pub(crate) fn pass(&self, time: Duration) {
        self.broker.service();
        self.clock.advance(time);
        for lamp in 0..self.lamps.len() {
            self.measure(lamp);
        }
        self.broker.service();
    }

    /// The sensors measure one lamp, now.
    pub(crate) fn measure(&self, lamp: usize) {
        let state = if self.is_on(lamp) { Power::On } else { Power::Off };
        self.report(lamp, state, self.clock.now());
    }

    pub(crate) fn report(&self, lamp: usize, state: Power, measured_at: Instant) {
        self.broker.observe(self.lamps[lamp].gate(), Estimate { state, measured_at });
    }

    pub(crate) fn is_on(&self, lamp: usize) -> bool {
        self.truths[lamp].on.load(Ordering::SeqCst)
    }

    pub(crate) fn commands(&self, lamp: usize) -> usize {
        self.truths[lamp].commands.load(Ordering::SeqCst)
    }

    /// What the agent charges, in watts.
    pub(crate) fn charged(&self) -> u64 {
        self.broker.margin(self.agent).unwrap().1.get() / 1000
    }

    pub(crate) fn free_seats(&self) -> usize {
        self.broker.books().unwrap().free_seats()
    }

    pub(crate) fn waits(&self, ticket: TicketId) -> Option<Waiting> {
        self.broker.waiting_for(ticket)
    }

    /// A ticket for a lamp, after service.
    pub(crate) fn ticket(&self, level: u8, lamp: usize) -> Ticket {
        let priority = faregate_tickets::id::Priority::new(level);
        let ticket = self.broker.request(priority, &self.lamps[lamp]).unwrap();
        self.broker.service();
        ticket
    }
}
