//! Requests, tickets that are given back, and one step of a decision.

use core::mem::ManuallyDrop;

use faregate_agents::{Actions, Books, Done, Event, Handle, RequestRefused};
use faregate_tickets::Ticket;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Instant;
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::fault::GateFault;
use faregate_tickets::gate::{Blocked, Safed, Vacated};
use faregate_tickets::id::{GateId, Priority, TicketId};
use faregate_tickets::scope::Seen;
use faregate_tickets::ticket::Holder;
use faregate_tickets::validity::Validity;

use crate::entry;
use crate::ports::{Bare, NOW, Ring, STATUS, Setting, Valve};
use crate::random::Random;
use crate::stage::{Stage, Tickets};
use crate::sys::Slot;

/// As many gates as the stated bounds are for.
const GATES: usize = 4;
const SEATS: usize = 16;
const SETS: usize = 2;

type Small = Stage<Valve, Bare<Ring>, Bare<Ring>, GATES, SEATS, SETS>;
type Agency = Tickets<Bare<Ring>, GATES, SEATS, SETS>;
type Gates = Handle<'static, Valve, Bare<Ring>>;

static STAGE: Small = Stage::new();
static BOOKS: Slot<Books<GATES, SEATS, SETS>> = Slot::empty();
static EVENT: Slot<Event> = Slot::empty();
static ACTIONS: Slot<Actions<GATES>> = Slot::empty();
static PRIORITY: Slot<Priority> = Slot::empty();
static NAMED: Slot<TicketId> = Slot::empty();
static FOUND: Slot<Found> = Slot::empty();

/// What an event may carry.
#[derive(Debug)]
struct Found {
    now: Instant,
    gate: GateId,
    ticket: TicketId,
    estimate: Estimate,
    supply: Milliwatts,
    epoch: usize,
    tenure: usize,
    attempt: u8,
    ends_ticket: bool,
    seen: Seen,
    agents: [Seen; faregate_agents::limits::MAX_AGENTS],
    faults: [Option<GateFault>; faregate_agents::limits::MAX_GATES],
    vacated: Vacated,
    blocked: Blocked,
}

/// A broker in the midst of its work: tickets that are valid, that wait, that
/// are being handed over; devices that are on, orphaned, and stuck.
fn in_flight(random: &mut Random) {
    let broker = STAGE.build(random);
    for _ in 0..1 + random.below(24) {
        something_happens(broker, random);
    }
    if let Ok(ticket) = broker.request(Priority::SCIENCE, &want(random)) {
        NAMED.fill(ticket.id());
        STAGE.ticket.fill(ticket);
    }
    if random.flip() {
        broker.service();
    }
    BOOKS.fill(broker.books().expect("books"));
    PRIORITY.fill(Priority::new(random.byte()));
    let found = FOUND.fill(found(random));
    EVENT.fill(event(found, random));
    ACTIONS.fill(Actions::default());
}

fn something_happens(broker: &'static Agency, random: &mut Random) {
    NOW.write(NOW.read() + random.below(1 << 18));
    STATUS.write(0);
    match random.below(8) {
        0 => {
            broker.service();
        }
        1 => {
            let (one, other) = (want(random), want(random));
            let asked = broker.request(Priority::new(random.byte()), &(one, other));
            let _ = ManuallyDrop::new(asked);
        }
        2 => drop(broker.request(Priority::new(random.byte()), &want(random))),
        3 => observe(broker, random),
        _ => keep(broker.request(Priority::new(random.byte()), &want(random)), random),
    }
}

fn keep(
    asked: Result<Ticket<'static, Valve, Bare<Ring>, Agency>, RequestRefused>,
    random: &mut Random,
) {
    let Ok(ticket) = asked else { return };
    if random.flip() {
        STAGE.broker().service();
        let _ = ticket.invoke(Setting::On);
    }
    // Its holder is somebody else, who goes on having it.
    let _ = ManuallyDrop::new(ticket);
}

fn observe(broker: &'static Agency, random: &mut Random) {
    let state = random.pick([Power::Off, Power::Off, Power::On, Power::Unknown]);
    let measured_at = Instant::from_micros(NOW.read());
    broker.observe(gate(random), Estimate { state, measured_at });
}

fn gate(random: &mut Random) -> GateId {
    GateId(random.byte() % GATES as u8)
}

