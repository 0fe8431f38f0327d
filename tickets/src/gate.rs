//! Gates: the only place from which a device's commands reach the hardware.

mod control;
mod inside;
mod key;

use core::fmt;
use core::sync::atomic::AtomicU32;

use crate::clock::Instant;
use crate::device::{Declaration, Device, Effect, Profile};
use crate::fault::GateFault;
use crate::interlock::Member;
use crate::lock::{Exclusion, Next, Shut, Strategy, Task, Way};
use crate::platform::Platform;
use crate::recorder::Counts;
use crate::refusal::{InvokeError, Refusal};
use crate::sync::{AtomicUsize, Ordering};
use crate::telemetry::Telemetry;
use crate::ticket::Seat;

pub use control::{Admission, Blocked, Safed, Vacated};
use inside::Inside;
pub use key::{Handle, Key, KeyOf};

/// Owns the driver of one command group.
///
/// A gate yields its [`Key`] once: [`key`](Gate::key) borrows it mutably
/// for as long as the key lives. Only the key makes tickets, admits a tenant
/// and issues safing commands.
///
/// **One Tenant.** `tenant` holds one serial number. Admitting another replaces
/// it, so no policy can make two tickets of one gate valid together.
pub struct Gate<'t, D: Device, P: Platform> {
    profile: Profile,
    published: Published,
    telemetry: Option<&'t Telemetry>,
    interlock: Option<Member<'t>>,
    register: Option<&'static AtomicU32>,
    inside: LockOf<D, P>,
}

type LockOf<D, P> = <<P as Platform>::Strategy as Strategy>::Lock<Inside<D, P>>;

/// A ticket's way into its gate.
pub(crate) type WayOf<'g, D, P> = <LockOf<D, P> as Exclusion<Inside<D, P>>>::Way<'g>;

/// What can be looked at without the gate's lock.
#[derive(Debug)]
struct Published {
    /// The serial of the tenant; 0 for nobody. Written under the lock.
    tenant: AtomicUsize,
    /// The agent's epoch at which the tenant was admitted. Written under the
    /// lock.
    agent_stamp: AtomicUsize,
    /// When a limit of the tenant could run out; see [`Look`].
    look_again: AtomicUsize,
    /// The gate's fault, as a code.
    fault: AtomicUsize,
}

impl Published {
    fn new() -> Self {
        Self {
            tenant: AtomicUsize::new(0),
            agent_stamp: AtomicUsize::new(0),
            look_again: AtomicUsize::new(Look::NEVER),
            fault: AtomicUsize::new(0),
        }
    }

    fn fault(&self) -> Option<GateFault> {
        // Relaxed: whether a command in progress is over is told by the lock.
        GateFault::from_code(self.fault.load(Ordering::Relaxed))
    }

    fn set_fault(&self, fault: Option<GateFault>) {
        self.fault.store(GateFault::code(fault), Ordering::Relaxed);
    }

    fn set_look_again(&self, now: Instant, at: Option<Instant>) {
        // Relaxed: a hint. Whoever follows it looks again under the lock.
        self.look_again.store(Look::pack(now, at), Ordering::Relaxed);
    }

    fn look_again(&self, now: Instant) -> Option<Instant> {
        Look::unpack(now, self.look_again.load(Ordering::Relaxed))
    }
}

/// An instant in one native word: its low bits. It is published at most
/// [`Look::AHEAD`] before it comes, so the low bits of 32-bit targets suffice:
/// who arrives early looks again.
struct Look;

impl Look {
    const NEVER: usize = 0;
    /// 2^29 us, some nine minutes: well inside half of 2^32 us.
    const AHEAD: u64 = 1 << 29;

    fn pack(now: Instant, at: Option<Instant>) -> usize {
        let Some(at) = at else { return Self::NEVER };
        let latest = now.as_micros().saturating_add(Self::AHEAD);
        Self::low_bits(at.as_micros().min(latest)).max(1)
    }

