//! A broker with two lamps on one supply, and what is true of them.

use std::sync::atomic::{AtomicU32, Ordering as Plain};

use faregate_agents::{AgentId, Broker, Handle, Policy, Supervisor};
use faregate_tickets::Gate;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Clock;
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::id::Priority;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;
use loom::sync::atomic::{AtomicUsize, Ordering};

use crate::lamp::{Given, Lamp, Loomed, Ticks};
use crate::model::keep;

pub(crate) type TestBroker = Broker<'static, Loomed, NoNotify, 2, 4, 2>;
pub(crate) type Ticket = faregate_tickets::Ticket<'static, Lamp, Loomed, TestBroker>;

/// A broker that is put together, and its lamps, all seen off.
pub(crate) struct Flight {
    pub(crate) broker: &'static TestBroker,
    pub(crate) supervisor: Supervisor,
    pub(crate) agent: AgentId,
    pub(crate) lamps: [Handle<'static, Lamp, Loomed>; 2],
    pub(crate) bus: &'static Bus,
    clock: &'static Ticks,
}

impl Flight {
    /// Lamps of so many watts, on a supply of so many.
    pub(crate) fn new(supply: u32, watts: [u32; 2]) -> &'static Self {
        let clock: &'static Ticks = keep(Ticks::default());
        let bus: &'static Bus = keep(Bus::new(watts));
        let broker = keep(TestBroker::new(clock, NoLane, NoNotify));
        let policy = Policy::power_margin(Milliwatts::from_watts(supply));
        let agent = broker.agent(policy).expect("room for an agent");
        let lamps = [0, 1].map(|lamp| {
            let driver = Lamp::new(watts[lamp], move |given| bus.take(lamp, given));
            let gate = keep(Gate::new(driver, clock, NoLane));
            broker.register(agent, gate.key()).expect("room for a gate")
        });
        let supervisor = broker.supervisor();
        let flight = keep(Self { broker, supervisor, agent, lamps, bus, clock });
        flight.pass();
        flight
    }

    /// A ticket for a lamp, as it is requested.
    pub(crate) fn request(&self, priority: Priority, lamp: usize) -> Ticket {
        self.broker.request(priority, &self.lamps[lamp]).expect("it fits the supply")
    }

    /// A ticket for a lamp, valid.
    pub(crate) fn granted(&self, priority: Priority, lamp: usize) -> Ticket {
        let ticket = self.request(priority, lamp);
        self.broker.service();
        assert_eq!(ticket.check(), Ok(()), "there is room for it");
        ticket
    }

    /// What the sensors say now.
    pub(crate) fn measure(&self, lamp: usize) -> Estimate {
        let state = if self.bus.is_on(lamp) { Power::On } else { Power::Off };
        Estimate { state, measured_at: self.clock.now() }
    }

    /// The sensors measure a lamp, and the broker hears of it.
    pub(crate) fn observe(&self, lamp: usize) {
        self.broker.observe(self.lamps[lamp].gate(), self.measure(lamp));
    }

    /// One period of the service: what is due, what the sensors say, and what
    /// follows from it.
    pub(crate) fn pass(&self) {
        self.broker.service();
        for lamp in 0..self.lamps.len() {
            self.observe(lamp);
        }
        self.broker.service();
    }

    /// What is charged, in watts.
    pub(crate) fn charged(&self) -> u64 {
        let (_, charged) = self.broker.margin(self.agent).expect("the agent has a margin");
        charged.get() / 1000
    }
}

/// The supply line: which lamps are on, whatever anybody thinks.
///
/// Its operations are Relaxed: hardware orders nothing for the software. They
/// are all read-modify-writes: hardware has no old values either.
#[derive(Debug)]
pub(crate) struct Bus {
    watts: [u32; 2],
    lit: AtomicUsize,
    /// The largest draw ever. Kept here, and judged by the model: a driver that
    /// panicked would be contained.
    peak: AtomicU32,
    /// How many safing commands each lamp does not hear.
    pub(crate) deaf: [AtomicU32; 2],
}

impl Bus {
    fn new(watts: [u32; 2]) -> Self {
        let [first, second] = [(); 2].map(|()| AtomicU32::new(0));
        Self { watts, lit: AtomicUsize::new(0), peak: AtomicU32::new(0), deaf: [first, second] }
    }

    fn take(&self, lamp: usize, given: Given) {
        let bit = 1 << lamp;
        match given {
            Given::Turned => {}
            Given::On => {
                let lit = self.lit.fetch_or(bit, Ordering::Relaxed) | bit;
                self.peak.fetch_max(self.draw(lit), Plain::Relaxed);
            }
            Given::Safe if self.does_not_hear(lamp) => {}
            Given::Off | Given::Safe => {
                self.lit.fetch_and(!bit, Ordering::Relaxed);
            }
        }
    }

    fn does_not_hear(&self, lamp: usize) -> bool {
        let less = |left: u32| left.checked_sub(1);
        self.deaf[lamp].fetch_update(Plain::Relaxed, Plain::Relaxed, less).is_ok()
    }

    fn draw(&self, lit: usize) -> u32 {
        let on = |lamp: &usize| lit & (1 << lamp) != 0;
        (0..2).filter(on).map(|lamp| self.watts[lamp]).sum()
    }

    pub(crate) fn is_on(&self, lamp: usize) -> bool {
        self.lit.fetch_or(0, Ordering::Relaxed) & (1 << lamp) != 0
    }

    /// The largest draw there ever was, in watts.
    pub(crate) fn peak(&self) -> u32 {
        self.peak.load(Plain::Relaxed)
    }
}
