//! The broker of a program with threads: put together once, served by a thread
//! of its own, and waited for.
//!
//! All allocation is at construction. Gates and agents live as long as the
//! program does, so tickets can go to any thread.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::{fmt, io};

use faregate_agents::{
    AgentId, Categories, NotYours, Policy, RegisterError, RequestRefused, Supervisor, Waiting,
    Want, Wants,
};
use faregate_tickets::Gate;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::Device;
use faregate_tickets::id::{GateId, Priority, TicketId};
use faregate_tickets::interlock::Member;
use faregate_tickets::lock::Strategy;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use faregate_tickets::telemetry::Telemetry;

use crate::clock::MonotonicClock;
use crate::host::{Host, HostStrategy, Supported};
use crate::lanes::{Draining, Recorder};
use crate::waiters::{TicketChange, Waiters, Watcher};

/// The most gates of a [`Broker`].
pub const GATES: usize = 64;
/// The most tickets of a [`Broker`].
pub const TICKETS: usize = 512;
/// The most all-or-nothing requests of a [`Broker`].
pub const SETS: usize = 64;
/// How many threads are woken when their ticket is valid. More may wait; they look
/// for themselves.
pub const WAITERS: usize = 64;
/// How many records a lane of the flight recorder holds between two drains.
const LANE: usize = 4096;

/// The agents' broker, on a host.
pub type Agents = faregate_agents::Broker<'static, Host, &'static Waiters, GATES, TICKETS, SETS>;

/// A ticket for a device of type `D`, whose gate is entered by `S`.
pub type Ticket<D, S = HostStrategy> = faregate_tickets::Ticket<'static, D, Host<S>, Agents>;

/// Names a gate with a device of type `D` in requests; it is entered by `S`.
pub type Handle<D, S = HostStrategy> = faregate_agents::Handle<'static, D, Host<S>>;

/// Puts a [`Broker`] together.
pub struct Builder {
    agents: Box<Agents>,
    waiters: &'static Waiters,
    watchers: Vec<Watcher>,
    recorder: Recorder,
    priority: Option<u8>,
    drain_every: Duration,
}

/// What a gate has beside its driver.
#[derive(Debug, Default)]
pub struct GateOptions {
    categories: Categories,
    telemetry: Option<&'static Telemetry>,
    interlock: Option<Member<'static>>,
}

impl GateOptions {
    /// Nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Conflict categories.
    #[must_use]
    pub fn categories(mut self, categories: Categories) -> Self {
        self.categories = categories;
        self
    }

    /// State variables that validity functions look at.
    #[must_use]
    pub fn watching(mut self, telemetry: &'static Telemetry) -> Self {
        self.telemetry = Some(telemetry);
        self
    }

    /// A place on one side of an interlock.
    #[must_use]
    pub fn interlocked(mut self, member: Member<'static>) -> Self {
        self.interlock = Some(member);
        self
    }
}

impl Builder {
    /// Adds an agent.
    ///
    /// # Errors
    /// [`RegisterError::NoCapacity`].
    pub fn agent(&mut self, policy: Policy) -> Result<AgentId, RegisterError> {
        self.agents.agent(policy)
    }

