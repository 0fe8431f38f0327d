//! An interlock: thruster valve and catalyst bed heaters share a converter that
//! cannot feed both.
//!
//! Their tickets come with a validity function that agrees to turn one on only
//! while the other is certain to be off. First it is tried from both sides: to
//! *command* the heaters off is not enough, they must have been *seen* off.
//! Then two threads that know nothing of each other use both devices for more
//! than a second; the devices are never on together. At last the same threads
//! fly with tickets without that function: the converter trips, and the
//! spacecraft is lost.
//!
//! ```sh
//! cargo run --example shared_heaters
//! ```

use std::process::ExitCode;
use std::thread;

use faregate::prelude::*;
use faregate::tickets::interlock::{Interlock, Side};
use faregate::tickets::validity::Rule;
use faregate_devices_sim::{
    Command, DeviceId, FaultScript, HeatersCommand, HeatersDriver, ReceivedCommand, SimClock,
    Spacecraft, ThrusterCommand, ThrusterDriver,
};

use support::{Failure, Outcome, Sensors, claim, wait_for};

mod support;

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

fn main() -> ExitCode {
    support::exit(fly())
}

fn fly() -> Outcome<()> {
    let interlocked = Propulsion::new(Function::interlock())?;
    println!("From both sides:\n");
    interlocked.try_both_sides()?;

    println!("\nTwo threads, with the interlock:\n");
    let [valve, heaters] = interlocked.contend(ms(1_200))?;
    println!("    valve:   {valve}\n    heaters: {heaters}");
    let together = time_together(&interlocked.spacecraft.trace());
    println!("    on together for {together}");
    claim(together.is_zero(), "valve and heaters are never on together")?;
    claim(interlocked.spacecraft.broken_law().is_none(), "no law is broken")?;
    claim(valve.turns >= 5 && heaters.turns >= 5, "each side has its turns")?;
    claim(valve.refused > 0 && heaters.refused > 0, "each side is refused at times")?;

    println!("\nThe same threads, without it:\n");
    let bare = Propulsion::new(Function::always())?;
    let [valve, heaters] = bare.contend(ms(1_200))?;
    println!("    valve:   {valve}\n    heaters: {heaters}");
    let Some((at, law)) = bare.spacecraft.broken_law() else {
        return claim(false, "without the interlock the spacecraft is lost");
    };
    println!("    LOST at {at}: {law}");
    Ok(())
}

/// A spacecraft, a broker, and tickets with this validity function.
struct Propulsion {
    spacecraft: Spacecraft,
    broker: Broker,
    valve: Handle<ThrusterDriver>,
    heaters: Handle<HeatersDriver>,
    validity: Function,
    _sensors: Sensors,
}

impl Propulsion {
    fn new(validity: Function) -> Outcome<Self> {
        let parameters = support::parameters();
        let margin = parameters.supply().saturating_sub(parameters.base_load);
        let spacecraft = Spacecraft::new(parameters, FaultScript::new(), 1, &SimClock::real_time());
        // Gates live as long as the program, and so does what they look at.
        let interlock: &'static Interlock = Box::leak(Box::new(Interlock::new()));

        let mut builder = Broker::builder()?;
        let agent = builder.agent(Policy::power_margin(margin))?;
        let side =
            |side| Ok::<_, Failure>(GateOptions::new().interlocked(interlock.member(side, 0)?));
        let driver = spacecraft.thruster_driver().ok_or("the driver is taken")?;
        let valve = builder.gate_with(agent, "valve", driver, side(Side::A)?)?;
        let driver = spacecraft.heaters_driver().ok_or("the driver is taken")?;
        let heaters = builder.gate_with(agent, "heaters", driver, side(Side::B)?)?;
        let broker = builder.start()?;

        let gates = [(valve.gate(), DeviceId::Thruster), (heaters.gate(), DeviceId::Heaters)];
        let sensors = Sensors::start(&broker, &spacecraft, gates)?;
        Ok(Self { spacecraft, broker, valve, heaters, validity, _sensors: sensors })
    }

    /// Both tickets are valid together: it is their functions that keep the
    /// devices apart.
    fn tickets(&self) -> Outcome<(Ticket<ThrusterDriver>, Ticket<HeatersDriver>)> {
        let valve =
            self.broker.request(Priority::ENGINEERING, &self.valve.limited(self.validity))?;
        let heaters =
            self.broker.request(Priority::ENGINEERING, &self.heaters.limited(self.validity))?;
        self.broker.wait(&valve, ms(1_000))?;
        self.broker.wait(&heaters, ms(1_000))?;
        Ok((valve, heaters))
    }

