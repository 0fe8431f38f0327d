//! A flight: the emergency from the first alarm to the restored monitor, and
//! the steps that the flight recorder must show.

use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::id::{GateId, Priority, TicketId};
use faregate_tickets::recorder::RecordedEvent as Event;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use semihosting::println;

use crate::clock::CLOCK;
use crate::craft::Craft;
use crate::plant::{FADES, PLANT};
use crate::tape::{self, Entry, Source, Tape};
use crate::{Failure, claim, threads};

/// How long anything here may take.
const PATIENCE: Duration = Duration::from_millis(9000);

/// What happens in a flight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flight {
    name: &'static str,
    /// So many safing commands do not reach the camera.
    deaf: u8,
}

impl Flight {
    pub(crate) const ALL: [Self; 2] = [
        Self { name: "the camera goes off when it is made safe", deaf: 0 },
        Self { name: "the first safing command does not reach the camera", deaf: 1 },
    ];

    pub(crate) fn fly(self, craft: &Craft) -> Result<(), Failure> {
        println!("{}", self.name);
        PLANT.make_ready(self.deaf);
        wait_until("the monitor turns the camera on", || PLANT.camera_is_on())?;
        threads::forget_tally();
        tape::rewind();
        PLANT.stick_the_thruster();
        wait_until("the cutoff valve is shut", || PLANT.is_shut())?;
        wait_until("the camera is on again", || PLANT.camera_is_on())?;
        tape::stop(|tape| self.look_through(tape, craft))
    }

    /// The emergency, step by step, as the promise has it.
    fn look_through(self, tape: &Tape, craft: &Craft) -> Result<(), Failure> {
        claim(tape.lost == 0, "Nothing Lost: the tape has room for every record")?;
        let mut steps = Steps { entries: &tape.entries, at: 0 };
        let asked = steps.next(Source::Broker, "1 the emergency requests a ticket", |event| {
            event == Event::Requested { priority: Priority::EMERGENCY }
        })?;
        let emergency = asked.record.ticket;
        let taken = steps.next(Source::Broker, "2 the camera's ticket is revoked", |event| {
            preempted_by(event, emergency)
        })?;
        let camera = taken.record.ticket;
        steps.next(Source::Camera, "3 its gate is quiescent", |event| {
            matches!(event, Event::Vacated { .. })
        })?;
        let safed = self.safings(&mut steps)?;
        let off = steps.next(Source::Broker, "5 it is seen off", |event| {
            event == Event::SeenOff { gate: craft.camera.gate() }
        })?;
        claim(off.record.at > safed.after(FADES), "Margin Kept: it had gone off by then")?;
        let shut = shutting(&mut steps, emergency)?;
        within_the_bound(shut.since(asked.record.at), craft)?;
        restoration(&mut steps, emergency, camera, craft.valve.gate())?;
        doors(tape, emergency)?;
        refusals(emergency)
    }

    fn safings(self, steps: &mut Steps<'_>) -> Result<Instant, Failure> {
        let mut at = Instant::START;
        for attempt in 1..=self.deaf + 1 {
            let safed = steps.next(Source::Camera, "4 it is made safe", |event| {
                event == Event::Safed { attempt }
            })?;
            at = safed.record.at;
        }
        Ok(at)
    }
}

fn preempted_by(event: Event, emergency: usize) -> bool {
    let Event::Revoked(Why::Preempted { by: TicketId { serial, .. }, priority }) = event else {
        return false;
    };
    serial == emergency && priority == Priority::EMERGENCY
}

fn shutting(steps: &mut Steps<'_>, emergency: usize) -> Result<Instant, Failure> {
    steps.next(Source::Valve, "6 the cutoff valve's gate admits the emergency", |event| {
        matches!(event, Event::Admitted { .. })
    })?;
    let shut = steps
        .next(Source::Valve, "6 its coil is on", |event| event == Event::Issued { code: 1 })?;
    claim(shut.record.ticket == emergency, "One Tenant: the emergency commanded it")?;
    Ok(shut.record.at)
}

