//! The emergency with tickets: the exclusive policy, the power margin, and what
//! becomes of the latter when one of its parts is left out.

use std::mem::ManuallyDrop;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use faregate::agents::{Broker, Handle, Policy, Want};
use faregate::tickets::Gate;
use faregate::tickets::clock::{Clock, Duration, Instant};
use faregate::tickets::device::{Declaration, Device, Estimate, Power, Profile};
use faregate::tickets::id::{Priority, TicketId};
use faregate::tickets::lock::Strategy;
use faregate::tickets::notify::Notify;
use faregate::tickets::refusal::{InvokeError, Refusal};
use faregate::tickets::validity::Function;
use faregate_devices_sim::{
    CameraCommand, CameraDriver, CutoffCommand, CutoffDriver, DeviceId, HeatersCommand,
    HeatersDriver, Outcome, Spacecraft,
};

use crate::bodies;
use crate::design::Ablation;
use crate::flight::{Flight, is_shut_command};
use crate::scene::Scene;
use crate::stage::{Bell, Body, Stage};
use crate::tape::Tape;
use crate::watch::{Watch, WatchLane};

const MS: Duration = Duration::from_millis(1);
/// The lease of a rescuer's tickets.
const LEASE: Duration = Duration::from_millis(200);

type Ports<S> = (S, faregate_devices_sim::SimClock, WatchLane);
type Agents<'g, S> = Broker<'g, Ports<S>, &'g Bells, 4, 8, 2>;
type Ticket<'b, 'g, D, S> = faregate::tickets::Ticket<'b, D, Ports<S>, Agents<'g, S>>;

/// Who is woken.
pub(crate) struct Bells {
    service: Bell,
    rescuers: [Bell; 2],
}

impl Notify for Bells {
    fn ticket_changed(&self, _: TicketId) {
        self.rescuers.iter().for_each(Bell::ring);
    }

    fn service_due(&self) {
        self.service.ring();
    }
}

/// How the camera gets its policy and what is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variant {
    Exclusive,
    PowerMargin,
    Without(Ablation),
}

/// The camera's driver, which may leave safing out.
struct Camera {
    driver: CameraDriver,
    safes: bool,
}

impl Device for Camera {
    type Command = CameraCommand;
    type Response = ();
    type Fault = faregate_devices_sim::DriverFault;

    fn profile(&self) -> Profile {
        self.driver.profile()
    }

    fn declare(command: &CameraCommand) -> Declaration {
        CameraDriver::declare(command)
    }

    fn issue(&mut self, command: CameraCommand) -> Result<(), Self::Fault> {
        self.driver.issue(command)
    }

    fn safe(&mut self) -> Result<(), Self::Fault> {
        if self.safes { self.driver.safe() } else { Ok(()) }
    }
}

/// The threads' common surroundings.
struct World<'w, 'g, S: Strategy> {
    stage: &'w Stage,
    scene: &'w Scene,
    craft: &'w Spacecraft,
    watch: &'w Watch,
    agents: &'w Agents<'g, S>,
    bells: &'g Bells,
    camera: Handle<'g, Camera, Ports<S>>,
    cutoff: Handle<'g, CutoffDriver, Ports<S>>,
    heaters: Handle<'g, HeatersDriver, Ports<S>>,
    variant: Variant,
    valid_refused: &'w AtomicU32,
    requested: &'w Requests,
}

