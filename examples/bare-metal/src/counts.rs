//! Counts instructions, with the board's timer: the simulated processor takes
//! the same time for each.

use core::hint::black_box;
use core::sync::atomic::{Ordering, compiler_fence};

use faregate_tickets::clock::Clock;
use faregate_tickets::device::{Device, Estimate, Power};
use faregate_tickets::id::{GateId, Priority};
use semihosting::println;

use crate::clock::CLOCK;
use crate::craft::{Craft, CraftBroker, Lamp, TICKETS, TicketFor, Unrecorded};
use crate::plant::{FADES, PLANT};
use crate::{Failure, claim, sys};

/// A timer's tick is 40 ns and an instruction 128 ns: 16 ticks for 5. Rounded to
/// the nearest, since each end of what is measured may be off by part of a tick.
const fn instructions(ticks: u32) -> u32 {
    (ticks * 5 + 8) / 16
}

/// Counts, less what counting takes.
struct Meter {
    overhead: u32,
}

impl Meter {
    fn new() -> Result<Self, Failure> {
        let meter = Self { overhead: instructions(ticks_of(|| ()).0) };
        let hundred = meter.count(sys::hundred_instructions).0;
        claim(hundred == 100, "a hundred instructions are counted as a hundred")?;
        Ok(meter)
    }

    fn count<R>(&self, f: impl FnOnce() -> R) -> (u32, R) {
        let (ticks, result) = ticks_of(f);
        (instructions(ticks).saturating_sub(self.overhead), result)
    }

    /// Counts, and prints it.
    fn row<R>(&self, what: &str, f: impl FnOnce() -> R) -> (u32, R) {
        let (count, result) = self.count(f);
        println!("  {count:>6}  {what}");
        (count, result)
    }
}

#[inline(never)]
fn ticks_of<R>(f: impl FnOnce() -> R) -> (u32, R) {
    let before = sys::ticks_left();
    compiler_fence(Ordering::SeqCst);
    let result = black_box(f());
    compiler_fence(Ordering::SeqCst);
    (before.wrapping_sub(sys::ticks_left()), result)
}

/// Nobody interrupts: what is counted is the operation alone.
pub(crate) fn print(craft: &'static Craft) -> Result<(), Failure> {
    let meter = Meter::new()?;
    all_off(craft);
    println!("instructions");
    commands(&meter, craft)?;
    let few = revocations(&meter, craft, 1)?;
    let many = revocations(&meter, craft, TICKETS)?;
    claim(few == many, "Constant Revoke: the same for one ticket and for all seats")?;
    hand_over(&meter, craft)
}

type LampTicket = TicketFor<Lamp, Unrecorded>;

fn ask_for_lamp(craft: &'static Craft) -> Result<LampTicket, Failure> {
    let asked = craft.broker.request(Priority::ENGINEERING, &craft.lamp);
    asked.map_err(|_| Failure::Claim("there is a seat for each ticket"))
}

fn commands(meter: &Meter, craft: &'static Craft) -> Result<(), Failure> {
    let mut bare = Lamp::bare();
    meter.row("the bare command: one store", || bare.issue(black_box(1)));
    let ticket = ask_for_lamp(craft)?;
    let refused = meter.row("refused: not granted yet", || ticket.invoke(black_box(1))).1;
    claim(refused.is_err(), "a ticket that waits is refused")?;
    craft.broker.service();
    let obeyed =
        meter.row("the same command, invoked on a valid ticket", || ticket.invoke(black_box(1)));
    claim(obeyed.1.is_ok(), "a valid ticket commands")?;
    meter.row("to look whether a ticket is valid", || ticket.check()).1.map_err(|_| BROKEN)?;
    meter.row("service, with nothing to do", || craft.broker.service());
    Ok(())
}

const BROKEN: Failure = Failure::Claim("a valid ticket stays valid");
const NOT_YOURS: Failure = Failure::Claim("the supervisor has authority over the broker");

