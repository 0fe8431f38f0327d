//! What is behind a gate's lock: plain state, and the driver.

use crate::clock::{Clock, Instant};
use crate::device::Device;
use crate::fault::GateFault;
use crate::platform::{Containment, Platform};
use crate::recorder::{Counts, Lane, Record, RecordedEvent};
use crate::refusal::InvokeError;
use crate::validity::Validity;

use super::Published;

pub(crate) struct Inside<D, P: Platform> {
    driver: D,
    clock: P::Clock,
    lane: P::Lane,
    /// The latest instant read: the gate does not go back with its clock.
    latest: Instant,
    /// The number of the latest change of tenant.
    pub(super) tenure: usize,
    /// The tenure that the latest vacating was asked with, and when it was.
    pub(super) vacated: (usize, Instant),
    /// How often safing was tried in this tenure, and when last.
    pub(super) safed: (u8, Instant),
    /// The serial of the latest tenant.
    pub(super) latest_tenant: usize,
    /// Its validity function; after it left, as it left it.
    pub(super) validity: Validity,
    /// Whether a command turned the device on since it was last seen off.
    pub(super) may_be_on: bool,
    /// When the driver came back from the latest command to turn on.
    pub(super) turned_on: Instant,
}

impl<D: Device, P: Platform> Inside<D, P> {
    pub(super) fn new(driver: D, clock: P::Clock, lane: P::Lane) -> Self {
        let latest = clock.now();
        Self {
            driver,
            clock,
            lane,
            latest,
            tenure: 0,
            vacated: (0, latest),
            safed: (0, latest),
            latest_tenant: 0,
            validity: Validity::always(),
            may_be_on: true,
            turned_on: Instant::START,
        }
    }

    /// For a new key: the numbers of an earlier one mean nothing.
    pub(super) fn begin_anew(&mut self) {
        let now = self.now();
        self.tenure = 0;
        self.vacated = (0, now);
        self.safed = (0, now);
        self.latest_tenant = 0;
        self.validity = Validity::always();
        self.may_be_on = true;
    }

    /// The present instant, never before one that was read earlier.
    pub(super) fn now(&mut self) -> Instant {
        self.now_after(self.latest)
    }

    /// The present instant, never before `latest`, the one read last. Who still
    /// has that need not wait for it to come back from memory.
    pub(super) fn now_after(&mut self, latest: Instant) -> Instant {
        let now = self.clock.now();
        if now < latest {
            self.record(latest, 0, RecordedEvent::ClockWentBack);
        }
        self.latest = now.max(latest);
        self.latest
    }

    pub(super) fn record(&mut self, at: Instant, ticket: usize, event: RecordedEvent) {
        self.lane.record(Record { at, ticket, event });
    }

    /// Records what the ticket has counted, which begins to count anew.
    pub(super) fn record_counted(&mut self, at: Instant, ticket: usize, counts: &Counts) {
        // Most commands follow an admitted one: nothing to write back.
        if counts.get().is_empty() {
            return;
        }
        let [stored, refused] = counts.take().events();
        if let Some(event) = stored {
            self.record(at, ticket, event);
        }
        if let Some(event) = refused {
            self.record(at, ticket, event);
        }
    }

    pub(super) fn record_issued(&mut self, at: Instant, ticket: usize, code: u16) {
        self.record(at, ticket, RecordedEvent::Issued { code });
    }

    /// Makes the gate faulted, unless it is already.
    pub(super) fn close(&mut self, published: &Published, fault: GateFault) {
        if published.fault().is_none() {
            published.set_fault(Some(fault));
            self.record(self.latest, 0, RecordedEvent::Closed(fault));
        }
    }

    pub(super) fn issue(
        &mut self,
        published: &Published,
        command: D::Command,
    ) -> Result<D::Response, InvokeError<D::Fault>> {
        let unwinding = FaultIfUnwound(published);
        let result = P::Containment::contain(|| self.driver.issue(command));
        unwinding.disarm();
        match result {
            Ok(Ok(response)) => Ok(response),
            Ok(Err(fault)) => {
                self.close(published, GateFault::Driver);
                Err(InvokeError::Fault(fault))
            }
            Err(_) => {
                self.close(published, GateFault::Panicked);
                Err(InvokeError::Panicked)
            }
        }
    }

    /// Drains and safes. Whatever the driver makes of it, the attempt counts.
    pub(super) fn safe(&mut self, published: &Published) {
        let unwinding = FaultIfUnwound(published);
        let result = P::Containment::contain(|| {
            let drained = self.driver.drain();
            self.driver.safe().and(drained)
        });
        unwinding.disarm();
        match result {
            Ok(Ok(())) => {}
            Ok(Err(_)) => self.close(published, GateFault::Driver),
            Err(_) => self.close(published, GateFault::Panicked),
        }
    }
}

/// Faults the gate when a driver's panic passes through: without containment
/// the unwinding is all there is to notice it by.
struct FaultIfUnwound<'a>(&'a Published);

impl FaultIfUnwound<'_> {
    fn disarm(self) {
        let _ = core::mem::ManuallyDrop::new(self);
    }
}

impl Drop for FaultIfUnwound<'_> {
    fn drop(&mut self) {
        self.0.set_fault(Some(GateFault::Panicked));
    }
}