/// Which rescuer asked for the valve, and when.
type Requests = Mutex<Vec<(&'static str, Instant)>>;

/// Flies one scene with tickets.
pub(crate) fn fly<S: Strategy>(
    scene: &Scene,
    variant: Variant,
    stage: &Stage,
    tape: &Tape,
) -> Flight {
    let clock = &stage.clock;
    let craft = Spacecraft::new(scene.parameters.clone(), scene.script.clone(), scene.seed, clock);
    let watch = Watch::new(&craft, stage.teller());
    let bells = Bells { service: stage.bell(), rescuers: [stage.bell(), stage.bell()] };
    let driver = craft.camera_driver().expect("nobody took it before");
    let camera = Camera { driver, safes: variant != Variant::Without(Ablation::Safing) };
    let cutoff = craft.cutoff_driver().expect("nobody took it before");
    let heaters = craft.heaters_driver().expect("nobody took it before");
    let lane = |device, by| watch.lane(device, by);
    let mut camera_gate =
        Gate::<_, Ports<S>>::new(camera, clock.clone(), lane("camera", "monitor"));
    let mut cutoff_gate =
        Gate::<_, Ports<S>>::new(cutoff, clock.clone(), lane("cutoff valve", "rescuer"));
    let mut heaters_gate =
        Gate::<_, Ports<S>>::new(heaters, clock.clone(), lane("heaters", "heater control"));

    let mut agents = Agents::new(clock.clone(), lane("broker", "broker"), &bells);
    let margin = scene.parameters.supply().saturating_sub(scene.parameters.base_load);
    let policy = match variant {
        Variant::Exclusive => Policy::exclusive(),
        _ => Policy::power_margin(margin),
    };
    let agent = agents.agent(policy).expect("there is room");
    let other = agents.agent(Policy::unlimited()).expect("there is room");
    let camera = agents.register(agent, camera_gate.key()).expect("there is room");
    let cutoff = agents.register(agent, cutoff_gate.key()).expect("there is room");
    // The exclusive policy is the paper's: one agent for camera and valve.
    let heaters_agent = if variant == Variant::Exclusive { other } else { agent };
    let heaters = agents.register(heaters_agent, heaters_gate.key()).expect("there is room");

    let (valid_refused, requested) = (AtomicU32::new(0), Requests::default());
    let world = World {
        stage,
        scene,
        craft: &craft,
        watch: &watch,
        agents: &agents,
        bells: &bells,
        camera,
        cutoff,
        heaters,
        variant,
        valid_refused: &valid_refused,
        requested: &requested,
    };
    stage.perform(scene.seed, world.threads(tape));
    world.result(tape)
}

impl<'w, 'g, S: Strategy> World<'w, 'g, S> {
    fn threads<'t>(&'t self, tape: &'t Tape) -> Vec<Body<'t>> {
        let rescuer = |who, bell| Box::new(move || self.rescuer(who, bell));
        let mut threads: Vec<Body<'t>> = vec![
            ("service", Priority::new(254), Box::new(|| self.service())),
            ("sensors", Priority::new(253), Box::new(|| self.sensors())),
            ("rescuer", Priority::EMERGENCY, rescuer("rescuer", 0)),
            ("backup", Priority::EMERGENCY, rescuer("backup", 1)),
            (
                "director",
                Priority::LEAST,
                Box::new(|| {
                    bodies::director(self.stage, self.scene, self.craft, tape);
                }),
            ),
        ];
        if self.scene.monitor.is_some() {
            threads.push(("monitor", Priority::SCIENCE, Box::new(|| self.monitor())));
        }
        if self.scene.driver_hangs {
            threads.push((
                "heater control",
                Priority::ENGINEERING,
                Box::new(|| self.heater_control()),
            ));
        }
        threads
    }

    /// Above all holders: does what is due.
    fn service(&self) {
        while self.stage.goes_on() {
            let due = self.agents.service();
            let latest = self.stage.clock.now().after(MS.saturating_mul(50));
            let due = due.map_or(latest, |due| due.min(latest));
            self.bells.service.wait_until(self.stage, due);
        }
    }

    /// Brings the estimates to the agents.
    fn sensors(&self) {
        let gates = [
            (DeviceId::Camera, self.camera.gate()),
            (DeviceId::Cutoff, self.cutoff.gate()),
            (DeviceId::Heaters, self.heaters.gate()),
        ];
        let mut latest = [Instant::START; 3];
        while self.stage.goes_on() {
            for ((device, gate), latest) in gates.iter().zip(&mut latest) {
                if let Some(estimate) =
                    self.estimate(*device).filter(|seen| seen.measured_at > *latest)
                {
                    *latest = estimate.measured_at;
                    self.agents.observe(*gate, estimate);
                }
            }
            self.stage.wait(MS.saturating_mul(2));
        }
    }

    fn estimate(&self, device: DeviceId) -> Option<Estimate> {
        let now = self.stage.clock.now();
        let seen = self.craft.estimate(device);
        match self.variant {
            // The time of arrival instead of the time of the measurement.
            Variant::Without(Ablation::FreshEstimates) => {
                seen.map(|seen| Estimate { measured_at: now, ..seen })
            }
            // What was commanded is what is.
            Variant::Without(Ablation::Confirmation) if device == DeviceId::Camera => {
                Some(Estimate { state: self.as_commanded(), measured_at: now })
            }
            _ => seen,
        }
    }

    fn as_commanded(&self) -> Power {
        let trace = self.craft.trace();
        let done =
            |entry: &&faregate_devices_sim::ReceivedCommand| entry.outcome != Outcome::InProgress;
        let power = trace.iter().rev().filter(done).find_map(|entry| match entry.command {
            faregate_devices_sim::Command::Camera(CameraCommand::On) => Some(Power::On),
            faregate_devices_sim::Command::Camera(CameraCommand::Off) => Some(Power::Off),
            _ => None,
        });
        power.unwrap_or(Power::Off)
    }

    fn monitor(&self) {
        let Some(monitor) = self.scene.monitor else { return };
        let ticket =
            self.agents.request(Priority::SCIENCE, &self.camera).expect("it fits the supply");
        self.stage.tell("monitor", || {
            format!("requests the camera ({}, {})", ticket.id(), Priority::SCIENCE)
        });
        let bare = self.craft.bare_camera();
        bodies::camera_monitor(self.stage, self.craft, monitor, |command| {
            if self.variant == Variant::Without(Ablation::Quiescence) {
                // The paper's bare flag: the check, and some time later the
                // command.
                let valid = ticket.check().is_ok();
                self.stage.wait(monitor.window);
                return valid && bare.issue(command).is_ok() && ticket.renew().is_ok();
            }
            self.invoke(&ticket, command)
        });
    }

    fn heater_control(&self) {
        let ticket =
            self.agents.request(Priority::ENGINEERING, &self.heaters).expect("it fits the supply");
        while self.stage.goes_on() {
            self.invoke(&ticket, HeatersCommand::On);
            self.stage.wait(MS.saturating_mul(50));
        }
    }

    /// Invokes, and watches Open Door: a ticket that was valid before and after
    /// and was not revoked in between is not refused.
    fn invoke<D: Device>(&self, ticket: &Ticket<'_, 'g, D, S>, command: D::Command) -> bool {
        let (valid, revocations) = (ticket.check().is_ok(), self.watch.revocations());
        let result = ticket.invoke(command);
        let unrevoked = revocations == self.watch.revocations() && ticket.check().is_ok();
        let refused = matches!(result, Err(InvokeError::Refused(refusal)) if !matches!(refusal, Refusal::Faulted(_)));
        if valid && unrevoked && refused {
            self.valid_refused.fetch_add(1, Ordering::SeqCst);
        }
        result.is_ok()
    }

    fn rescuer(&self, who: &'static str, bell: usize) {
        // The backup comes when the first one should have been done.
        let spin = if bell == 0 { 10_000 } else { 40_000 };
        if !bodies::wait_for_spin(self.stage, self.craft, spin) || bodies::is_shut(self.craft) {
            return;
        }
        self.requested.lock().expect("no rescuer panics").push((who, self.stage.clock.now()));
        match self.variant {
            Variant::Exclusive => self.rescue_with_both(who, bell),
            _ => self.rescue_with_cutoff(who, bell),
        }
    }

    fn lease(&self) -> Duration {
        if self.variant == Variant::Without(Ablation::Lease) { Duration::MAX } else { LEASE }
    }

    fn want<D: Device>(&self, handle: &Handle<'g, D, Ports<S>>) -> Want<'g, D, Ports<S>> {
        handle.limited(Function::lease(self.lease()))
    }

    /// The realistic policy: asks for the valve, and knows nothing of cameras.
    fn rescue_with_cutoff(&self, who: &'static str, bell: usize) {
        let cutoff = self.agents.request(Priority::EMERGENCY, &self.want(&self.cutoff));
        let cutoff = cutoff.expect("it fits the supply");
        self.stage.tell(who, || {
            format!("requests the cutoff valve ({}, {})", cutoff.id(), Priority::EMERGENCY)
        });
        self.wait_for(bell, || cutoff.check().is_ok());
        if self.dies(who) {
            let _never_dropped = ManuallyDrop::new(cutoff);
            return;
        }
        self.stage.tell(who, || "has a valid ticket; commands the valve shut".into());
        bodies::shut_for_sure(self.stage, self.scene, self.craft, || {
            self.invoke(&cutoff, CutoffCommand::Shut)
        });
        self.stage.tell(who, || "sees the valve shut; relinquishes its ticket".into());
    }

    /// The simplest policy: asks for camera and valve, all or nothing, and
    /// turns the camera off itself.
    fn rescue_with_both(&self, who: &'static str, bell: usize) {
        let both = (self.want(&self.camera), self.want(&self.cutoff));
        let (camera, cutoff) =
            self.agents.request(Priority::EMERGENCY, &both).expect("there is room");
        self.wait_for(bell, || camera.check().is_ok() && cutoff.check().is_ok());
        if self.dies(who) {
            let _never_dropped = ManuallyDrop::new((camera, cutoff));
            return;
        }
        bodies::camera_off_for_sure(self.stage, self.scene, self.craft, || {
            let _ = cutoff.renew();
            self.invoke(&camera, CameraCommand::Off);
        });
        bodies::shut_for_sure(self.stage, self.scene, self.craft, || {
            let _ = camera.renew();
            self.invoke(&cutoff, CutoffCommand::Shut)
        });
        let at_rest = self.stage.clock.now();
        self.invoke(&cutoff, CutoffCommand::CoilOff);
        while self.stage.goes_on() && !bodies::is_freshly_off(self.craft, DeviceId::Cutoff, at_rest)
        {
            let _ = (camera.renew(), cutoff.renew());
            self.stage.wait(MS);
        }
    }

    fn dies(&self, who: &'static str) -> bool {
        let dies = self.scene.rescuer_dies && who == "rescuer";
        if dies {
            self.stage.tell(who, || "dies with its ticket in hand".into());
        }
        dies
    }

    /// Drives the hand-over at the caller's own priority until it has come.
    fn wait_for(&self, bell: usize, mut valid: impl FnMut() -> bool) {
        while self.stage.goes_on() {
            let due = self.agents.service();
            if valid() {
                return;
            }
            let latest = self.stage.clock.now().after(MS.saturating_mul(20));
            let due = due.map_or(latest, |due| due.min(latest));
            self.bells.rescuers[bell].wait_until(self.stage, due);
        }
    }

    fn result(&self, tape: &Tape) -> Flight {
        let trace = self.craft.trace();
        let shut = trace.iter().find(|entry| is_shut_command(entry));
        let requested = self.requested.lock().expect("no rescuer panics").clone();
        let by_whom = shut.and_then(|shut| requested.iter().find(|(who, _)| *who == shut.by));
        let rounds = self.watch.rounds();
        let bound = self.agents.hand_over_bound(self.cutoff.gate(), rounds);
        // Behind a dead holder, its lease comes first.
        let bound = bound.map(|bound| {
            let dead = if self.scene.rescuer_dies { self.lease() } else { Duration::ZERO };
            bound.saturating_add(dead)
        });
        Flight {
            after_quiescence: self.watch.passed(),
            valid_refused: self.valid_refused.load(Ordering::SeqCst),
            cutoff_after: shut.zip(by_whom).map(|(shut, (_, at))| shut.begun.since(*at)),
            bound,
            holds: self.watch.holds(self.stage.clock.now()),
            ..Flight::of(self.scene, self.craft, tape)
        }
    }
}

impl std::fmt::Debug for Bells {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Bells")
    }
}