    /// Moves a driver behind a gate of this agent. Its lane in the flight
    /// recorder has this name.
    ///
    /// # Errors
    /// [`RegisterError`].
    pub fn gate<D: Device + 'static>(
        &mut self,
        agent: AgentId,
        name: &str,
        driver: D,
    ) -> Result<Handle<D>, RegisterError> {
        self.gate_with(agent, name, driver, GateOptions::new())
    }

    /// Like [`Builder::gate`], with options.
    ///
    /// # Errors
    /// [`RegisterError`].
    pub fn gate_with<D: Device + 'static>(
        &mut self,
        agent: AgentId,
        name: &str,
        driver: D,
        options: GateOptions,
    ) -> Result<Handle<D>, RegisterError> {
        self.place(agent, name, driver, options)
    }

    /// Like [`Builder::gate_with`], for a gate that is entered by another
    /// strategy than the host's own: [`HostFenced`](crate::host::HostFenced) or
    /// [`HostRestartable`](crate::host::HostRestartable).
    ///
    /// # Errors
    /// [`GateBehindError`]: what the host lacks for the strategy, or
    /// [`RegisterError`].
    pub fn gate_behind<S: Supported, D: Device + 'static>(
        &mut self,
        agent: AgentId,
        name: &str,
        driver: D,
        options: GateOptions,
    ) -> Result<Handle<D, S>, GateBehindError> {
        S::check().map_err(GateBehindError::Unsupported)?;
        self.place(agent, name, driver, options).map_err(GateBehindError::Register)
    }

    fn place<S: Strategy, D: Device + 'static>(
        &mut self,
        agent: AgentId,
        name: &str,
        driver: D,
        options: GateOptions,
    ) -> Result<Handle<D, S>, RegisterError> {
        let lane = self.recorder.lane(name, LANE);
        let mut gate = Gate::<D, Host<S>>::new(driver, MonotonicClock::new(), lane);
        if let Some(telemetry) = options.telemetry {
            gate = gate.watching(telemetry);
        }
        if let Some(member) = options.interlock {
            gate = gate.interlocked(member);
        }
        let key = Box::leak(Box::new(gate)).key();
        self.agents.register_with_categories(agent, key, options.categories)
    }

    /// Makes a supervisor of the whole broker.
    pub fn supervisor(&mut self) -> Supervisor {
        self.agents.supervisor()
    }

    /// Makes a supervisor of one agent.
    ///
    /// # Errors
    /// [`NotYours::OtherScope`] for another broker's agent.
    pub fn supervisor_of(&mut self, agent: AgentId) -> Result<Supervisor, NotYours> {
        self.agents.supervisor_of(agent)
    }

    /// Runs the service thread with SCHED_FIFO at this priority (1 to 99),
    /// which belongs above all holders. Whether the host permits it is in
    /// [`Broker::real_time_report`].
    #[must_use]
    pub fn real_time(mut self, priority: u8) -> Self {
        self.priority = Some(priority);
        self
    }

    /// Tells this function of every ticket that became valid, was revoked or
    /// ended: one that watches what others hold. What has become of the ticket
    /// by then, it says itself ([`check`](faregate_tickets::Ticket::check)).
    ///
    /// # Timing
    /// The function is called after all locks are released, by whoever did the
    /// step, a rescuer included: it must not block, and ring a bell at most.
    #[must_use]
    pub fn watch(
        mut self,
        watcher: impl Fn(TicketId, TicketChange) + Send + Sync + 'static,
    ) -> Self {
        self.watchers.push(Box::new(watcher));
        self
    }

    /// Starts the service and recorder threads.
    ///
    /// # Errors
    /// When the host has no thread or file descriptor left.
    pub fn start(self) -> io::Result<Broker> {
        let agents: &'static Agents = Box::leak(self.agents);
        let waiters = self.waiters;
        waiters.told_by(self.watchers);
        let stop = Arc::new(AtomicBool::new(false));
        let draining = self.recorder.start(self.drain_every)?;
        let (tell, told) = std::sync::mpsc::sync_channel(1);
        let (priority, stopping) = (self.priority, Arc::clone(&stop));
        let thread = std::thread::Builder::new().name("faregate-service".into());
        let service = thread.spawn(move || {
            let _ = tell.send(set_up(priority));
            serve(agents, waiters, &stopping);
        })?;
        let report = told.recv().unwrap_or_default();
        let threads = Arc::new(Mutex::new(Some(Threads { service, draining, stop })));
        Ok(Broker { agents, waiters, report, threads, closed: Arc::default() })
    }
}

impl fmt::Debug for Builder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Builder").field("agents", &self.agents).finish_non_exhaustive()
    }
}

/// Why there is no gate behind this strategy.
#[derive(Debug)]
pub enum GateBehindError {
    /// The host lacks what the strategy needs.
    Unsupported(io::Error),
    /// The broker has no place for the gate.
    Register(RegisterError),
}

impl fmt::Display for GateBehindError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unsupported(missing) => missing.fmt(f),
            Self::Register(full) => full.fmt(f),
        }
    }
}

impl std::error::Error for GateBehindError {}

