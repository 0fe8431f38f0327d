//! What the holder of the key can do to a gate, whatever its device is.
//!
//! Each step is named by the tenure (and attempt) that it follows. A step that
//! somebody else has done already answers the same again; one that comes too
//! late is *stale* and does nothing. So a step needs no owner: whoever finds it
//! due does it, and a thread that stalls in the middle of one delays nobody.

use crate::clock::{Duration, Instant};
use crate::device::{Device, Profile};
use crate::fault::GateFault;
use crate::lock::{Exclusion, Owner, Shut};
use crate::platform::Platform;
use crate::recorder::RecordedEvent;
use crate::standing::{Stamp, Standing};
use crate::sync::Ordering;
use crate::validity::{RanOut, Validity};

use super::inside::Inside;
use super::{Gate, Look};

/// Why a step on a gate was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Blocked {
    /// The gate has moved on: the step came too late.
    Stale,
    /// The command in progress did not come back in time. The gate is faulted.
    Hung,
    /// The calling thread is inside a command of this gate.
    Reentered,
}

/// The gate admits nobody, and no command is in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Vacated {
    /// The number of this change of tenant.
    pub tenure: usize,
    /// When it happened.
    pub at: Instant,
    /// The serial of the latest tenant; 0 if there was none yet. A ticket that
    /// was put out before it was admitted is not it.
    pub latest_tenant: usize,
    /// The latest tenant's validity function, with its state.
    pub validity: Validity,
    /// Whether a command turned the device on since it was last seen off.
    pub may_be_on: bool,
}

/// The safing command was given to the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Safed {
    /// When the driver came back from it.
    pub at: Instant,
}

/// What makes a ticket the tenant of a gate.
#[derive(Clone, Copy, Debug)]
pub struct Admission<'a> {
    /// The serial of the grant.
    pub serial: usize,
    /// The tenure after which it follows.
    pub tenure: usize,
    /// The agent's epoch, as read before the decision.
    pub agent: usize,
    /// The validity function, with its state.
    pub validity: Validity,
    /// For the last (or only) gate of the grant: what makes all of it valid.
    pub stamp: Option<(&'a Standing, Stamp)>,
}

impl Admission<'_> {
    fn stamp(&self) {
        if let Some((standing, stamp)) = self.stamp {
            standing.stamp(stamp);
        }
    }
}

pub(crate) trait Control: Sync {
    fn profile(&self) -> &Profile;
    fn fault(&self) -> Option<GateFault>;
    fn look_again(&self, now: Instant) -> Option<Instant>;
    fn vacate(&self, tenure: usize, timeout: Duration) -> Result<Vacated, Blocked>;
    fn safe(&self, tenure: usize, attempt: u8, timeout: Duration) -> Result<Safed, Blocked>;
    fn admit(&self, admission: Admission<'_>, timeout: Duration) -> Result<usize, Blocked>;
    fn seen_off(&self, tenure: usize, at: Instant, timeout: Duration) -> Result<(), Blocked>;
    fn ran_out(&self, serial: usize, timeout: Duration) -> Option<RanOut>;
    fn pass(&self, timeout: Duration) -> Result<(), Blocked>;
    fn reopen(&self);
}

impl<D: Device, P: Platform> Gate<'_, D, P> {
    /// Enters for the agent: after an owner's death too, and to a deadline.
    fn enter<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut Inside<D, P>) -> Result<R, Blocked>,
    ) -> Result<R, Blocked> {
        let entered = self.inside.with_until(timeout, |inside, owner| {
            if owner == Owner::Died {
                inside.close(&self.published, GateFault::OwnerDied);
            }
            f(inside)
        });
        entered.unwrap_or_else(|shut| Err(self.blocked(shut)))
    }

    fn blocked(&self, shut: Shut) -> Blocked {
        if shut == Shut::Reentered {
            return Blocked::Reentered;
        }
        if self.published.fault().is_none() {
            self.published.set_fault(Some(GateFault::Hung));
        }
        Blocked::Hung
    }
}