fn within_the_bound(took: Duration, craft: &Craft) -> Result<(), Failure> {
    let bound = craft.broker.hand_over_bound(craft.valve.gate(), 1);
    let bound = bound.ok_or(Failure::Claim("the hand-over has a bound"))?;
    println!("  requested and commanded within {took}; the computed bound is {bound}");
    claim(took <= bound, "Bounded Hand-over")
}

fn restoration(
    steps: &mut Steps<'_>,
    emergency: usize,
    camera: usize,
    valve: GateId,
) -> Result<(), Failure> {
    let gone = steps.next(Source::Broker, "8 the emergency relinquishes", |event| {
        event == Event::Relinquished
    })?;
    claim(gone.record.ticket == emergency, "the emergency's ticket is the one given back")?;
    steps.next(Source::Broker, "8 the coil is seen off", |event| {
        event == Event::SeenOff { gate: valve }
    })?;
    let back = steps.next(Source::Broker, "8 the monitor's ticket is valid again", |event| {
        event == Event::Granted
    })?;
    claim(back.record.ticket == camera, "Restoration: it is the same ticket")?;
    let on = steps
        .next(Source::Camera, "8 the monitor's next command succeeds", |event| {
            event == Event::Issued { code: 1 }
        })?
        .record
        .ticket;
    claim(on == camera, "Restoration: without asking again")
}

/// What must not be on the tape.
fn doors(tape: &Tape, emergency: usize) -> Result<(), Failure> {
    let mut open = true;
    for Entry { source, record } in &tape.entries {
        match (source, record.event) {
            (Source::Camera, Event::Vacated { .. }) => open = false,
            (Source::Camera, Event::Admitted { .. }) => open = true,
            (Source::Camera, Event::Issued { .. }) => {
                claim(open, "Closed Door: no command while the gate admits nobody")?;
            }
            (Source::Valve, Event::Issued { .. }) => {
                claim(record.ticket == emergency, "Closed Door: nobody else has the valve")?;
            }
            _ => {}
        }
    }
    Ok(())
}

fn refusals(emergency: usize) -> Result<(), Failure> {
    let tally = threads::tally();
    println!("  7 the monitor was refused {} times, and obeyed {}", tally.refused, tally.obeyed);
    claim(tally.refused > 0, "the monitor went on commanding")?;
    let Some(Refusal::NotValid(Why::Preempted { by, .. })) = tally.why else {
        return Err(Failure::Claim("Every Refusal Explains Itself"));
    };
    claim(by.serial == emergency, "Every Refusal Explains Itself: who took it")
}

/// The tape, read once from its beginning.
struct Steps<'t> {
    entries: &'t [Entry],
    at: usize,
}

impl<'t> Steps<'t> {
    /// The next record that is this step.
    fn next(
        &mut self,
        source: Source,
        step: &'static str,
        is_it: impl Fn(Event) -> bool,
    ) -> Result<&'t Entry, Failure> {
        let left = self.entries.get(self.at..).unwrap_or_default();
        let found =
            left.iter().position(|entry| entry.source == source && is_it(entry.record.event));
        let found = found.ok_or(Failure::Claim(step))?;
        self.at += found + 1;
        let entry = left.get(found).ok_or(Failure::Claim(step))?;
        println!("  {}  {step}", entry.record.at);
        Ok(entry)
    }
}

/// Sleeps from interrupt to interrupt until it is so.
fn wait_until(what: &'static str, is_so: impl Fn() -> bool) -> Result<(), Failure> {
    let deadline = CLOCK.now().after(PATIENCE);
    while !is_so() {
        lost()?;
        claim(CLOCK.now() < deadline, what)?;
        cortex_m::asm::wfi();
    }
    lost()
}

fn lost() -> Result<(), Failure> {
    PLANT.lost().map_or(Ok(()), |loss| Err(Failure::Lost(loss)))
}
