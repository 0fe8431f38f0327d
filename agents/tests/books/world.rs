//! The world: who holds what, by a record of our own.

use std::collections::BTreeMap;

use faregate_agents::{Books, Categories, DeviceState, Done, Policy, Work};
use faregate_tickets::Gate;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Estimate, Profile, WhenOrphaned};
use faregate_tickets::gate::{Handle, Key};
use faregate_tickets::id::{GateId, Priority, TicketId};
use faregate_tickets::recorder::NoLane;
use faregate_tickets::scope::{Scope, Seen};
use faregate_tickets::standing::Standing;
use faregate_tickets::ticket::{Issuer, Seat};

use super::lamp::{Hands, Lamp, Platform, Truth};

pub(crate) const GATES: usize = 4;
pub(crate) const SEATS: usize = 8;
pub(crate) const SETS: usize = 3;
pub(crate) const ENERGY: Microjoules = Microjoules::new(1_000);
pub(crate) type TestBooks = Books<GATES, SEATS, SETS>;
pub(crate) type Ticket<'w> = faregate_tickets::Ticket<'w, Lamp<'w>, Platform<'w>, Nobody>;

/// Tickets are relinquished by the history, not by being dropped.
#[derive(Debug)]
pub(crate) struct Nobody;

impl Issuer for Nobody {
    fn relinquish(
        &self,
        _: &Seat<'_>,
        _: faregate_tickets::recorder::Unrecorded,
        _: faregate_tickets::ticket::Holder,
    ) {
    }
}

/// What a world is made of, printed with one part on a line.
#[derive(Clone)]
pub(crate) struct Setup {
    pub(crate) agents: Vec<Rules>,
    pub(crate) devices: Vec<Declared>,
}

impl std::fmt::Debug for Setup {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.agents.iter().try_for_each(|agent| write!(f, "\n  {agent:?},"))?;
        self.devices.iter().try_for_each(|device| write!(f, "\n  {device:?},"))
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rules {
    pub(crate) exclusive: bool,
    pub(crate) supply: Option<u64>,
    pub(crate) categories: bool,
    pub(crate) energy: bool,
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Declared {
    pub(crate) agent: u8,
    pub(crate) draw: u64,
    pub(crate) categories: u8,
    pub(crate) settling_ms: u64,
    pub(crate) attempts: u8,
    pub(crate) safe_at_once: bool,
    pub(crate) safe_unless_held: bool,
    pub(crate) on_at_start: bool,
}

impl Rules {
    fn policy(self) -> Policy {
        let mut policy = Policy::unlimited();
        if self.exclusive {
            policy = policy.with_exclusion();
        }
        if let Some(supply) = self.supply {
            policy = policy.with_power_margin(Milliwatts::new(supply));
        }
        if self.categories {
            policy = policy.with_categories();
        }
        if self.energy {
            policy = policy.with_energy(ENERGY);
        }
        policy
    }
}

impl Declared {
    pub(crate) fn profile(self) -> Profile {
        let mut profile = Profile::new().drawing(Milliwatts::new(self.draw));
        profile.settling = Duration::from_millis(self.settling_ms);
        profile.estimate_lag = Duration::from_millis(10);
        profile.safing_attempts = self.attempts;
        if self.safe_at_once {
            profile.when_orphaned = WhenOrphaned::SafeAtOnce;
        }
        if self.safe_unless_held {
            profile.when_orphaned = WhenOrphaned::SafeUnlessHeld;
        }
        profile
    }
}

/// What does not move while the world does.
pub(crate) struct Ground {
    pub(crate) setup: Setup,
    pub(crate) clock: Hands,
    pub(crate) truths: Vec<Truth>,
    pub(crate) broker: Scope,
    pub(crate) scopes: Vec<Scope>,
    pub(crate) standings: Vec<Standing>,
}

impl Ground {
    pub(crate) fn new(setup: Setup) -> Self {
        let truths = setup.devices.iter().map(|it| Truth::new(it.profile(), it.on_at_start));
        Self {
            clock: Hands::default(),
            truths: truths.collect(),
            broker: Scope::new(),
            scopes: setup.agents.iter().map(|_| Scope::new()).collect(),
            standings: (0..SEATS).map(|_| Standing::new()).collect(),
            setup,
        }
    }

    pub(crate) fn gates(&self) -> Vec<Gate<'_, Lamp<'_>, Platform<'_>>> {
        let lamp = |truth| Lamp { truth, clock: &self.clock };
        self.truths.iter().map(|truth| Gate::new(lamp(truth), &self.clock, NoLane)).collect()
    }
}

/// A grant as we know it.
#[derive(Debug)]
pub(crate) struct Granted<'w> {
    pub(crate) id: TicketId,
    pub(crate) priority: u8,
    pub(crate) arrival: u64,
    pub(crate) barred: bool,
    pub(crate) resting: bool,
    pub(crate) exempt: bool,
    pub(crate) has_budget: bool,
    /// Where one gate was asked for with a limit on use.
    pub(crate) on_commands_left: Option<(GateId, u32)>,
    pub(crate) tickets: Vec<(GateId, Ticket<'w>)>,
}

impl Granted<'_> {
    pub(crate) fn gates(&self) -> impl Iterator<Item = usize> {
        self.tickets.iter().map(|(gate, _)| usize::from(gate.0))
    }
}