/// What the host permitted of the real-time set-up, in words.
pub type RealTimeReport = Option<String>;

#[cfg(target_os = "linux")]
fn set_up(priority: Option<u8>) -> RealTimeReport {
    let priority = priority?;
    let report = crate::realtime::RealTime::request().fifo(priority).apply();
    Some(report.to_string())
}

#[cfg(not(target_os = "linux"))]
fn set_up(priority: Option<u8>) -> RealTimeReport {
    priority.map(|_| "this host has no real-time scheduling that we know of".into())
}

fn serve(agents: &Agents, waiters: &Waiters, stop: &AtomicBool) {
    // Acquire: pairs with the Release in `Broker::close`.
    while !stop.load(Ordering::Acquire) {
        let due = agents.service();
        waiters.wait_for_service(due);
    }
}

/// The threads behind a broker.
struct Threads {
    service: JoinHandle<()>,
    draining: Draining,
    stop: Arc<AtomicBool>,
}

/// All ticket agents of a program, with their service thread.
///
/// Clones are the same broker. It serves its tickets for as long as the program
/// runs, whoever has a clone; [`close`](Broker::close) ends it before.
#[derive(Clone)]
pub struct Broker {
    agents: &'static Agents,
    waiters: &'static Waiters,
    report: RealTimeReport,
    threads: Arc<Mutex<Option<Threads>>>,
    closed: Arc<AtomicBool>,
}

/// The broker was not closed: tickets are still held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StillHeld {
    /// How many seats are taken.
    pub tickets: usize,
}

impl fmt::Display for StillHeld {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} tickets are still held; drop them first", self.tickets)
    }
}

impl std::error::Error for StillHeld {}

/// Why a wait for a ticket ended without it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotValid {
    /// The time is over; what the ticket waits for, where the books know.
    TimedOut(Option<Waiting>),
    /// The ticket has expired: waiting does not help.
    Expired,
    /// The ticket is another broker's.
    OtherBroker,
}

impl fmt::Display for NotValid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimedOut(Some(waiting)) => write!(f, "not valid in time: {waiting}"),
            Self::TimedOut(None) => f.write_str("not valid in time"),
            Self::Expired => f.write_str("the ticket has expired; request a new one"),
            Self::OtherBroker => f.write_str("the ticket is another broker's"),
        }
    }
}

impl std::error::Error for NotValid {}

impl Broker {
    /// Begins to put a broker together.
    ///
    /// # Errors
    /// When the host has no file descriptor left for the wake-ups, or its
    /// kernel has no locks with priority inheritance.
    pub fn builder() -> io::Result<Builder> {
        crate::host::check()?;
        let waiters: &'static Waiters = Box::leak(Box::new(Waiters::new()?));
        let mut recorder = Recorder::new();
        let lane = recorder.lane("broker", LANE);
        let agents =
            on_a_large_stack(move || Box::new(Agents::new(MonotonicClock::new(), lane, waiters)))?;
        let drain_every = Duration::from_millis(20);
        let watchers = Vec::new();
        Ok(Builder { agents, waiters, watchers, recorder, priority: None, drain_every })
    }

    /// Requests tickets; see [`faregate_agents::Broker::request`].
    ///
    /// # Errors
    /// Only what can never be is refused here.
    ///
    /// # Timing
    /// As [`faregate_agents::Broker::request`], and one system call to wake the
    /// service. Never blocks.
    pub fn request<W>(&self, priority: Priority, wants: &W) -> Result<W::Tickets, RequestRefused>
    where
        W: Wants<'static, 'static, Host, &'static Waiters, GATES, TICKETS, SETS>,
    {
        if self.closed.load(Ordering::SeqCst) {
            return Err(RequestRefused::Unavailable);
        }
        self.agents.request(priority, wants)
    }

    /// Asks for one more gate; see [`faregate_agents::Broker::extend`].
    ///
    /// # Errors
    /// [`RequestRefused`], and everything is as it was.
    ///
    /// # Timing
    /// As [`Broker::request`].
    pub fn extend<D: Device, S: Strategy, E: Device, R: Strategy>(
        &self,
        ticket: &Ticket<D, S>,
        want: &Want<'static, E, Host<R>>,
    ) -> Result<Ticket<E, R>, RequestRefused> {
        self.agents.extend(ticket, want)
    }