    fn unpack(now: Instant, word: usize) -> Option<Instant> {
        if word == Self::NEVER {
            return None;
        }
        let ahead = word.wrapping_sub(Self::low_bits(now.as_micros()));
        // In the upper half it is in the past: due now.
        let due = ahead > usize::MAX / 2;
        let ahead = if due { 0 } else { ahead };
        Some(Instant::from_micros(now.as_micros().saturating_add(ahead as u64)))
    }

    #[expect(clippy::cast_possible_truncation, reason = "the low bits are what is meant")]
    const fn low_bits(us: u64) -> usize {
        us as usize
    }
}

impl<'t, D: Device, P: Platform> Gate<'t, D, P> {
    /// Moves the driver behind the gate.
    ///
    /// `lane` is the gate's own lane in the flight recorder.
    pub fn new(driver: D, clock: P::Clock, lane: P::Lane) -> Self {
        Self {
            profile: driver.profile(),
            published: Published::new(),
            telemetry: None,
            interlock: None,
            register: driver.register(),
            inside: Exclusion::new(Inside::new(driver, clock, lane)),
        }
    }

    /// The same gate, whose validity functions see these state variables.
    #[must_use]
    pub fn watching(mut self, telemetry: &'t Telemetry) -> Self {
        self.telemetry = Some(telemetry);
        self
    }

    /// The same gate, on one side of an interlock. Every command that turns
    /// its device on announces that there. What the device is at the start is
    /// not known: it is announced too, until it is seen off.
    #[must_use]
    pub fn interlocked(mut self, member: Member<'t>) -> Self {
        member.announce();
        self.interlock = Some(member);
        self
    }

