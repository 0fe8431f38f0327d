//! Validity functions: bounded functions with state that every invocation asks.
//!
//! A command is issued only if all functions of its ticket agree. All are
//! *checked*, and only then all *committed*: a refusal changes nothing, and a
//! command that the driver fails at counts like any other.
//!
//! | function | limits | of | is over for good |
//! |---|---|---|---|
//! | [`window`](Function::window), [`lease`](Function::lease) | authority | time | when its end has come |
//! | [`time_limit`](Function::time_limit) | authority | time since the first On command | when its end has come |
//! | [`invocations`](Function::invocations), [`rate`](Function::rate), [`separation`](Function::separation) | use | commands | never by itself |
//! | [`energy`](Function::energy), [`propellant`](Function::propellant) | use | what flows while the device is on | when it is used up |
//! | [`duty_cycle`](Function::duty_cycle) | use | the time that the device is on | never: the device rests |
//! | [`telemetry`](Function::telemetry), [`modes`](Function::modes), [`interlock`](Function::interlock) | use | the state of others | never by itself |
//!
//! Limits on *authority* refuse every command. Limits on *use* agree to every
//! [`Effect::Off`], and do not count it: turning
//! off only lessens a hazard.
//!
//! Commanding is not knowing: a device counts as on from its On command until
//! the agent has [seen it off](Validity::confirmed_off); the Off command alone
//! stops nothing. From then on a limit on use stands still (the rest of a duty
//! cycle is what that time is for). A limit in time runs on, whether its
//! ticket is valid or waits.
//!
//! The library is closed, so that the audit sees every function. Times come
//! with the [`Ask`], from the gate's clock. If they go back, nothing panics and
//! nothing that was used comes back.

mod authority;
mod budget;
mod condition;
mod count;
mod denial;
mod duty;
mod function;

pub use denial::{Denial, RanOut, Rule};
pub use duty::NoDutyCycle;
pub use function::Function;

use core::fmt;

use crate::amount::{Microjoules, Milligrams};
use crate::clock::{Duration, Instant};
use crate::device::Effect;
use crate::telemetry::Telemetry;

/// How many functions one validity can join.
pub const MAX_FUNCTIONS: usize = 4;

/// What a ticket's validity functions are asked.
#[derive(Clone, Copy, Debug)]
pub struct Ask<'a> {
    /// The time, read by the gate inside its critical section.
    pub now: Instant,
    /// What the command does.
    pub effect: Effect,
    /// What the spacecraft's state is believed to be. Without it nothing was
    /// measured, and the mode is none that a function could ask for.
    pub telemetry: Option<&'a Telemetry>,
}

/// Up to [`MAX_FUNCTIONS`] validity functions that all have to agree.
///
/// ```
/// use faregate_tickets::amount::{Microjoules, Milliwatts};
/// use faregate_tickets::clock::{Duration, Instant};
/// use faregate_tickets::device::Effect;
/// use faregate_tickets::validity::{Ask, Function, RanOut, Rule, Validity};
///
/// // An observation of at most a minute, for at most 100 J.
/// let mut validity = Validity::all_of(&[
///     Function::time_limit(Duration::from_secs(60)),
///     Function::energy(Microjoules::from_joules(100)),
/// ])?;
///
/// let on = Effect::on(Milliwatts::from_watts(10));
/// let turn_on = Ask { now: Instant::START, effect: on, telemetry: None };
/// validity.check(&turn_on)?;
/// // ... the gate commands the device ...
/// validity.commit(&turn_on);
///
/// // 10 W for 10 s are 100 J.
/// let early = Instant::START.after(Duration::from_micros(9_999_999));
/// let late = Instant::START.after(Duration::from_secs(10));
/// assert_eq!(validity.ran_out(early), None);
/// assert_eq!(validity.ran_out(late), Some(RanOut { rule: Rule::Energy, ends_ticket: true }));
///
/// let again = Ask { now: late, ..turn_on };
/// assert_eq!(validity.check(&again).map_err(|denial| denial.rule), Err(Rule::Energy));
/// assert_eq!(validity.check(&Ask { effect: Effect::Off, ..again }), Ok(()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Validity {
    /// Places without a function hold the one that always agrees.
    functions: [Function; MAX_FUNCTIONS],
}

