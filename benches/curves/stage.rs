//! What the curves are measured on: lamps of one store each behind gates, on a
//! clock that stands still, so that a run differs from the next in its size
//! alone.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use faregate_agents::{AgentId, Broker, Categories, Handle, Policy, Supervisor};
use faregate_runtime::host::HostStrategy;
use faregate_tickets::Gate;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Device, Effect, Estimate, Power, Profile};
use faregate_tickets::id::Priority;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;

/// The ports of every gate and broker here. Nobody is woken and nothing is
/// recorded: what is left is the work itself.
pub(crate) type Ports = (HostStrategy, &'static Hand, NoLane);
/// A broker with room for so many tickets.
pub(crate) type Agents<const T: usize> = Broker<'static, Ports, NoNotify, 64, T, 2>;
pub(crate) type Lamps = Vec<Handle<'static, Lamp, Ports>>;
pub(crate) type Ticket<const T: usize> = faregate_tickets::Ticket<'static, Lamp, Ports, Agents<T>>;

/// Seats of the largest broker. A sixteenth is kept for fault responses, which
/// leaves the [`TICKETS`] that others can have.
pub(crate) const SEATS: usize = 64_000;
/// As many tickets as the curves go to.
pub(crate) const TICKETS: usize = 60_000;

/// What each lamp draws.
pub(crate) const DRAW: Milliwatts = Milliwatts::from_watts(1);

/// A clock with one hand, which is moved by hand.
#[derive(Debug, Default)]
pub(crate) struct Hand(AtomicU64);

impl Clock for Hand {
    fn now(&self) -> Instant {
        Instant::from_micros(self.0.load(Ordering::Relaxed))
    }
}

impl Hand {
    pub(crate) fn tick(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// What is behind a gate: a register, and how often it was made safe.
#[derive(Debug, Default)]
pub(crate) struct Register {
    pub(crate) on: AtomicUsize,
    pub(crate) safed: AtomicUsize,
}

/// A device whose command is one store.
#[derive(Debug)]
pub(crate) struct Lamp(&'static Register);

impl Device for Lamp {
    type Command = bool;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        // The clock stands still, so no lease runs out between two ticks.
        Profile { lease: Duration::from_secs(1 << 20), ..Profile::new() }.drawing(DRAW)
    }

    fn declare(on: &bool) -> Declaration {
        let effect = if *on { Effect::on(DRAW) } else { Effect::Off };
        Declaration { code: (*on).into(), wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, on: bool) -> Result<(), ()> {
        self.0.on.store(on.into(), Ordering::Relaxed);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.0.safed.fetch_add(1, Ordering::Relaxed);
        self.issue(false)
    }
}

pub(crate) fn leak<V>(value: V) -> &'static mut V {
    Box::leak(Box::new(value))
}

/// A gate with a lamp behind it, and the lamp's register.
pub(crate) fn gate(hand: &'static Hand) -> (Gate<'static, Lamp, Ports>, &'static Register) {
    let register: &'static Register = leak(Register::default());
    (Gate::new(Lamp(register), hand, NoLane), register)
}

/// A broker with one agent and its lamps, all seen off.
pub(crate) struct Stage<const T: usize> {
    pub(crate) agents: &'static Agents<T>,
    pub(crate) supervisor: Supervisor,
    pub(crate) hand: &'static Hand,
    pub(crate) lamps: Lamps,
    pub(crate) registers: Vec<&'static Register>,
}

impl<const T: usize> Stage<T> {
    /// As many lamps as this, under this policy.
    pub(crate) fn new(gates: usize, policy: Policy) -> Self {
        let hand: &'static Hand = leak(Hand::default());
        let mut agents = boxed::<T>(hand);
        let agent = agents.agent(policy).expect("a new broker has room for an agent");
        let built = (0..gates).map(|number| lamp(&mut agents, agent, hand, number));
        let (lamps, registers) = built.unzip();
        let supervisor = agents.supervisor();
        let stage = Self { agents: Box::leak(agents), supervisor, hand, lamps, registers };
        stage.see_off();
        stage
    }

    /// A stage with this many tickets, in turn over the gates, from the most
    /// important to the least and again; the first of each gate is valid.
    pub(crate) fn crowded(gates: usize, policy: Policy, tickets: usize) -> (Self, Vec<Ticket<T>>) {
        let stage = Self::new(gates, policy);
        // One level between two others, so that a small crowd has it too.
        let levels = (1..=Priority::ENGINEERING.level()).rev().step_by(32).cycle();
        let lamps = stage.lamps.iter().cycle();
        let asked = lamps.zip(levels).take(tickets).map(|(lamp, level)| {
            stage.agents.request(Priority::new(level), lamp).expect("there are seats for all")
        });
        let tickets = asked.collect();
        stage.serve();
        (stage, tickets)
    }

    /// Serves until nothing is due.
    pub(crate) fn serve(&self) {
        while self.agents.service().is_some_and(|due| due <= self.hand.now()) {}
    }

    /// Time passes, and the sensors see every lamp off.
    pub(crate) fn see_off(&self) {
        self.serve();
        self.hand.tick();
        self.hand.tick();
        for lamp in &self.lamps {
            let estimate = Estimate { state: Power::Off, measured_at: self.hand.now() };
            self.agents.observe(lamp.gate(), estimate);
        }
        self.serve();
    }
}

/// A broker on the heap. It is built on a stack of its own: the largest is
/// tens of megabytes, and moved a few times on its way.
fn boxed<const T: usize>(hand: &'static Hand) -> Box<Agents<T>> {
    let stack = 8 * size_of::<Agents<T>>() + (1 << 20);
    let build = move || Box::new(Agents::new(hand, NoLane, NoNotify));
    let builder = std::thread::Builder::new().name("builder".into()).stack_size(stack);
    let built = builder.spawn(build).map(std::thread::JoinHandle::join);
    built.expect("the host has a thread left").expect("a broker can be built")
}

/// Lamps conflict with nobody, but each has a category that has to be looked at.
fn lamp<const T: usize>(
    agents: &mut Agents<T>,
    agent: AgentId,
    hand: &'static Hand,
    number: usize,
) -> (Handle<'static, Lamp, Ports>, &'static Register) {
    let (gate, register) = gate(hand);
    let category = Categories::from_mask(1 << (number % 128));
    let key = leak(gate).key();
    let handle = agents.register_with_categories(agent, key, category);
    (handle.expect("a broker has room for 64 gates"), register)
}
