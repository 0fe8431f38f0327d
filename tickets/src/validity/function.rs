//! The closed library: what a validity function can be.

use core::ops::RangeInclusive;

use super::authority::{Lease, TimeLimit, Window};
use super::budget::Budget;
use super::condition::{InModes, InRange};
use super::count::{Invocations, Rate, Separation};
use super::duty::{DutyCycle, NoDutyCycle};
use super::{Ask, Denial, RanOut, Rule};
use crate::amount::{Microjoules, Milligrams};
use crate::clock::{Duration, Instant};
use crate::device::Effect;
use crate::telemetry::{Channel, Modes};

/// One validity function. Its constructors are the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Function(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Always,
    /// Carried out by the gate, which has the interlock.
    Interlock,
    Window(Window),
    TimeLimit(TimeLimit),
    Lease(Lease),
    Invocations(Invocations),
    Rate(Rate),
    Separation(Separation),
    DutyCycle(DutyCycle),
    Energy(Budget<NANOJOULES>),
    Propellant(Budget<NANOGRAMS>),
    InRange(InRange),
    InModes(InModes),
}

/// A milliwatt for a microsecond is a nanojoule; a thousand are a microjoule.
const NANOJOULES: u64 = 1_000;
/// A milligram per second for a microsecond is a nanogram; a million are a
/// milligram.
const NANOGRAMS: u64 = 1_000_000;

impl Function {
    /// Always agrees.
    #[must_use]
    pub const fn always() -> Self {
        Self(Kind::Always)
    }

    /// Agrees to commands from `from` on and before `until`.
    #[must_use]
    pub const fn window(from: Instant, until: Instant) -> Self {
        Self(Kind::Window(Window::new(from, until)))
    }

    /// Ends the ticket this long after the first command that turns the device
    /// on. Pre-emption does not stop it: it is a limit in time.
    #[must_use]
    pub const fn time_limit(limit: Duration) -> Self {
        Self(Kind::TimeLimit(TimeLimit::new(limit)))
    }

    /// Ends the ticket when its holder has been silent for `period`. Any
    /// admitted command renews it, and so does
    /// [`Ticket::renew`](crate::Ticket::renew). It runs from the moment
    /// when the ticket becomes valid.
    #[must_use]
    pub const fn lease(period: Duration) -> Self {
        Self(Kind::Lease(Lease::new(period)))
    }

    /// Agrees to `n` commands.
    #[must_use]
    pub const fn invocations(n: u32) -> Self {
        Self(Kind::Invocations(Invocations::new(n)))
    }

    /// Agrees to one command per `period`, and to `burst` at once after a
    /// pause. A burst of none never agrees.
    #[must_use]
    pub const fn rate(burst: u32, period: Duration) -> Self {
        Self(Kind::Rate(Rate::new(burst, period)))
    }

    /// Agrees when the last command is at least `min` ago.
    #[must_use]
    pub const fn separation(min: Duration) -> Self {
        Self(Kind::Separation(Separation::new(min)))
    }

    /// Lets the device be on for `on` in every `period`, on average, and never
    /// longer than `on` without a break: a bucket of on-time that empties while
    /// the device is on, and fills up in `period - on` of rest. A device that
    /// empties it has to rest for that long before it may be turned on again.
    ///
    /// A bucket, not a sliding window: a full one may be emptied at the end of
    /// one period and again in the next, so that any one period can see almost
    /// twice `on`.
    ///
    /// # Errors
    /// [`NoDutyCycle`] unless `on` is more than nothing and less than `period`.
    pub const fn duty_cycle(on: Duration, period: Duration) -> Result<Self, NoDutyCycle> {
        match DutyCycle::new(on, period) {
            Ok(cycle) => Ok(Self(Kind::DutyCycle(cycle))),
            Err(no_duty_cycle) => Err(no_duty_cycle),
        }
    }

    /// Lets the device use this much energy while on, by what its commands
    /// declare. A budget beyond 18 GJ is held to that.
    #[must_use]
    pub const fn energy(budget: Microjoules) -> Self {
        Self(Kind::Energy(Budget::new(budget.get())))
    }

    /// Lets the device use this much propellant while on, by what its commands
    /// declare. A budget beyond 18 000 t is held to that.
    #[must_use]
    pub const fn propellant(budget: Milligrams) -> Self {
        Self(Kind::Propellant(Budget::new(budget.get())))
    }

    /// Agrees while the other side of the gate's
    /// [interlock](crate::interlock::Interlock) is certain to be off.
    #[must_use]
    pub const fn interlock() -> Self {
        Self(Kind::Interlock)
    }

    /// Agrees while the latest value of `channel` lies in `range` and was
    /// measured at most `max_age` ago.
    #[must_use]
    pub const fn telemetry(
        channel: Channel,
        range: RangeInclusive<i32>,
        max_age: Duration,
    ) -> Self {
        Self(Kind::InRange(InRange::new(channel, *range.start(), *range.end(), max_age)))
    }

    /// Agrees while the spacecraft is in one of these modes.
    #[must_use]
    pub const fn modes(modes: Modes) -> Self {
        Self(Kind::InModes(InModes::new(modes)))
    }

    #[inline]
    pub(super) const fn is_always(&self) -> bool {
        matches!(self.0, Kind::Always)
    }

    /// Whether it limits who may command, and so turning off as well.
    const fn limits_authority(&self) -> bool {
        matches!(self.0, Kind::Window(_) | Kind::TimeLimit(_) | Kind::Lease(_))
    }