impl Validity {
    /// No limit at all.
    #[must_use]
    pub const fn always() -> Self {
        Self { functions: [Function::always(); MAX_FUNCTIONS] }
    }

    /// Agrees when all of `functions` do.
    ///
    /// # Errors
    /// [`TooManyFunctions`] when more than [`MAX_FUNCTIONS`] of them limit
    /// anything.
    pub fn all_of(functions: &[Function]) -> Result<Self, TooManyFunctions> {
        functions.iter().try_fold(Self::always(), |joined, function| joined.and(*function))
    }

    /// Whether it limits nothing. Functions fill the places from the first on,
    /// so the first one tells.
    #[must_use]
    #[inline]
    pub const fn is_unlimited(&self) -> bool {
        let [first, ..] = &self.functions;
        first.is_always()
    }

    /// Agrees when this validity and `function` do.
    ///
    /// # Errors
    /// [`TooManyFunctions`] when there are [`MAX_FUNCTIONS`] already.
    pub fn and(mut self, function: Function) -> Result<Self, TooManyFunctions> {
        if function == Function::always() {
            return Ok(self);
        }
        let free = self.functions.iter_mut().find(|place| **place == Function::always());
        *free.ok_or(TooManyFunctions)? = function;
        Ok(self)
    }

    /// The energy that its commands can still use; nothing where no function
    /// limits it. Rounded down, as of the latest command or confirmation.
    ///
    /// Where several functions limit it, each of them counts the same use: the
    /// tightest is what is left.
    #[must_use]
    pub fn energy_left(&self) -> Microjoules {
        let left = self.functions.iter().filter_map(Function::energy_left);
        left.min().unwrap_or(Microjoules::ZERO)
    }

    /// The propellant that its commands can still use; nothing where no
    /// function limits it. See [`energy_left`](Self::energy_left).
    #[must_use]
    pub fn propellant_left(&self) -> Milligrams {
        let left = self.functions.iter().filter_map(Function::propellant_left);
        left.min().unwrap_or(Milligrams::ZERO)
    }

    /// How long its holder may be silent, where a lease says so.
    #[must_use]
    pub fn lease(&self) -> Option<Duration> {
        self.functions.iter().filter_map(Function::lease_period).min()
    }

    /// Whether the gate has to ask its interlock before a command that turns
    /// the device on.
    #[must_use]
    pub fn has_interlock(&self) -> bool {
        self.functions.contains(&Function::interlock())
    }

    /// When a device that ran out of its duty cycle, and was seen off, has
    /// rested enough.
    #[must_use]
    pub fn rests_until(&self) -> Option<Instant> {
        self.functions.iter().filter_map(Function::rests_until).max()
    }

    /// The ticket became valid, for the first time or again: its lease starts
    /// anew.
    ///
    /// # Timing
    /// Constant: no loop, division, lock or allocation.
    pub fn admitted(&mut self, now: Instant) {
        let [a, b, c, d] = &mut self.functions;
        a.admitted(now);
        b.admitted(now);
        c.admitted(now);
        d.admitted(now);
    }

    /// Whether all functions agree to this command. Changes nothing.
    ///
    /// # Errors
    /// The first function's [`Denial`].
    ///
    /// # Timing
    /// Constant: no loop, division, lock or allocation.
    #[inline]
    pub fn check(&self, ask: &Ask<'_>) -> Result<(), Denial> {
        if self.is_unlimited() { Ok(()) } else { self.check_each(ask) }
    }

    fn check_each(&self, ask: &Ask<'_>) -> Result<(), Denial> {
        let [a, b, c, d] = &self.functions;
        a.check(ask)?;
        if b.is_always() {
            return Ok(());
        }
        b.check(ask)?;
        c.check(ask)?;
        d.check(ask)
    }

    /// Counts a command to which all functions agreed and which the device is
    /// given, whatever its driver then says of it.
    ///
    /// # Timing
    /// Constant: no loop, division, lock or allocation.
    #[inline]
    pub fn commit(&mut self, ask: &Ask<'_>) {
        if !self.is_unlimited() {
            self.commit_each(ask);
        }
    }

    fn commit_each(&mut self, ask: &Ask<'_>) {
        let [a, b, c, d] = &mut self.functions;
        a.commit(ask);
        if b.is_always() {
            return;
        }
        b.commit(ask);
        c.commit(ask);
        d.commit(ask);
    }

