//! The world: who holds what, by a record of our own.

use std::collections::BTreeMap;

use faregate_agents::{Books, Categories, Done, Policy, Work};
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

pub const GATES: usize = 5;
pub const SEATS: usize = 8;
pub const SETS: usize = 3;
pub const ENERGY: Microjoules = Microjoules::new(1_000);
pub type TestBooks = Books<GATES, SEATS, SETS>;
pub type Ticket<'w> = faregate_tickets::Ticket<'w, Lamp<'w>, Platform<'w>, Nobody>;

/// Tickets are relinquished by the history, not by being dropped.
#[derive(Debug)]
pub struct Nobody;

impl Issuer for Nobody {
    fn relinquish(&self, _: &Seat<'_>, _: u32) {}
}

/// What a world is made of, printed with one part on a line.
#[derive(Clone)]
pub struct Setup {
    pub agents: Vec<Rules>,
    pub devices: Vec<Declared>,
}

impl std::fmt::Debug for Setup {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.agents.iter().try_for_each(|agent| write!(f, "\n  {agent:?},"))?;
        self.devices.iter().try_for_each(|device| write!(f, "\n  {device:?},"))
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Rules {
    pub exclusive: bool,
    pub supply: Option<u64>,
    pub categories: bool,
    pub energy: bool,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Declared {
    pub agent: u8,
    pub draw: u64,
    pub categories: u8,
    pub settling_ms: u64,
    pub attempts: u8,
    pub safe_at_once: bool,
    pub on_at_start: bool,
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
    pub fn profile(self) -> Profile {
        let mut profile = Profile::new().drawing(Milliwatts::new(self.draw));
        profile.settling = Duration::from_millis(self.settling_ms);
        profile.estimate_lag = Duration::from_millis(10);
        profile.safing_attempts = self.attempts;
        if self.safe_at_once {
            profile.when_orphaned = WhenOrphaned::SafeAtOnce;
        }
        profile
    }
}

/// What does not move while the world does.
pub struct Ground {
    pub setup: Setup,
    pub clock: Hands,
    pub truths: Vec<Truth>,
    pub broker: Scope,
    pub scopes: Vec<Scope>,
    pub standings: Vec<Standing>,
}

impl Ground {
    pub fn new(setup: Setup) -> Self {
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

    pub fn gates(&self) -> Vec<Gate<'_, Lamp<'_>, Platform<'_>>> {
        let lamp = |truth| Lamp { truth, clock: &self.clock };
        self.truths.iter().map(|truth| Gate::new(lamp(truth), &self.clock, NoLane)).collect()
    }
}

/// A grant as we know it.
#[derive(Debug)]
pub struct Granted<'w> {
    pub id: TicketId,
    pub priority: u8,
    pub arrival: u64,
    pub barred: bool,
    pub resting: bool,
    pub exempt: bool,
    pub has_budget: bool,
    /// Where one gate was asked for with a limit on use.
    pub on_commands_left: Option<(GateId, u32)>,
    pub tickets: Vec<(GateId, Ticket<'w>)>,
}

impl Granted<'_> {
    pub fn gates(&self) -> impl Iterator<Item = usize> {
        self.tickets.iter().map(|(gate, _)| usize::from(gate.0))
    }
}

pub struct World<'w> {
    pub ground: &'w Ground,
    pub keys: Vec<Key<'w>>,
    handles: Vec<Handle<'w, Lamp<'w>, Platform<'w>>>,
    pub books: TestBooks,
    pub bars_seen: usize,
    pub noticed: Vec<Seen>,
    pub grants: BTreeMap<usize, Granted<'w>>,
    pub arrivals: u64,
    pub supply: Vec<u64>,
    /// By our own account: nobody can free these.
    pub stuck: Vec<bool>,
    pub faults: Vec<bool>,
    /// Measured, and not reported yet.
    pub late_estimates: Vec<(GateId, Estimate)>,
    /// Done, and not reported yet.
    pub unreported: Vec<Done>,
    /// Offered once, and not done then.
    pub late_work: Vec<Work>,
    pub budget_used: bool,
    /// A sensor shows on what nobody was given.
    pub unbidden_seen: bool,
    /// Charges, as they were after the last step.
    pub charged: Vec<u64>,
    pub changes: usize,
}

impl<'w> World<'w> {
    pub fn new(ground: &'w Ground, gates: &'w mut [Gate<'w, Lamp<'w>, Platform<'w>>]) -> Self {
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
            bars_seen: 0,
            noticed: Vec::new(),
            grants: BTreeMap::new(),
            arrivals: 0,
            supply: supply.collect(),
            stuck: vec![false; GATES],
            faults: vec![false; GATES],
            late_estimates: Vec::new(),
            unreported: Vec::new(),
            late_work: Vec::new(),
            budget_used: false,
            unbidden_seen: false,
            charged: vec![0; agents],
            changes: 0,
        };
        world.noticed = world.scopes();
        world.charged = world.charges();
        world
    }

    pub fn now(&self) -> Instant {
        self.ground.clock.now()
    }

    pub fn gate_ids(&self) -> impl Iterator<Item = GateId> + use<> {
        (0..self.ground.truths.len()).map(|gate| GateId(u8::try_from(gate).unwrap()))
    }

    pub fn declared(&self, gate: usize) -> &'w Declared {
        &self.ground.setup.devices[gate]
    }

    pub fn rules(&self, agent: usize) -> &'w Rules {
        &self.ground.setup.agents[agent]
    }

    /// The broker's epoch and floor, then the agents'.
    pub fn scopes(&self) -> Vec<Seen> {
        let scopes = std::iter::once(&self.ground.broker).chain(&self.ground.scopes);
        scopes.map(Scope::read).collect()
    }

    pub fn charges(&self) -> Vec<u64> {
        let agents = 0..u8::try_from(self.ground.setup.agents.len()).unwrap();
        agents.map(|agent| self.books.charged(agent).get()).collect()
    }

    /// Whether supervisors have done something that the books do not know.
    pub fn is_noticed(&self) -> bool {
        self.bars_seen == self.ground.broker.bars() && self.noticed == self.scopes()
    }

    pub fn ticket(&self, id: TicketId, gate: GateId) -> Ticket<'w> {
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
    pub fn pick(&self, number: u8) -> Option<usize> {
        let serials: Vec<_> = self.grants.keys().copied().collect();
        (!serials.is_empty()).then(|| serials[usize::from(number) % serials.len()])
    }

    pub fn priority(level: u8) -> Priority {
        Priority::new(level)
    }
}