fn want(random: &mut Random) -> faregate_agents::Want<'static, Valve, Bare<Ring>> {
    let handle: &'static Gates = STAGE.handles[usize::from(gate(random).0)].get();
    handle.limited(Validity::always())
}

/// Anything that can happen.
fn event(found: &Found, random: &mut Random) -> Event {
    let &Found { now, gate, ticket, epoch, tenure, attempt, .. } = found;
    let seat = ticket.seat;
    match random.below(16) {
        0 => Event::Noticed { broker: found.seen, agents: found.agents, survivors: 1 },
        1 => Event::Relinquished { ticket, gate, holder: Holder::Died },
        2 => Event::Barred { seat, epoch },
        3 => Event::HitByStaleBar { seat, epoch },
        4 => Event::Reinstated(ticket),
        5 => Event::Observed(gate, found.estimate),
        6 => Event::Supply { agent: 0, supply: found.supply },
        7 => Event::RanOut { gate, serial: ticket.serial, ends_ticket: found.ends_ticket },
        8 => Event::Faults(found.faults),
        9 => Event::Reset(gate),
        10 => Event::Done(Done::Vacated { gate, ended: tenure, vacated: found.vacated }),
        11 => Event::Done(Done::Safed { gate, tenure, attempt, safed: Safed { at: now } }),
        12 => Event::Done(Done::SeenOff { gate, at: now }),
        13 => Event::Done(Done::Admitted { gate, after: tenure, tenure: tenure + 1, ticket }),
        14 => Event::Done(Done::Blocked { gate, tenure, blocked: found.blocked }),
        _ => Event::Tick(now),
    }
}

fn found(random: &mut Random) -> Found {
    let now = Instant::from_micros(NOW.read() + random.below(1 << 20));
    let report = |gate| STAGE.broker().device(gate).and_then(|device| device.tenant);
    let gate = gate(random);
    let seen = Seen { epoch: 1 + usize::from(random.byte() & 1), floor: 0 };
    let mut faults = [None; faregate_agents::limits::MAX_GATES];
    faults[usize::from(gate.0)] = random.pick([None, Some(GateFault::Driver)]);
    let ticket = report(gate).unwrap_or(*NAMED.get());
    let tenure = usize::from(random.byte() & 3);
    Found {
        now,
        gate,
        ticket,
        estimate: Estimate { state: random.pick([Power::Off, Power::On]), measured_at: now },
        supply: Milliwatts::from_watts(u32::from(random.byte())),
        epoch: 1 + usize::from(random.byte() & 3),
        tenure,
        attempt: 1 + (random.byte() & 1),
        ends_ticket: random.flip(),
        seen,
        agents: [Seen { epoch: 1 + usize::from(random.byte() & 1), floor: 0 }; 8],
        faults,
        vacated: Vacated {
            tenure: tenure + 1,
            at: now,
            latest_tenant: ticket.serial,
            validity: Validity::always(),
            may_be_on: random.flip(),
        },
        blocked: random.pick([Blocked::Stale, Blocked::Hung]),
    }
}

fn set_up(seed: u64) {
    in_flight(&mut Random::new(seed));
}

entry!(books_step, |seed| set_up(seed), BOOKS.get_mut().step(EVENT.take(), ACTIONS.get_mut()));
entry!(books_work, |seed| set_up(seed), BOOKS.get().work());

// The same through the broker: what a program calls.
entry!(
    request,
    |seed| set_up(seed),
    ManuallyDrop::new(STAGE.broker().request(*PRIORITY.get(), STAGE.handles[0].get()))
);
entry!(relinquish, |seed| set_up(seed), drop(STAGE.ticket.take()));
entry!(
    extend,
    |seed| set_up(seed),
    ManuallyDrop::new(
        STAGE.broker().extend(STAGE.ticket(), &STAGE.handles[1].get().limited(Validity::always()))
    )
);
entry!(service, |seed| set_up(seed), STAGE.broker().service());
entry!(
    observe,
    |seed| set_up(seed),
    STAGE.broker().observe(FOUND.get().gate, FOUND.get().estimate)
);
entry!(
    leave_safe_mode,
    |seed| set_up(seed),
    STAGE.broker().leave_safe_mode(STAGE.supervisor.get())
);
entry!(hand_over_bound, |seed| set_up(seed), STAGE.broker().hand_over_bound(FOUND.get().gate, 2));
