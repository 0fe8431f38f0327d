//! Places for tasks: a task is a device without commands, behind a gate.
//!
//! Its draw and categories are those of the task that has the place. To make
//! the place safe is to stop the task: the place rings, and the manager, which
//! has seen the ticket go, stops the body. The sensor of a place is the manager
//! itself: it says *on* before the body can start, and *off* when the body
//! stands still.

use core::convert::Infallible;

use faregate_agents::{DeviceState, NotRedeclared, Redeclared};
use faregate_runtime::{Broker, Handle};
use faregate_tickets::Device;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Estimate, Power, Profile, WhenOrphaned};

use crate::executive::Waker;
use crate::manager::Needs;

/// What a place needs beside the grace of its task until it is known to be off:
/// the manager's thread has to hear of it.
const SLACK: Duration = Duration::from_secs(2);
/// How long a place may take to ring. It takes a system call; a thread that is
/// kept from the processor meanwhile must not make the gate faulted.
const RINGING_TIME_MAX: Duration = Duration::from_secs(1);

/// The device behind a place's gate.
#[derive(Debug)]
pub(super) struct Place(Waker);

impl Place {
    pub(super) fn new(waker: Waker) -> Self {
        Self(waker)
    }
}

impl Device for Place {
    type Command = Infallible;
    type Response = Infallible;
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        Profile {
            longest_command: RINGING_TIME_MAX,
            longest_safing: RINGING_TIME_MAX,
            estimate_lag: SLACK,
            when_orphaned: WhenOrphaned::SafeAtOnce,
            // The body dies with the manager: nothing outlives its holder here.
            lease: Duration::MAX,
            ..Profile::new()
        }
    }

    fn declare(command: &Infallible) -> Declaration {
        match *command {}
    }

    fn issue(&mut self, command: Infallible) -> Result<Infallible, Infallible> {
        match command {}
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        self.0.wake();
        Ok(())
    }
}

/// One place, as the port has it.
#[derive(Debug)]
pub(super) struct PlaceBook {
    pub(super) handle: Handle<Place>,
    /// When it was measured last: only a later measurement counts.
    measured_at: Instant,
    pub(super) state: PlaceState,
}

/// Whose a place is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlaceState {
    /// Nobody's, and known to be off.
    Free,
    /// An occurrence's, which holds its ticket or waits for it.
    Taken,
    /// Given back by a body that is over, and not known to be off yet.
    Leaving,
}

impl PlaceBook {
    /// Nobody has used it, and nobody has seen it off.
    pub(super) fn new(handle: Handle<Place>) -> Self {
        Self { handle, measured_at: Instant::START, state: PlaceState::Leaving }
    }

    /// Declares the place, which is free, as a task of these needs.
    pub(super) fn declare(&mut self, broker: &Broker, needs: &Needs) -> Result<(), NotRedeclared> {
        let declared = Redeclared {
            draw: needs.draw,
            categories: needs.categories,
            settling: Duration::ZERO,
            estimate_lag: needs.grace.saturating_add(SLACK),
        };
        let agents = broker.agents();
        agents.redeclare(&self.handle, &declared).or_else(|_| {
            // Off, but measured in the same unit of time as it was made safe.
            self.measure(broker, Power::Off);
            agents.redeclare(&self.handle, &declared)
        })
    }

    /// The body may run from now on: what it draws is charged until it is seen
    /// off, whatever becomes of its ticket.
    pub(super) fn see_on(&mut self, broker: &Broker) {
        self.measure(broker, Power::On);
    }

    /// The body stands still: what it drew is credited as soon as nobody has
    /// the place any more.
    pub(super) fn see_off(&mut self, broker: &Broker) {
        if self.device_state(broker) == DeviceState::Off {
            return;
        }
        self.measure(broker, Power::Off);
        if self.device_state(broker) == DeviceState::Confirming {
            // It was made safe in between, and only what is measured after that
            // says anything.
            self.measure(broker, Power::Off);
        }
    }

    /// Makes a place free that was given back, if it can be. While it is being
    /// vacated it cannot: it rings when it is made safe, which comes next.
    pub(super) fn free(&mut self, broker: &Broker) {
        if self.device_state(broker) == DeviceState::Leaving {
            return;
        }
        self.see_off(broker);
        if self.device_state(broker) == DeviceState::Off {
            self.state = PlaceState::Free;
        }
    }

    pub(super) fn is_off(&self, broker: &Broker) -> bool {
        self.device_state(broker) == DeviceState::Off
    }

    /// Where nobody can say, it counts as in use.
    fn device_state(&self, broker: &Broker) -> DeviceState {
        let report = broker.agents().device(self.handle.gate());
        report.map_or(DeviceState::Leaving, |report| report.state)
    }

    fn measure(&mut self, broker: &Broker, state: Power) {
        let clock = broker.clock();
        let mut now = clock.now();
        // At most the rest of one unit of the clock.
        while now <= self.measured_at {
            core::hint::spin_loop();
            now = clock.now();
        }
        self.measured_at = now;
        broker.observe(self.handle.gate(), Estimate { state, measured_at: now });
    }
}