    /// The gate's one key. A gate that was somebody's before begins anew: it
    /// admits nobody, and its device may be on.
    pub fn key<'g>(&'g mut self) -> KeyOf<'g, D, P> {
        self.published.tenant.store(0, Ordering::Relaxed);
        self.published.look_again.store(Look::NEVER, Ordering::Relaxed);
        // Nobody else has the gate, so nobody is inside, unless a thread died
        // there: then the next step that enters finds that out.
        let _ = self.inside.with(Inside::begin_anew);
        if let Some(member) = &self.interlock {
            member.announce();
        }
        KeyOf::new(self)
    }

    /// A way in for the ticket with this seat.
    pub(crate) fn way<'g>(&'g self, seat: &Seat<'g>) -> WayOf<'g, D, P> {
        self.inside.way(seat, self.profile.patience())
    }

    /// Does a command that is no more than its store, if that is in order on
    /// this way.
    pub(crate) fn store(&self, way: &WayOf<'_, D, P>, command: &D::Command) -> Option<D::Response> {
        let register = self.register?;
        let (word, response) = D::word(command)?;
        let declared = D::declare(command);
        let is_no_more = declared.effect == Effect::Unchanged && !self.exceeds_profile(&declared);
        // Who could not enter has faulted the gate without closing the way.
        let in_order = is_no_more && self.fault_code() == 0;
        (in_order && way.store(register, word)).then_some(response)
    }

    /// What the way keeps for a ticket that is refused is free for others.
    pub(crate) fn step_back(&self, way: &WayOf<'_, D, P>) {
        way.step_back();
    }

    /// Issues a command if `look`, made inside, and the validity function agree.
    pub(crate) fn invoke(
        &self,
        way: &WayOf<'_, D, P>,
        command: D::Command,
        counts: &Counts,
        look: impl Fn() -> Result<usize, Refusal>,
    ) -> Result<D::Response, InvokeError<D::Fault>> {
        if cfg!(feature = "mutant-try-lock") {
            return self.try_invoke(way, command, counts, look);
        }
        let look = self.looking_inside(look);
        way.with(look, Issue { gate: self, command, counts })
            .unwrap_or_else(|shut| Err(self.shut(shut)))?
    }

    /// Like [`Gate::invoke`], without waiting for anybody.
    pub(crate) fn try_invoke(
        &self,
        way: &WayOf<'_, D, P>,
        command: D::Command,
        counts: &Counts,
        look: impl Fn() -> Result<usize, Refusal>,
    ) -> Result<D::Response, InvokeError<D::Fault>> {
        let look = self.looking_inside(look);
        way.try_with(look, Issue { gate: self, command, counts })
            .unwrap_or_else(|shut| Err(self.shut(shut)))?
    }

    /// The look that counts. The mutant trusts the one before the lock.
    fn looking_inside(
        &self,
        look: impl Fn() -> Result<usize, Refusal>,
    ) -> impl Fn() -> Result<usize, Refusal> {
        move || {
            if cfg!(feature = "mutant-check-then-act") { Ok(self.tenant().0) } else { look() }
        }
    }

    /// Renews the tenant's lease if `look` agrees.
    pub(crate) fn renew(
        &self,
        way: &WayOf<'_, D, P>,
        look: impl Fn() -> Result<usize, Refusal>,
    ) -> Result<(), Refusal> {
        look().inspect_err(|_| way.step_back())?;
        let renewed = |inside: &mut Inside<D, P>, _| {
            let now = inside.now();
            let renewed = self.still_has_authority(inside, now);
            if renewed.is_ok() {
                inside.validity.renew(now);
                self.published.set_look_again(now, inside.validity.look_again_at(now));
            }
            (renewed, self.next(inside))
        };
        way.with(look, renewed).unwrap_or_else(|shut| Err(self.shut(shut)))?
    }

    /// Whether no limit has run out that service has yet to notice.
    fn still_has_authority(&self, inside: &Inside<D, P>, now: Instant) -> Result<(), Refusal> {
        if inside.validity.ran_out(now).is_none() {
            return Ok(());
        }
        // To turning off, only limits on authority object.
        let ask = crate::validity::Ask { now, effect: Effect::Off, telemetry: self.telemetry };
        inside.validity.check(&ask).map_err(Refusal::Denied)
    }

    /// Closed Door, Open Door and Empty Room meet here: look, check, issue and
    /// commit are one critical section. The look was made in it just before.
    // Always: see `Task`.
    #[inline(always)]
    fn issue(
        &self,
        inside: &mut Inside<D, P>,
        serial: usize,
        command: D::Command,
        counts: &Counts,
    ) -> (Result<D::Response, InvokeError<D::Fault>>, Next) {
        let declared = D::declare(&command);
        let started = match self.agree(inside, &declared) {
            Ok(now) => now,
            Err(refusal) => return (Err(refusal.into()), Next::Enter),
        };
        inside.record_counted(started, serial, counts);
        // Before the driver runs: one that unwinds was given it all the same.
        inside.record_issued(started, serial, declared.code);
        let result = inside.issue(&self.published, command);
        let ended = inside.now_after(started);
        #[cfg(not(feature = "mutant-turned-on-early"))]
        if let Effect::On { .. } = declared.effect {
            // What was measured while the driver ran may be from before it
            // reached the device.
            inside.turned_on = ended;
        }
        self.look_again_after(inside, started);
        self.check_duration(inside, ended.since(started), declared.wcet);
        (result, self.next(inside))
    }

    /// Stores may follow where nothing but the epochs can end the tenancy.
    fn next(&self, inside: &Inside<D, P>) -> Next {
        let in_order = self.register.is_some() && inside.validity.is_unlimited();
        if in_order && self.fault().is_none() { Next::Store } else { Next::Enter }
    }

    /// Checks every validity function, then commits every one. Counted before
    /// the driver runs, so that a driver which unwinds has used what it used;
    /// nobody can look in between. Answers the instant that was decided on.
    // Always, as `issue`: what is declared is constant where it is inlined.
    #[inline(always)]
    fn agree(&self, inside: &mut Inside<D, P>, declared: &Declaration) -> Result<Instant, Refusal> {
        if self.exceeds_profile(declared) {
            return Err(Refusal::Undeclared);
        }
        let effect = declared.effect;
        let now = inside.now();
        let ask = crate::validity::Ask { now, effect, telemetry: self.telemetry };
        inside.validity.check(&ask).map_err(Refusal::Denied)?;
        self.interlock_agrees(inside, effect)?;
        inside.validity.commit(&ask);
        if let Effect::On { .. } = effect {
            inside.may_be_on = true;
            inside.turned_on = now;
        }
        Ok(now)
    }

    /// The margin is charged by the profile, and the bound of a hand-over
    /// computed from it.
    fn exceeds_profile(&self, declared: &Declaration) -> bool {
        let slower = declared.wcet > self.profile.longest_command;
        let draws_more = match declared.effect {
            Effect::On { draw, flow } => draw > self.profile.draw || flow > self.profile.flow,
            Effect::Unchanged | Effect::Off => false,
        };
        slower || draws_more
    }

    fn interlock_agrees(&self, inside: &Inside<D, P>, effect: Effect) -> Result<(), Refusal> {
        let (Some(member), Effect::On { .. }) = (&self.interlock, effect) else { return Ok(()) };
        if inside.validity.has_interlock() {
            return member.enter().map_err(Refusal::Denied);
        }
        member.announce();
        Ok(())
    }

    /// Publishes when a limit could run out. Without limits nothing does, and
    /// the admission has said so.
    fn look_again_after(&self, inside: &Inside<D, P>, now: Instant) {
        if !inside.validity.is_unlimited() {
            self.published.set_look_again(now, inside.validity.look_again_at(now));
        }
    }

    fn check_duration(
        &self,
        inside: &mut Inside<D, P>,
        took: crate::clock::Duration,
        wcet: crate::clock::Duration,
    ) {
        if took > wcet.saturating_mul(u64::from(self.profile.overrun_factor.max(1))) {
            inside.close(&self.published, GateFault::Overran);
        }
    }

    /// What a locked gate's answer means for a holder.
    fn shut(&self, shut: Shut) -> Refusal {
        match shut {
            Shut::Busy | Shut::TimedOut => Refusal::Busy,
            Shut::Reentered => Refusal::Reentered,
            Shut::OwnerDied => {
                self.published.set_fault(Some(GateFault::OwnerDied));
                Refusal::Faulted(GateFault::OwnerDied)
            }
        }
    }

    /// What the gate itself has to say about a ticket: the tenant's serial and
    /// the agent's epoch with which it was admitted.
    pub(crate) fn tenant(&self) -> (usize, usize) {
        // Relaxed: written under the lock. The look that counts is made under
        // it; the one before it may refuse what is being admitted this instant.
        let tenant = self.published.tenant.load(Ordering::Relaxed);
        (tenant, self.published.agent_stamp.load(Ordering::Relaxed))
    }

    pub(crate) fn fault(&self) -> Option<GateFault> {
        self.published.fault()
    }

    /// The gate's fault, as a code; 0: none.
    pub(crate) fn fault_code(&self) -> usize {
        // Relaxed: as in `Published::fault`.
        self.published.fault.load(Ordering::Relaxed)
    }
}

/// Issuing a command, inside.
struct Issue<'a, 't, D: Device, P: Platform> {
    gate: &'a Gate<'t, D, P>,
    command: D::Command,
    counts: &'a Counts,
}

impl<D: Device, P: Platform> Task<Inside<D, P>, usize> for Issue<'_, '_, D, P> {
    type Output = Result<D::Response, InvokeError<D::Fault>>;

    #[inline(always)]
    fn run(self, inside: &mut Inside<D, P>, serial: usize) -> (Self::Output, Next) {
        self.gate.issue(inside, serial, self.command, self.counts)
    }
}

impl<D: Device, P: Platform> fmt::Debug for Gate<'_, D, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Gate").field("published", &self.published).finish_non_exhaustive()
    }
}
