//! The threads of control, each one interrupt: it runs to its end, unless a more
//! urgent one comes.
//!
//! | thread | interrupt | does |
//! |---|---|---|
//! | [`sensors`] | TIMER1 | measures, and raises the alarm |
//! | [`service`] | PendSV | what is due at the broker |
//! | [`rescuer`] | pended by the alarm, and when a ticket changes | shuts the cutoff valve |
//! | [`monitor`] | SysTick | keeps the camera on |

use core::cell::Cell;
use core::sync::atomic::{AtomicU32, Ordering};

use critical_section::Mutex;
use faregate_tickets::clock::{Clock, Instant};
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::id::{GateId, Priority};
use faregate_tickets::refusal::Refusal;

use crate::clock::CLOCK;
use crate::craft::{Camera, Craft, CutoffValve, TicketFor};
use crate::plant::PLANT;
use crate::sys;

/// What one interrupt has for itself. It is taken out while the interrupt runs:
/// no interrupt interrupts itself.
struct Own<T>(Mutex<Cell<Option<T>>>);

impl<T> Own<T> {
    const fn new() -> Self {
        Self(Mutex::new(Cell::new(None)))
    }

    fn put(&self, own: T) {
        critical_section::with(|masked| self.0.borrow(masked).set(Some(own)));
    }

    fn with(&self, f: impl FnOnce(&mut T)) {
        let own = critical_section::with(|masked| self.0.borrow(masked).take());
        // Before the threads are started there is nothing to do.
        let Some(mut own) = own else { return };
        f(&mut own);
        self.put(own);
    }
}

static SENSORS: Own<Sensors> = Own::new();
static SERVICE: Own<Service> = Own::new();
static RESCUER: Own<Rescuer> = Own::new();
static MONITOR: Own<Monitor> = Own::new();

/// Gives the threads what they work with.
pub(crate) fn start(craft: &'static Craft) {
    SENSORS.put(Sensors { craft, measured: None, alarmed: false, shut: false });
    SERVICE.put(Service { craft });
    RESCUER.put(Rescuer { craft, ticket: None });
    MONITOR.put(Monitor { craft, ticket: None });
}

/// Takes it from them, tickets included.
pub(crate) fn stop() {
    critical_section::with(|masked| {
        SENSORS.0.borrow(masked).take();
        SERVICE.0.borrow(masked).take();
    });
    let rescuer = critical_section::with(|masked| RESCUER.0.borrow(masked).take());
    let monitor = critical_section::with(|masked| MONITOR.0.borrow(masked).take());
    drop((rescuer, monitor));
}

/// When the service has something to do by itself.
static DUE: Mutex<Cell<Option<Instant>>> = Mutex::new(Cell::new(None));

struct Sensors {
    craft: &'static Craft,
    /// What was measured a period ago: sensors take their time.
    measured: Option<[(GateId, Estimate); 2]>,
    alarmed: bool,
    shut: bool,
}

/// Periods of the sensors since the service last came to its end.
static BEHIND: AtomicU32 = AtomicU32::new(0);
/// More of them mean that the processor is too slow for its interrupts.
const MOST_BEHIND: u32 = 3;

pub(crate) fn sensors() {
    SENSORS.with(|own| {
        PLANT.pass();
        for (gate, estimate) in own.measured.take().into_iter().flatten() {
            own.craft.broker.observe(gate, estimate);
        }
        own.measured = Some(own.measure());
        own.raise_the_alarm();
        let due = critical_section::with(|masked| DUE.borrow(masked).get());
        if due.is_some_and(|due| due <= CLOCK.now()) {
            sys::pend_service();
        }
        // Relaxed: on one core, and nothing else hangs on it.
        if BEHIND.fetch_add(1, Ordering::Relaxed) > MOST_BEHIND {
            crate::give_up("the service keeps up with the sensors");
        }
    });
}

impl Sensors {
    fn measure(&self) -> [(GateId, Estimate); 2] {
        let measured_at = CLOCK.now();
        let (camera, coil) = PLANT.measure();
        let estimate = |state: Power| Estimate { state, measured_at };
        [(self.craft.camera.gate(), estimate(camera)), (self.craft.valve.gate(), estimate(coil))]
    }

    /// Wakes the rescuer when the spin begins and when it has ended.
    fn raise_the_alarm(&mut self) {
        let (alarmed, shut) = (PLANT.alarm(), PLANT.is_shut());
        if (alarmed && !self.alarmed) || (shut && !self.shut) {
            sys::pend_rescuer();
        }
        (self.alarmed, self.shut) = (alarmed, shut);
    }
}

struct Service {
    craft: &'static Craft,
}

pub(crate) fn service() {
    SERVICE.with(|own| {
        let due = own.craft.broker.service();
        critical_section::with(|masked| DUE.borrow(masked).set(due));
        BEHIND.store(0, Ordering::Relaxed);
    });
}

/// The emergency: it knows nothing of cameras.
struct Rescuer {
    craft: &'static Craft,
    ticket: Option<TicketFor<CutoffValve>>,
}

pub(crate) fn rescuer() {
    RESCUER.with(|own| {
        if PLANT.alarm() {
            own.shut_the_valve();
        } else if PLANT.is_shut() && !cfg!(feature = "break-restoration") {
            // Dropped: relinquished. The coil is made safe by the service.
            own.ticket = None;
        }
    });
}

impl Rescuer {
    fn shut_the_valve(&mut self) {
        let broker = self.craft.broker;
        if self.ticket.is_none() {
            self.ticket = broker.request(Priority::EMERGENCY, &self.craft.valve).ok();
        }
        // Whoever waits may do what is due, at its own priority.
        broker.service();
        if let Some(ticket) = &self.ticket {
            // Refused, it is pended when the ticket changes.
            let _ = ticket.invoke(true);
        }
    }
}

/// The camera's monitor: it knows nothing of emergencies. To it, a camera that
/// is off is an anomaly.
struct Monitor {
    craft: &'static Craft,
    ticket: Option<TicketFor<Camera>>,
}

/// What became of the monitor's commands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tally {
    pub(crate) obeyed: u32,
    pub(crate) refused: u32,
    /// The first refusal.
    pub(crate) why: Option<Refusal>,
}

const NOTHING: Tally = Tally { obeyed: 0, refused: 0, why: None };
static TALLY: Mutex<Cell<Tally>> = Mutex::new(Cell::new(NOTHING));

pub(crate) fn monitor() {
    MONITOR.with(|own| {
        if own.ticket.is_none() {
            own.ticket = own.craft.broker.request(Priority::SCIENCE, &own.craft.camera).ok();
        }
        let Some(ticket) = &own.ticket else { return };
        let result = ticket.invoke(true);
        let mut tally = tally();
        match result {
            Ok(()) => tally.obeyed += 1,
            Err(error) => {
                tally.refused += 1;
                tally.why = tally.why.or(error.refusal());
            }
        }
        critical_section::with(|masked| TALLY.borrow(masked).set(tally));
    });
}

/// What became of the monitor's commands since they were last counted anew.
pub(crate) fn tally() -> Tally {
    critical_section::with(|masked| TALLY.borrow(masked).get())
}

/// Counts the monitor's commands anew.
pub(crate) fn forget_tally() {
    critical_section::with(|masked| TALLY.borrow(masked).set(NOTHING));
}
