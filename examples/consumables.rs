//! Consumables: a camera on a battery budget, and a limit in time.
//!
//! Energy is asked for ahead, together with the ticket: an observation that
//! could not be finished is not begun. What is not there is refused at once,
//! with the true amounts; what was promised and not used comes back. A ticket
//! can also be limited in time: when that is over the camera is made safe,
//! though its holder does nothing any more.
//!
//! ```sh
//! cargo run --example consumables
//! ```

use std::process::ExitCode;

use faregate::agents::AgentId;
use faregate::prelude::*;
use faregate_devices_sim::parameters::CAMERA_INRUSH;
use faregate_devices_sim::{
    CameraCommand, CameraDriver, DeviceId, FaultScript, ReceivedCommand, SimClock, Spacecraft,
};

use support::{Outcome, Sensors, claim, wait_for};

mod support;

/// What the battery has to spare for the camera, and what observations ask for.
const BUDGET: Microjoules = Microjoules::from_joules(40);
const COMET: Microjoules = Microjoules::from_joules(25);
const MOON: Microjoules = Microjoules::from_joules(20);
/// How long the comet is observed in the end, and the moon at most.
const COMET_TIME: Duration = Duration::from_millis(200);
const MOON_TIME: Duration = Duration::from_millis(150);

const SECOND: Duration = Duration::from_secs(1);

fn main() -> ExitCode {
    support::exit(fly())
}

fn fly() -> Outcome<()> {
    let flight = Flight::new()?;
    println!("{} for the camera.\n", joules(flight.left()?));
    let comet = flight.ask_ahead()?;
    flight.moon_is_refused()?;
    flight.comet_uses_part_of_it(comet)?;
    flight.moon_is_limited_in_time()?;
    claim(flight.spacecraft.broken_law().is_none(), "no law is broken")
}

struct Flight {
    spacecraft: Spacecraft,
    broker: Broker,
    agent: AgentId,
    camera: Handle<CameraDriver>,
    _sensors: Sensors,
}

impl Flight {
    fn new() -> Outcome<Self> {
        let parameters = support::parameters();
        let margin = parameters.supply().saturating_sub(parameters.base_load);
        let spacecraft = Spacecraft::new(parameters, FaultScript::new(), 1, &SimClock::real_time());

        let mut builder = Broker::builder()?;
        let agent = builder.agent(Policy::power_margin(margin).with_energy(BUDGET))?;
        let driver = spacecraft.camera_driver().ok_or("the driver is taken")?;
        let camera = builder.gate(agent, "camera", driver)?;
        let broker = builder.start()?;
        let sensors = Sensors::start(&broker, &spacecraft, [(camera.gate(), DeviceId::Camera)])?;
        Ok(Self { spacecraft, broker, agent, camera, _sensors: sensors })
    }

    fn ask_ahead(&self) -> Outcome<Ticket<CameraDriver>> {
        let want = self.camera.limited(Function::energy(COMET));
        let comet = self.broker.request(Priority::SCIENCE, &want)?;
        println!(
            "The comet asks for {}, and has it promised; {} left.",
            joules(COMET),
            joules(self.left()?)
        );
        claim(self.left()? == BUDGET.saturating_sub(COMET), "a promise is set aside at once")?;
        Ok(comet)
    }

    fn moon_is_refused(&self) -> Outcome<()> {
        let want = self.camera.limited(Function::energy(MOON));
        let Err(refused) = self.broker.request(Priority::SCIENCE, &want) else {
            return claim(false, "energy that is promised to somebody is not there for others");
        };
        println!("The moon asks for {}. Refused: {refused}.", joules(MOON));
        let left = BUDGET.saturating_sub(COMET);
        claim(refused == RequestRefused::NoEnergy { asked: MOON, left }, "the amounts are true")
    }

    fn comet_uses_part_of_it(&self, comet: Ticket<CameraDriver>) -> Outcome<()> {
        self.broker.wait(&comet, SECOND)?;
        comet.invoke(CameraCommand::On)?;
        self.pass(COMET_TIME);
        comet.invoke(CameraCommand::Off)?;
        comet.relinquish();
        println!("\nThe comet is observed for {COMET_TIME} only, and gives its ticket back.");

        // It counts until the camera is seen off, not until it is told to go.
        let before = BUDGET.saturating_sub(COMET);
        let back = || self.left().is_ok_and(|left| left > before);
        claim(wait_for(self.spacecraft.clock(), SECOND, back), "what is not used comes back")?;
        let used = BUDGET.saturating_sub(self.left()?);
        println!("It used {}; {} left.", joules(used), joules(self.left()?));
        // 1 mW for 1 us is 1 nJ. The largest draw is what is declared and counted.
        let on_for = self.on_for().ok_or("the camera was never on")?;
        let least = Microjoules::new(CAMERA_INRUSH.get() * on_for.as_micros() / 1_000);
        claim(used >= least, "what was used is counted")
    }

    fn moon_is_limited_in_time(&self) -> Outcome<()> {
        let limits = [Function::energy(MOON), Function::time_limit(MOON_TIME)];
        let want = self.camera.limited(Validity::all_of(&limits)?);
        let moon = self.broker.request(Priority::SCIENCE, &want)?;
        self.broker.wait(&moon, SECOND)?;
        println!("\nThe moon asks again, and for {MOON_TIME} at most.");
        moon.invoke(CameraCommand::On)?;

        println!("Its thread has turned the camera on, and is not heard of any more.");
        let off = || !self.spacecraft.truth().camera_on;
        // Its energy would last longer, and so would its lease.
        let soon = Duration::from_millis(500);
        claim(wait_for(self.spacecraft.clock(), soon, off), "the camera goes off all the same")?;
        let on_for = self.on_for().ok_or("the camera was never on")?;
        let trace = self.spacecraft.trace();
        let safing = trace.last().filter(|received| received.safing);
        let by = safing.ok_or("the last command was no safing")?.by.clone();
        println!("After {on_for} the camera goes off, by {by}.");
        claim(on_for >= MOON_TIME, "it has the time that it asked for")?;

        let Err(refused) = moon.invoke(CameraCommand::On) else {
            return claim(false, "a limit in time ends the ticket");
        };
        println!("The thread comes back, and goes on. Refused: {refused}.");
        claim(refused.refusal() == Some(Refusal::NotValid(Why::Expired)), "it says why")
    }

    /// What the agent can still promise.
    fn left(&self) -> Outcome<Microjoules> {
        let (energy, _) = self.broker.agents().budgets(self.agent).ok_or("no such agent")?;
        Ok(energy)
    }

    /// From the latest command that turned the camera on until the command
    /// after it had turned it off.
    fn on_for(&self) -> Option<Duration> {
        let trace = self.spacecraft.trace();
        let is_on = |received: &ReceivedCommand| received.command == CameraCommand::On.into();
        let on = trace.iter().rposition(is_on)?;
        Some(trace.get(on + 1)?.done?.since(trace.get(on)?.begun))
    }

    fn pass(&self, time: Duration) {
        let clock = self.spacecraft.clock();
        clock.wait_until(clock.now().after(time));
    }
}

/// To the last microjoule.
fn joules(energy: Microjoules) -> String {
    let exact = format!("{}.{:06}", energy.get() / 1_000_000, energy.get() % 1_000_000);
    format!("{} J", exact.trim_end_matches('0').trim_end_matches('.'))
}
