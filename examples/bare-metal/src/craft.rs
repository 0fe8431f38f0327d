//! Gates, agents and broker, put together in statics by hand.

use core::convert::Infallible;

use faregate_agents::{AgentId, Broker, Handle, Policy, RegisterError, Supervisor};
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Effect, Profile, WhenOrphaned};
use faregate_tickets::lock::Masked;
use faregate_tickets::notify::Notify;
use faregate_tickets::recorder::NoLane;
use faregate_tickets::{Device, Gate, Ticket};
use static_cell::StaticCell;

use crate::clock::{BoardClock, CLOCK};
use crate::plant::{CAMERA, COIL, FADES, PLANT, SUPPLY};
use crate::sys;
use crate::tape::{Source, TapeLane};

/// Three gates, eight tickets, no sets of them.
pub(crate) const GATES: usize = 3;
pub(crate) const TICKETS: usize = 8;

/// What gates and broker stand on.
pub(crate) type Ports = (Masked, &'static BoardClock, TapeLane);
/// The same without a recorder, for what is measured.
pub(crate) type Unrecorded = (Masked, &'static BoardClock, NoLane);
pub(crate) type CraftBroker = Broker<'static, Ports, Pend, GATES, TICKETS, 0>;
pub(crate) type TicketFor<D, P = Ports> = Ticket<'static, D, P, CraftBroker>;

/// Everything that the threads share.
#[derive(Debug)]
pub(crate) struct Craft {
    pub(crate) broker: &'static CraftBroker,
    pub(crate) supervisor: Supervisor,
    pub(crate) camera: Handle<'static, Camera, Ports>,
    pub(crate) valve: Handle<'static, CutoffValve, Ports>,
    pub(crate) lamp: Handle<'static, Lamp, Unrecorded>,
}

impl Craft {
    /// Puts it together, once. In a frame of its own: the broker is made there,
    /// and the interrupts need the stack later.
    #[inline(never)]
    pub(crate) fn assemble() -> Result<&'static Self, RegisterError> {
        static BROKER: StaticCell<CraftBroker> = StaticCell::new();
        static CRAFT: StaticCell<Craft> = StaticCell::new();
        let broker = BROKER.init_with(|| Broker::new(&CLOCK, TapeLane(Source::Broker), Pend));
        let power = broker.agent(power_policy())?;
        let panel = broker.agent(Policy::unlimited())?;
        let (camera, valve) = (camera(broker, power)?, valve(broker, power)?);
        let lamp = lamp(broker, panel)?;
        let supervisor = broker.supervisor();
        Ok(CRAFT.init_with(|| Self { broker, supervisor, camera, valve, lamp }))
    }
}

/// The margin of the bus. The break: nobody tells the agent of it, so there is
/// nothing to revoke for.
fn power_policy() -> Policy {
    if cfg!(feature = "break-revocation") {
        return Policy::unlimited();
    }
    Policy::power_margin(SUPPLY)
}

fn camera(
    broker: &mut CraftBroker,
    agent: AgentId,
) -> Result<Handle<'static, Camera, Ports>, RegisterError> {
    static GATE: StaticCell<Gate<'static, Camera, Ports>> = StaticCell::new();
    let gate = GATE.init_with(|| Gate::new(Camera(()), &CLOCK, TapeLane(Source::Camera)));
    broker.register(agent, gate.key())
}

fn valve(
    broker: &mut CraftBroker,
    agent: AgentId,
) -> Result<Handle<'static, CutoffValve, Ports>, RegisterError> {
    static GATE: StaticCell<Gate<'static, CutoffValve, Ports>> = StaticCell::new();
    let gate = GATE.init_with(|| Gate::new(CutoffValve(()), &CLOCK, TapeLane(Source::Valve)));
    broker.register(agent, gate.key())
}

fn lamp(
    broker: &mut CraftBroker,
    agent: AgentId,
) -> Result<Handle<'static, Lamp, Unrecorded>, RegisterError> {
    static GATE: StaticCell<Gate<'static, Lamp, Unrecorded>> = StaticCell::new();
    let gate = GATE.init_with(|| Gate::new(Lamp(()), &CLOCK, NoLane));
    broker.register(agent, gate.key())
}

/// Wakes by pending interrupts.
#[derive(Debug)]
pub(crate) struct Pend;

impl Notify for Pend {
    fn ticket_changed(&self, _: faregate_tickets::id::TicketId) {
        sys::pend_rescuer();
    }

    fn service_due(&self) {
        sys::pend_service();
    }
}

/// What the devices have in common: a driver writes a register.
const PROFILE: Profile = Profile {
    longest_command: Duration::from_micros(500),
    longest_safing: Duration::from_micros(500),
    settling: FADES,
    estimate_lag: Duration::from_millis(100),
    when_orphaned: WhenOrphaned::SafeAtOnce,
    ..Profile::new()
};

/// What is declared of the command that switches.
const fn switching(on: bool, effect_on: Effect) -> Declaration {
    let effect = if on { effect_on } else { Effect::Off };
    Declaration { code: on as u16, wcet: PROFILE.longest_command, effect }
}

/// The camera's power switch. The field keeps others from making a second one.
#[derive(Debug)]
pub(crate) struct Camera(());

impl Device for Camera {
    type Command = bool;
    type Response = ();
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        PROFILE.drawing(CAMERA)
    }

    fn declare(on: &bool) -> Declaration {
        switching(*on, Effect::on(CAMERA))
    }

    fn issue(&mut self, on: bool) -> Result<(), Infallible> {
        PLANT.switch_camera(on);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        PLANT.safe_camera();
        Ok(())
    }
}

/// The coil of the valve that cuts the thruster off. The valve stays shut when
/// the coil goes off.
#[derive(Debug)]
pub(crate) struct CutoffValve(());

impl Device for CutoffValve {
    type Command = bool;
    type Response = ();
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        PROFILE.drawing(COIL)
    }

    fn declare(on: &bool) -> Declaration {
        switching(*on, Effect::on(COIL))
    }

    fn issue(&mut self, on: bool) -> Result<(), Infallible> {
        PLANT.switch_coil(on);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        PLANT.switch_coil(false);
        Ok(())
    }
}

/// The lamps of the board, as one word. They draw nothing that anybody counts.
#[derive(Debug)]
pub(crate) struct Lamp(());

impl Lamp {
    /// A second handle to the lamps, to measure what the bare command takes.
    pub(crate) const fn bare() -> Self {
        Self(())
    }
}

impl Device for Lamp {
    type Command = u32;
    type Response = ();
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        Profile::new()
    }

    fn declare(_: &u32) -> Declaration {
        Declaration { code: 0, wcet: PROFILE.longest_command, effect: Effect::Unchanged }
    }

    fn issue(&mut self, lamps: u32) -> Result<(), Infallible> {
        sys::light(lamps);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        sys::light(0);
        Ok(())
    }
}