    fn try_both_sides(&self) -> Outcome<()> {
        let (valve, heaters) = self.tickets()?;
        // At the start, what nobody has seen off yet counts as on.
        self.issued_in_time(&heaters, HeatersCommand::On, "heaters on")?;
        refused(&valve, ThrusterCommand::Open, "valve open")?;
        heaters.invoke(HeatersCommand::Off)?;
        println!("    heaters off: issued, and not seen off yet");
        refused(&valve, ThrusterCommand::Open, "valve open")?;
        self.issued_in_time(&valve, ThrusterCommand::Open, "valve open")?;

        refused(&heaters, HeatersCommand::On, "heaters on")?;
        valve.invoke(ThrusterCommand::Close)?;
        println!("    valve shut:  issued, and not seen off yet");
        refused(&heaters, HeatersCommand::On, "heaters on")?;
        self.issued_in_time(&heaters, HeatersCommand::On, "heaters on")?;
        heaters.invoke(HeatersCommand::Off)?;
        Ok(())
    }

    /// Tries again until the command is issued.
    fn issued_in_time<D: Device>(
        &self,
        ticket: &Ticket<D>,
        command: D::Command,
        what: &str,
    ) -> Outcome<()> {
        let clock = self.spacecraft.clock();
        let since = clock.now();
        let issued = wait_for(clock, ms(1_000), || ticket.invoke(command).is_ok());
        println!("    {:12} issued, {} later", format!("{what}:"), clock.now().since(since));
        claim(issued, "one side may be on once the other is seen off")
    }

    /// Both sides at once, each from a thread of its own.
    fn contend(&self, time: Duration) -> Outcome<[Turns; 2]> {
        let (valve, heaters) = self.tickets()?;
        let until = self.spacecraft.clock().now().after(time);
        let (open, close) = (ThrusterCommand::Open, ThrusterCommand::Close);
        let (on, off) = (HeatersCommand::On, HeatersCommand::Off);
        thread::scope(|scope| {
            let valve = scope.spawn(move || self.take_turns(&valve, [open, close], [8, 40], until));
            let heaters =
                scope.spawn(move || self.take_turns(&heaters, [on, off], [30, 40], until));
            let ended = |thread: thread::ScopedJoinHandle<'_, _>| thread.join();
            let (valve, heaters) = (ended(valve), ended(heaters));
            Ok([
                valve.map_err(|_| "a thread panicked")??,
                heaters.map_err(|_| "a thread panicked")??,
            ])
        })
    }

    /// Turns a device on and off again and again, for so many milliseconds each.
    fn take_turns<D: Device<Fault: std::fmt::Debug>>(
        &self,
        ticket: &Ticket<D>,
        [on, off]: [D::Command; 2],
        [on_ms, off_ms]: [u64; 2],
        until: Instant,
    ) -> Outcome<Turns> {
        let clock = self.spacecraft.clock();
        let wait = |time| clock.wait_until(clock.now().after(time));
        let mut turns = Turns::default();
        while clock.now() < until && self.spacecraft.broken_law().is_none() {
            match ticket.invoke(on).map_err(|error| (is_interlocked(&error), error)) {
                Ok(_) => {
                    turns.turns += 1;
                    wait(ms(on_ms));
                    ticket.invoke(off).map_err(|error| error.to_string())?;
                    wait(ms(off_ms));
                }
                Err((true, _)) => {
                    turns.refused += 1;
                    wait(ms(2));
                }
                Err((false, error)) => return Err(error.to_string().into()),
            }
        }
        Ok(turns)
    }
}

/// How often one side had the converter, and how often it was refused.
#[derive(Clone, Copy, Debug, Default)]
struct Turns {
    turns: u32,
    refused: u32,
}

impl std::fmt::Display for Turns {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:3} times on, {:3} times refused", self.turns, self.refused)
    }
}

fn is_interlocked<F>(error: &InvokeError<F>) -> bool {
    matches!(error.refusal(), Some(Refusal::Denied(denial)) if denial.rule == Rule::Interlock)
}

fn refused<D: Device<Fault: std::fmt::Debug>>(
    ticket: &Ticket<D>,
    command: D::Command,
    what: &str,
) -> Outcome<()> {
    let Err(error) = ticket.invoke(command) else {
        return claim(false, "one side is refused while the other may be on");
    };
    println!("    {:12} refused: {error}", format!("{what}:"));
    claim(is_interlocked(&error), "it is the interlock that refuses")
}

/// For how long both devices were on, by what really reached them: stricter
/// than the converter, which bears it for some milliseconds.
fn time_together(trace: &[ReceivedCommand]) -> Duration {
    let reached = trace.iter().filter_map(|received| Some((received.done?, received.command)));
    let mut reached: Vec<_> = reached.collect();
    reached.sort_by_key(|(at, _)| *at);
    let (mut open, mut heating, mut before) = (false, false, Instant::START);
    let mut together = Duration::ZERO;
    for (at, command) in reached {
        if open && heating {
            together = together.saturating_add(at.since(before));
        }
        match command {
            Command::Thruster(command) => open = command == ThrusterCommand::Open,
            Command::Heaters(command) => heating = command == HeatersCommand::On,
            Command::Camera(_) | Command::Cutoff(_) => {}
        }
        before = at;
    }
    together
}