    /// Waits until the ticket is valid, and drives the hand-over at the
    /// caller's own priority meanwhile.
    ///
    /// # Errors
    /// [`NotValid`], with what the ticket waits for.
    ///
    /// # Timing
    /// At most `timeout`, and the call of service that is in progress then.
    ///
    /// # After revocation
    /// Waits until the ticket is restored.
    pub fn wait<D: Device, S: Strategy>(
        &self,
        ticket: &Ticket<D, S>,
        timeout: Duration,
    ) -> Result<(), NotValid> {
        if !ticket.is_of(self.agents) {
            return Err(NotValid::OtherBroker);
        }
        let deadline = MonotonicClock::new().now().after(timeout);
        let waiter = self.waiters.register(ticket.id());
        loop {
            if let Some(end) = decided(ticket) {
                return end;
            }
            let due = self.agents.service();
            if let Some(end) = decided(ticket) {
                return end;
            }
            if MonotonicClock::new().now() >= deadline {
                return Err(NotValid::TimedOut(self.agents.waiting_for(ticket.id())));
            }
            let until = due.map_or(deadline, |due| due.min(deadline));
            self.waiters.wait(waiter.as_ref(), until);
        }
    }

    /// What the sensors say about a device; see
    /// [`faregate_agents::Broker::observe`].
    ///
    /// # Timing
    /// As [`faregate_agents::Broker::observe`], and one system call.
    pub fn observe(&self, gate: GateId, estimate: faregate_tickets::device::Estimate) {
        self.agents.observe(gate, estimate);
    }

    /// Ends the service and the recorder, after a last drain. Every ticket must
    /// have gone: one without service would outlive its limits. From then on
    /// requests are refused.
    ///
    /// # Errors
    /// [`StillHeld`], and the broker goes on.
    ///
    /// # Timing
    /// Waits for both threads: for the end of a program.
    pub fn close(&self) -> Result<(), StillHeld> {
        // SeqCst: a request that does not see this has its ticket counted.
        self.closed.store(true, Ordering::SeqCst);
        self.agents.service();
        let tickets = self.agents.free_seats().map_or(0, |free| TICKETS - free);
        if tickets > 0 {
            self.closed.store(false, Ordering::SeqCst);
            return Err(StillHeld { tickets });
        }
        let threads = self.threads.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(Threads { service, draining, stop }) = threads {
            stop.store(true, Ordering::Release);
            self.waiters.wake_service();
            // They have nothing to say, and a panic in one was printed.
            let _ = (service.join(), draining.stop());
        }
        Ok(())
    }

    /// The agents themselves: supplies, supervision, reports, bounds.
    #[must_use]
    pub fn agents(&self) -> &'static Agents {
        self.agents
    }

    /// What the host permitted, if real-time service was asked for.
    #[must_use]
    pub fn real_time_report(&self) -> Option<&str> {
        self.report.as_deref()
    }

    /// The broker's clock, by which estimates are dated.
    #[must_use]
    pub fn clock(&self) -> MonotonicClock {
        MonotonicClock::new()
    }
}

/// The broker is large, and made by value: a thread with a small stack could not
/// begin to put one together.
fn on_a_large_stack<R: Send + 'static>(make: impl FnOnce() -> R + Send + 'static) -> io::Result<R> {
    let thread = std::thread::Builder::new().stack_size(16 * size_of::<Agents>());
    let made = thread.spawn(make)?.join();
    made.map_err(|_| io::Error::other("the broker could not be put together"))
}

/// Whether waiting for the ticket is over.
fn decided<D: Device, S: Strategy>(ticket: &Ticket<D, S>) -> Option<Result<(), NotValid>> {
    match ticket.check() {
        Ok(()) => Some(Ok(())),
        Err(Refusal::NotValid(Why::Expired)) => Some(Err(NotValid::Expired)),
        Err(_) => None,
    }
}

impl fmt::Debug for Broker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Broker").field("agents", &self.agents).finish_non_exhaustive()
    }
}