    /// The holder lives: its lease starts anew. A lease that is over stays so.
    ///
    /// # Timing
    /// Constant: no loop, division, lock or allocation.
    pub fn renew(&mut self, now: Instant) {
        let [a, b, c, d] = &mut self.functions;
        a.renew(now);
        b.renew(now);
        c.renew(now);
        d.renew(now);
    }

    /// When to ask [`ran_out`](Self::ran_out) next, if nothing is commanded
    /// until then.
    ///
    /// Never late; early where the exact instant would cost a division: then
    /// at least half of the time that was left has passed, so that asking again
    /// converges. Nothing can run out where it says `None`.
    ///
    /// # Timing
    /// Constant: no loop, division, lock or allocation.
    #[must_use]
    #[inline]
    pub fn look_again_at(&self, now: Instant) -> Option<Instant> {
        if self.is_unlimited() { None } else { self.look_again_at_each(now) }
    }

    fn look_again_at_each(&self, now: Instant) -> Option<Instant> {
        let [a, b, c, d] = &self.functions;
        if b.is_always() {
            return a.look_again_at(now);
        }
        let first = earlier(a.look_again_at(now), b.look_again_at(now));
        earlier(first, earlier(c.look_again_at(now), d.look_again_at(now)))
    }

    /// Whether a limit has run out at `now`, so that the device has to go off
    /// without any further invocation. Exact.
    ///
    /// Conditions and counts do not run out: what they limit is the next
    /// command. Of several limits, one that ends the ticket is named.
    ///
    /// # Timing
    /// Constant: no loop, division, lock or allocation.
    #[must_use]
    pub fn ran_out(&self, now: Instant) -> Option<RanOut> {
        let [a, b, c, d] = &self.functions;
        let first = graver(a.ran_out(now), b.ran_out(now));
        graver(first, graver(c.ran_out(now), d.ran_out(now)))
    }

    /// Whether a limit has run out that no waiting brings back: a window that
    /// has closed, a budget that is used up. A lease begins anew with the
    /// ticket, so it does not count here.
    ///
    /// # Timing
    /// As [`Validity::ran_out`].
    #[must_use]
    pub fn has_ended(&self, now: Instant) -> bool {
        let ended = |function: &Function| {
            let ran_out = function.ran_out(now);
            ran_out.is_some_and(|limit| limit.ends_ticket && limit.rule != Rule::Lease)
        };
        let [a, b, c, d] = &self.functions;
        ended(a) || ended(b) || ended(c) || ended(d)
    }

    /// The agent saw the device off, by a measurement taken at `at`: use ends
    /// then. A measurement that is not later than the latest On command says
    /// nothing about it, and changes nothing.
    ///
    /// # Timing
    /// Constant: no loop, division, lock or allocation.
    pub fn confirmed_off(&mut self, at: Instant) {
        let [a, b, c, d] = &mut self.functions;
        a.confirmed_off(at);
        b.confirmed_off(at);
        c.confirmed_off(at);
        d.confirmed_off(at);
    }
}

impl From<Function> for Validity {
    fn from(function: Function) -> Self {
        let always = Function::always();
        Self { functions: [function, always, always, always] }
    }
}

fn earlier(one: Option<Instant>, other: Option<Instant>) -> Option<Instant> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (one, other) => one.or(other),
    }
}

fn graver(one: Option<RanOut>, other: Option<RanOut>) -> Option<RanOut> {
    match one {
        Some(RanOut { ends_ticket: false, .. }) => other.or(one),
        _ => one.or(other),
    }
}

/// The earliest instant at which `left` can be used up at `rate` per
/// microsecond; `now` where nothing is left.
///
/// Instead of a division by the rate, a shift by the next power of two: never
/// later than the truth, and not before half of the time.
fn soonest_end(left: u128, rate: u64, now: Instant) -> Instant {
    if left == 0 {
        return now;
    }
    let power = u64::BITS - rate.saturating_sub(1).leading_zeros();
    let micros = u64::try_from(left >> power).unwrap_or(u64::MAX);
    now.after(Duration::from_micros(micros.max(1)))
}

/// More functions were joined than [`MAX_FUNCTIONS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TooManyFunctions;

impl fmt::Display for TooManyFunctions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a validity joins at most {MAX_FUNCTIONS} functions")
    }
}

impl core::error::Error for TooManyFunctions {}