/// Revokes one ticket, and all, while so many are there.
fn revocations(meter: &Meter, craft: &'static Craft, tickets: usize) -> Result<[u32; 2], Failure> {
    println!("  with {tickets} of {TICKETS} tickets");
    let Craft { broker, supervisor, .. } = craft;
    let mut held: heapless::Vec<LampTicket, TICKETS> = heapless::Vec::new();
    for _ in 1..tickets {
        let _ = held.push(ask_for_lamp(craft)?);
    }
    let last = meter.row("request, behind the others", || ask_for_lamp(craft)).1?;
    let _ = held.push(last);
    let first = held.first().ok_or(BROKEN)?;
    broker.service();
    first.check().map_err(|_| BROKEN)?;

    let (all, revoked) = meter.row("revoke all tickets (safe mode)", || {
        broker.enter_safe_mode(supervisor, Priority::EMERGENCY)
    });
    revoked.map_err(|_| NOT_YOURS)?.without_waiting();
    claim(first.check().is_err(), "Closed Door: safe mode revokes")?;
    let refused = meter.row("refused: revoked", || first.invoke(black_box(1))).1;
    claim(refused.is_err(), "Closed Door: refused in safe mode")?;
    broker.leave_safe_mode(supervisor).map_err(|_| NOT_YOURS)?;
    broker.service();
    first.check().map_err(|_| BROKEN)?;

    let (one, revoked) =
        meter.row("revoke one ticket (bar)", || broker.bar(supervisor, first.id()));
    let revoked = revoked.map_err(|_| NOT_YOURS)?;
    let passed = meter.row("quiescence of all gates", || revoked.quiesce()).1;
    claim(passed.is_ok(), "Empty Room: nothing is in flight")?;
    claim(first.check().is_err(), "Closed Door: a bar revokes")?;

    let last = held.pop();
    meter.row("relinquish", || drop(last));
    drop(held);
    broker.service();
    Ok([all, one])
}

/// The camera is on, and the valve is requested: what is computed until the
/// valve's command is out. The waiting for the camera to go off is left out.
fn hand_over(meter: &Meter, craft: &'static Craft) -> Result<(), Failure> {
    let Craft { broker, camera, valve, .. } = craft;
    PLANT.make_ready(0);
    let seat = |_| Failure::Claim("there is a seat for each ticket");
    let monitor = broker.request(Priority::SCIENCE, camera).map_err(seat)?;
    broker.service();
    monitor.invoke(true).map_err(|_| BROKEN)?;

    println!("  a hand-over");
    let (request, emergency) = meter.row("request: the camera's ticket is revoked", || {
        broker.request(Priority::EMERGENCY, valve)
    });
    let emergency = emergency.map_err(seat)?;
    claim(monitor.invoke(true).is_err(), "Closed Door: revoked by the request")?;
    let (safe, _) = meter.row("service: quiescent, made safe", || broker.service());
    let estimate = measured_off();
    let (observe, ()) =
        meter.row("the estimate: seen off", || broker.observe(camera.gate(), estimate));
    let (admit, _) = meter.row("service: the valve's gate admits", || broker.service());
    let (command, shut) = meter.row("the valve's command", || emergency.invoke(true));
    claim(shut.is_ok(), "the emergency commands the valve")?;
    println!("  {:>6}  in all", request + safe + observe + admit + command);
    claim(PLANT.lost().is_none(), "the spacecraft is whole")
}

/// An estimate of a device that had the time to go off.
fn measured_off() -> Estimate {
    let from = CLOCK.now().after(FADES);
    while CLOCK.now() <= from {}
    Estimate { state: Power::Off, measured_at: CLOCK.now() }
}

fn all_off(craft: &Craft) {
    let broker: &CraftBroker = craft.broker;
    broker.service();
    let estimate = measured_off();
    for gate in [craft.camera.gate(), craft.valve.gate()] as [GateId; 2] {
        broker.observe(gate, estimate);
    }
    broker.service();
}