    /// A limit on use does not look at a command that turns the device off.
    fn overlooks(&self, ask: &Ask<'_>) -> bool {
        ask.effect == Effect::Off && !self.limits_authority()
    }

    pub(super) fn check(&self, ask: &Ask<'_>) -> Result<(), Denial> {
        if self.overlooks(ask) {
            return Ok(());
        }
        match &self.0 {
            Kind::Always | Kind::Interlock => Ok(()),
            Kind::Window(window) => window.check(ask.now),
            Kind::TimeLimit(limit) => limit.check(ask.now),
            Kind::Lease(lease) => lease.check(ask.now),
            Kind::Invocations(invocations) => invocations.check(),
            Kind::Rate(rate) => rate.check(ask.now),
            Kind::Separation(separation) => separation.check(ask.now),
            Kind::DutyCycle(cycle) => cycle.check(ask.now),
            Kind::Energy(budget) => budget.check(Rule::Energy, ask.now),
            Kind::Propellant(budget) => budget.check(Rule::Propellant, ask.now),
            Kind::InRange(range) => range.check(ask),
            Kind::InModes(modes) => modes.check(ask),
        }
    }

    pub(super) fn commit(&mut self, ask: &Ask<'_>) {
        if self.overlooks(ask) {
            return;
        }
        match &mut self.0 {
            Kind::TimeLimit(limit) => limit.commit(ask),
            Kind::Lease(lease) => lease.renew(ask.now),
            Kind::Invocations(invocations) => invocations.commit(),
            Kind::Rate(rate) => rate.commit(ask.now),
            Kind::Separation(separation) => separation.commit(ask.now),
            Kind::DutyCycle(cycle) => cycle.commit(ask),
            Kind::Energy(budget) => {
                if let Effect::On { draw, .. } = ask.effect {
                    budget.turn_on(draw.get(), ask.now);
                }
            }
            Kind::Propellant(budget) => {
                if let Effect::On { flow, .. } = ask.effect {
                    budget.turn_on(flow.get(), ask.now);
                }
            }
            Kind::Always
            | Kind::Interlock
            | Kind::Window(_)
            | Kind::InRange(_)
            | Kind::InModes(_) => {}
        }
    }

    pub(super) fn look_again_at(&self, now: Instant) -> Option<Instant> {
        match &self.0 {
            Kind::Window(window) => Some(window.end()),
            Kind::TimeLimit(limit) => limit.end(),
            Kind::Lease(lease) => Some(lease.end()),
            Kind::DutyCycle(cycle) => cycle.look_again_at(now),
            Kind::Energy(budget) => budget.look_again_at(now),
            Kind::Propellant(budget) => budget.look_again_at(now),
            Kind::Always
            | Kind::Interlock
            | Kind::Invocations(_)
            | Kind::Rate(_)
            | Kind::Separation(_)
            | Kind::InRange(_)
            | Kind::InModes(_) => None,
        }
    }

    pub(super) fn ran_out(&self, now: Instant) -> Option<RanOut> {
        let ends = |over: bool, rule| over.then_some(RanOut::ends(rule));
        match &self.0 {
            Kind::Window(window) => ends(window.is_over(now), Rule::Window),
            Kind::TimeLimit(limit) => ends(limit.is_over(now), Rule::TimeLimit),
            Kind::Lease(lease) => ends(lease.is_over(now), Rule::Lease),
            Kind::Energy(budget) => ends(budget.is_used_up(now), Rule::Energy),
            Kind::Propellant(budget) => ends(budget.is_used_up(now), Rule::Propellant),
            Kind::DutyCycle(cycle) => cycle.ran_out(now),
            Kind::Always
            | Kind::Interlock
            | Kind::Invocations(_)
            | Kind::Rate(_)
            | Kind::Separation(_)
            | Kind::InRange(_)
            | Kind::InModes(_) => None,
        }
    }

    pub(super) fn confirmed_off(&mut self, at: Instant) {
        match &mut self.0 {
            Kind::DutyCycle(cycle) => cycle.confirmed_off(at),
            Kind::Energy(budget) => budget.confirmed_off(at),
            Kind::Propellant(budget) => budget.confirmed_off(at),
            _ => {}
        }
    }

    pub(super) fn admitted(&mut self, now: Instant) {
        if let Kind::Lease(lease) = &mut self.0 {
            lease.start(now);
        }
    }

    pub(super) fn renew(&mut self, now: Instant) {
        if let Kind::Lease(lease) = &mut self.0 {
            lease.renew(now);
        }
    }

    pub(super) fn energy_left(&self) -> Option<Microjoules> {
        match &self.0 {
            Kind::Energy(budget) => Some(Microjoules::new(budget.left())),
            _ => None,
        }
    }

    pub(super) fn propellant_left(&self) -> Option<Milligrams> {
        match &self.0 {
            Kind::Propellant(budget) => Some(Milligrams::new(budget.left())),
            _ => None,
        }
    }

    pub(super) fn lease_period(&self) -> Option<Duration> {
        match &self.0 {
            Kind::Lease(lease) => Some(lease.period()),
            _ => None,
        }
    }

    pub(super) fn rests_until(&self) -> Option<Instant> {
        match &self.0 {
            Kind::DutyCycle(cycle) => cycle.rests_until(),
            _ => None,
        }
    }
}