impl<D: Device, P: Platform> Control for Gate<'_, D, P> {
    fn profile(&self) -> &Profile {
        &self.profile
    }

    fn fault(&self) -> Option<GateFault> {
        self.published.fault()
    }

    fn look_again(&self, now: Instant) -> Option<Instant> {
        self.published.look_again(now)
    }

    fn vacate(&self, tenure: usize, timeout: Duration) -> Result<Vacated, Blocked> {
        self.enter(timeout, |inside| {
            let tenant = self.tenant().0;
            let done = tenant == 0 && inside.vacated.0 == tenure && inside.tenure != tenure;
            if !done {
                // A late admission may have come in between: it is not valid
                // any more, and leaves with the rest.
                let admitted_since = tenant != 0 && inside.tenure == tenure.wrapping_add(1);
                if inside.tenure != tenure && !admitted_since {
                    return Err(Blocked::Stale);
                }
                self.put_out(inside, tenure);
            }
            Ok(Vacated {
                tenure: inside.tenure,
                at: inside.vacated.1,
                latest_tenant: inside.latest_tenant,
                validity: inside.validity,
                may_be_on: inside.may_be_on,
            })
        })
    }

    fn safe(&self, tenure: usize, attempt: u8, timeout: Duration) -> Result<Safed, Blocked> {
        self.enter(timeout, |inside| {
            #[cfg(not(feature = "mutant-late-safing"))]
            if inside.tenure != tenure {
                return Err(Blocked::Stale);
            }
            #[cfg(feature = "mutant-late-safing")]
            let _ = tenure;
            let (tried, at) = inside.safed;
            if tried == attempt {
                return Ok(Safed { at });
            }
            #[cfg(not(feature = "mutant-late-safing"))]
            if tried.wrapping_add(1) != attempt {
                return Err(Blocked::Stale);
            }
            // Counted before the driver runs: one that unwinds has had it.
            inside.safed = (attempt, inside.now());
            inside.safe(&self.published);
            let at = inside.now();
            inside.safed = (attempt, at);
            inside.record(at, 0, RecordedEvent::Safed { attempt });
            Ok(Safed { at })
        })
    }

    fn admit(&self, admission: Admission<'_>, timeout: Duration) -> Result<usize, Blocked> {
        let admitted = self.enter(timeout, |inside| {
            let next = admission.tenure.wrapping_add(1);
            if self.tenant().0 == admission.serial && inside.tenure == next {
                return Ok(next);
            }
            if inside.tenure != admission.tenure {
                return Err(Blocked::Stale);
            }
            self.let_in(inside, &admission);
            Ok(next)
        });
        #[cfg(feature = "mutant-stamp-outside")]
        admission.stamp();
        admitted
    }

    fn seen_off(&self, tenure: usize, at: Instant, timeout: Duration) -> Result<(), Blocked> {
        self.enter(timeout, |inside| {
            if inside.tenure != tenure {
                return Err(Blocked::Stale);
            }
            // Measured before the last command to turn on had its effect: it
            // says nothing about now.
            if at <= inside.turned_on.after(self.profile.settling) {
                return Ok(());
            }
            inside.may_be_on = false;
            inside.validity.confirmed_off(at);
            if let Some(member) = &self.interlock {
                member.withdraw();
            }
            Ok(())
        })
    }

    fn ran_out(&self, serial: usize, timeout: Duration) -> Option<RanOut> {
        let look = self.enter(timeout, |inside| {
            if self.tenant().0 != serial {
                return Err(Blocked::Stale);
            }
            let now = inside.now();
            self.published.set_look_again(now, inside.validity.look_again_at(now));
            Ok(inside.validity.ran_out(now))
        });
        look.ok().flatten()
    }

    fn pass(&self, timeout: Duration) -> Result<(), Blocked> {
        #[cfg(feature = "mutant-no-quiescence")]
        return Ok(());
        #[cfg(not(feature = "mutant-no-quiescence"))]
        self.enter(timeout, |_| Ok(()))
    }

    fn reopen(&self) {
        self.published.set_fault(None);
    }
}

impl<D: Device, P: Platform> Gate<'_, D, P> {
    fn put_out(&self, inside: &mut Inside<D, P>, asked: usize) {
        let at = inside.now();
        // Relaxed: under the lock, as every write of the tenant.
        self.published.tenant.store(0, Ordering::Relaxed);
        self.published.look_again.store(Look::NEVER, Ordering::Relaxed);
        inside.tenure = inside.tenure.wrapping_add(1);
        inside.vacated = (asked, at);
        inside.safed = (0, at);
        let tenure = inside.tenure;
        inside.record(at, 0, RecordedEvent::Vacated { tenure });
    }

    fn let_in(&self, inside: &mut Inside<D, P>, admission: &Admission<'_>) {
        let now = inside.now();
        inside.tenure = admission.tenure.wrapping_add(1);
        inside.safed = (0, now);
        inside.latest_tenant = admission.serial;
        inside.validity = admission.validity;
        inside.validity.admitted(now);
        self.published.set_look_again(now, inside.validity.look_again_at(now));
        // Relaxed: under the lock. Stamps are what was read before the
        // decision (Late Epoch Invariant), and go in under the lock too: a
        // late one would undo a later admission.
        self.published.agent_stamp.store(admission.agent, Ordering::Relaxed);
        self.published.tenant.store(admission.serial, Ordering::Relaxed);
        #[cfg(not(feature = "mutant-stamp-outside"))]
        admission.stamp();
        let tenure = inside.tenure;
        inside.record(now, admission.serial, RecordedEvent::Admitted { tenure });
    }
}
