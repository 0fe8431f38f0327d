//! Brokers with their threads: the runtime's, and one with room for 60 000
//! tickets and 64 gates, put together of the same parts.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::{io, mem};

use faregate_agents::{AgentId, Broker, Policy};
use faregate_runtime::broker::{self, Agents as RuntimeAgents};
use faregate_runtime::clock::MonotonicClock;
use faregate_runtime::host::Host;
use faregate_runtime::lanes::Recorder;
use faregate_runtime::wake::Wakeup;
use faregate_tickets::Gate;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::Profile;
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::notify::Notify;
use faregate_tickets::ticket::Issuer;

use crate::plant::{DRAW, Plant, Switch};
use crate::roles::Role;
use crate::support::Failure;

/// Longer than any emergency takes, even on this host.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(5);
const LANE: usize = 4_096;
const DRAIN_EVERY: Duration = Duration::from_millis(20);

/// Names a gate with a switch behind it.
pub(crate) type Handle = faregate_agents::Handle<'static, Switch, Host>;
/// A ticket of a broker `A`.
pub(crate) type Ticket<A> = faregate_tickets::Ticket<'static, Switch, Host, A>;

/// A broker of either kind.
pub(crate) type Agents<N, const G: usize, const T: usize, const S: usize> =
    Broker<'static, Host, N, G, T, S>;

/// What waits for a ticket of a broker `A`.
pub(crate) type Wait<A> = Box<dyn Fn(&Ticket<A>) -> Result<(), Failure>>;

/// A broker that is served, and its devices: the last one is the cutoff valve.
pub(crate) struct Agency<A: Issuer + 'static> {
    pub(crate) agents: &'static A,
    pub(crate) wait: Wait<A>,
    pub(crate) plant: &'static Plant,
    pub(crate) devices: Vec<Handle>,
}

/// The supply suffices for all cameras, and not for the cutoff valve beside
/// them: one has to go.
fn policy(cameras: usize) -> Policy {
    let cameras = u64::try_from(cameras).unwrap_or(u64::MAX);
    Policy::power_margin(faregate_tickets::amount::Milliwatts::new(DRAW.get() * cameras))
}

fn switches(
    plant: &'static Plant,
    cameras: usize,
    profile: Profile,
) -> impl Iterator<Item = (String, Switch)> {
    let gates = (0..).map(GateId).take(cameras + 1);
    gates.map(move |gate| (gate.to_string(), Switch { plant, gate, profile }))
}

/// The runtime's own.
pub(crate) fn runtime(cameras: usize, profile: Profile) -> Result<Agency<RuntimeAgents>, Failure> {
    let plant: &'static Plant = Box::leak(Box::new(Plant::new()?));
    let mut builder = broker::Broker::builder()?;
    let agent = builder.agent(policy(cameras))?;
    let devices = switches(plant, cameras, profile)
        .map(|(name, switch)| builder.gate(agent, &name, switch))
        .collect::<Result<_, _>>()?;
    let broker = builder.real_time(Role::Service.priority()).start()?;
    let agents = broker.agents();
    let wait = Box::new(move |ticket: &Ticket<_>| Ok(broker.wait(ticket, TIMEOUT)?));
    Ok(Agency { agents, wait, plant, devices })
}

/// Room for 60 000 tickets beside those kept for fault responses, and for as
/// many gates as there can be.
pub(crate) type LargeAgents = Agents<&'static Bells, 64, 64_000, 2>;

/// Who serves a broker, beside whoever waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    /// A thread of its own.
    Thread,
    /// Nobody, until somebody brings an estimate.
    Nobody,
}

/// One with room for many.
pub(crate) fn large(
    cameras: usize,
    profile: Profile,
    service: Service,
) -> Result<Agency<LargeAgents>, Failure> {
    let plant: &'static Plant = Box::leak(Box::new(Plant::new()?));
    let bells: &'static Bells = Box::leak(Box::new(Bells::new(service)?));
    let mut recorder = Recorder::new();
    let mut agents = boxed(bells, &mut recorder)?;
    let agent = agents.agent(policy(cameras))?;
    let devices = switches(plant, cameras, profile)
        .map(|(name, switch)| register(&mut agents, agent, &mut recorder, &name, switch))
        .collect::<Result<_, _>>()?;
    // It drains for as long as the bench runs.
    let _ = mem::ManuallyDrop::new(recorder.start(DRAIN_EVERY)?);
    let agents: &'static LargeAgents = Box::leak(agents);
    Role::Service.start(
        "service",
        move || {
            while bells.service.wait_until(agents.service()).is_ok() {}
        },
    )?;
    let wait = Box::new(move |ticket: &Ticket<_>| bells.wait(agents, ticket));
    Ok(Agency { agents, wait, plant, devices })
}

fn register(
    agents: &mut LargeAgents,
    agent: AgentId,
    recorder: &mut Recorder,
    name: &str,
    switch: Switch,
) -> Result<Handle, Failure> {
    let lane = recorder.lane(name, LANE);
    let gate = Box::leak(Box::new(Gate::new(switch, MonotonicClock::new(), lane)));
    Ok(agents.register(agent, gate.key())?)
}

/// The broker is built on a stack of its own: it is tens of megabytes, and
/// moved a few times on its way to the heap.
fn boxed(bells: &'static Bells, recorder: &mut Recorder) -> Result<Box<LargeAgents>, Failure> {
    let lane = recorder.lane("broker", LANE);
    let build = move || Box::new(LargeAgents::new(MonotonicClock::new(), lane, bells));
    let stack = 8 * size_of::<LargeAgents>() + (1 << 20);
    let builder = std::thread::Builder::new().name("builder".into()).stack_size(stack);
    builder.spawn(build)?.join().map_err(|_| "a large broker could not be built".into())
}

/// Bells for the service and for one thread that waits; see the runtime's own
/// `Waiters`, which has them for many.
#[derive(Debug)]
pub(crate) struct Bells {
    serving: Service,
    service: Wakeup,
    waiting: Wakeup,
    /// The seat waited for, counted from 1; 0 for none.
    seat: AtomicUsize,
}

impl Bells {
    fn new(serving: Service) -> io::Result<Self> {
        let [service, waiting] = [Wakeup::new()?, Wakeup::new()?];
        Ok(Self { serving, service, waiting, seat: AtomicUsize::new(0) })
    }

    /// As the runtime's broker waits.
    fn wait(&self, agents: &LargeAgents, ticket: &Ticket<LargeAgents>) -> Result<(), Failure> {
        let clock = MonotonicClock::new();
        let deadline = clock.now().after(TIMEOUT);
        self.seat.store(usize::from(ticket.id().seat) + 1, Ordering::Release);
        let waited = loop {
            let due: Option<Instant> = agents.service();
            match ticket.check() {
                Ok(()) => break Ok(()),
                Err(refusal) if clock.now() >= deadline => break Err(refusal.into()),
                Err(_) => {
                    let until = due.map_or(deadline, |due| due.min(deadline));
                    let _ = self.waiting.wait_until(Some(until))?;
                }
            }
        };
        self.seat.store(0, Ordering::Release);
        waited
    }
}

impl Notify for Bells {
    fn ticket_changed(&self, ticket: TicketId) {
        if self.seat.load(Ordering::Acquire) == usize::from(ticket.seat) + 1 {
            self.waiting.notify();
        }
    }

    fn service_due(&self) {
        if self.serving == Service::Thread {
            self.service.notify();
        }
    }
}