pub(crate) struct World<'w> {
    pub(crate) ground: &'w Ground,
    pub(crate) keys: Vec<Key<'w>>,
    handles: Vec<Handle<'w, Lamp<'w>, Platform<'w>>>,
    pub(crate) books: TestBooks,
    pub(crate) noticed: Vec<Seen>,
    pub(crate) grants: BTreeMap<usize, Granted<'w>>,
    /// What is declared of each device now.
    pub(crate) declared: Vec<Declared>,
    pub(crate) arrivals: u64,
    pub(crate) supply: Vec<u64>,
    /// By our own account: nobody can free these.
    pub(crate) stuck: Vec<bool>,
    pub(crate) faults: Vec<bool>,
    /// Measured, and not reported yet.
    pub(crate) late_estimates: Vec<(GateId, Estimate)>,
    /// Done, and not reported yet.
    pub(crate) unreported: Vec<Done>,
    /// Offered once, and not done then.
    pub(crate) late_work: Vec<Work>,
    pub(crate) budget_used: bool,
    /// A sensor shows on what nobody was given.
    pub(crate) unbidden_seen: bool,
    /// Tenants and charges, as they were after the last step.
    pub(crate) tenants: Vec<Option<TicketId>>,
    pub(crate) charged: Vec<u64>,
    pub(crate) charged_before: Vec<u64>,
    pub(crate) changes: usize,
}

impl<'w> World<'w> {
    pub(crate) fn new(
        ground: &'w Ground,
        gates: &'w mut [Gate<'w, Lamp<'w>, Platform<'w>>],
    ) -> Self {
        let mut books = TestBooks::new(Instant::START);
        for rules in &ground.setup.agents {
            books.add_agent(rules.policy()).unwrap();
        }
        for device in &ground.setup.devices {
            let categories = Categories::from_mask(device.categories.into());
            books.add_gate(device.agent, device.profile(), categories).unwrap();
        }
        let (mut keys, mut handles) = (Vec::new(), Vec::new());
        for gate in gates {
            let (key, handle) = gate.key().split();
            keys.push(key);
            handles.push(handle);
        }
        let agents = ground.setup.agents.len();
        let supply = ground.setup.agents.iter().map(|rules| rules.supply.unwrap_or(0));
        let mut world = Self {
            ground,
            keys,
            handles,
            books,
            noticed: Vec::new(),
            grants: BTreeMap::new(),
            declared: ground.setup.devices.clone(),
            arrivals: 0,
            supply: supply.collect(),
            stuck: vec![false; GATES],
            faults: vec![false; GATES],
            late_estimates: Vec::new(),
            unreported: Vec::new(),
            late_work: Vec::new(),
            budget_used: false,
            unbidden_seen: false,
            tenants: vec![None; GATES],
            charged: vec![0; agents],
            charged_before: vec![0; agents],
            changes: 0,
        };
        world.noticed = world.scopes();
        world.charged = world.charges();
        world
    }

    pub(crate) fn now(&self) -> Instant {
        self.ground.clock.now()
    }

    pub(crate) fn gate_ids(&self) -> impl Iterator<Item = GateId> + use<> {
        (0..self.ground.truths.len()).map(|gate| GateId(u8::try_from(gate).unwrap()))
    }

    pub(crate) fn declared(&self, gate: usize) -> Declared {
        self.declared[gate]
    }

    pub(crate) fn rules(&self, agent: usize) -> &'w Rules {
        &self.ground.setup.agents[agent]
    }

    /// The broker's epoch and floor, then the agents'.
    pub(crate) fn scopes(&self) -> Vec<Seen> {
        let scopes = std::iter::once(&self.ground.broker).chain(&self.ground.scopes);
        scopes.map(Scope::read).collect()
    }

    pub(crate) fn charges(&self) -> Vec<u64> {
        let agents = 0..u8::try_from(self.ground.setup.agents.len()).unwrap();
        agents.map(|agent| self.books.charged(agent).get()).collect()
    }

    pub(crate) fn state(&self, gate: usize) -> DeviceState {
        self.books.device_report(GateId(u8::try_from(gate).unwrap())).unwrap().state
    }

    /// Whether supervisors have done something that the books do not know.
    pub(crate) fn is_noticed(&self) -> bool {
        !self.ground.broker.has_bars() && self.noticed == self.scopes()
    }

    pub(crate) fn ticket(&self, id: TicketId, gate: GateId) -> Ticket<'w> {
        let number = usize::from(gate.0);
        let seat = Seat {
            id,
            gate,
            standing: &self.ground.standings[usize::from(id.seat)],
            agent: &self.ground.scopes[usize::from(self.declared(number).agent)],
            broker: &self.ground.broker,
        };
        self.keys[number].ticket(self.handles[number], seat, &Nobody).unwrap()
    }

    /// The grant that a number picks, if there is any.
    pub(crate) fn pick(&self, number: u8) -> Option<usize> {
        let serials: Vec<_> = self.grants.keys().copied().collect();
        (!serials.is_empty()).then(|| serials[usize::from(number) % serials.len()])
    }

    pub(crate) fn priority(level: u8) -> Priority {
        Priority::new(level)
    }
}
