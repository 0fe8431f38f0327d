//! Devices with a truth: what they draw, and what their sensors can show.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::Relaxed};
use std::thread_local;

use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Device, Effect, Power, Profile};
use faregate_tickets::lock::{Exclusion, Owner, Shut, Strategy};
use faregate_tickets::recorder::NoLane;
use faregate_tickets::ticket::Seat;

pub(crate) type Platform<'w> = (Alone, &'w Hands, NoLane);

/// A clock whose hands the history moves.
#[derive(Debug, Default)]
pub(crate) struct Hands(AtomicU64);

impl Hands {
    pub(crate) fn advance(&self, by: Duration) {
        self.0.fetch_add(by.as_micros(), Relaxed);
    }
}

impl Clock for Hands {
    fn now(&self) -> Instant {
        Instant::from_micros(self.0.load(Relaxed))
    }
}

/// What is true of a lamp. Its draw begins with the On command and ends when
/// it has settled after an Off; its sensor shows either only then.
#[derive(Debug)]
pub(crate) struct Truth {
    pub(crate) profile: Profile,
    pub(crate) deaf_to_safing: AtomicU32,
    /// On by nobody's command.
    pub(crate) unbidden: AtomicBool,
    pub(crate) hung: AtomicBool,
    on: AtomicBool,
    changed_at: AtomicU64,
    drew: AtomicBool,
    showed: AtomicBool,
}

impl Truth {
    pub(crate) fn new(profile: Profile, on: bool) -> Self {
        Self {
            profile,
            deaf_to_safing: AtomicU32::new(0),
            unbidden: AtomicBool::new(false),
            hung: AtomicBool::new(false),
            on: AtomicBool::new(on),
            changed_at: AtomicU64::new(0),
            drew: AtomicBool::new(on),
            showed: AtomicBool::new(on),
        }
    }

    pub(crate) fn turn(&self, on: bool, now: Instant) {
        self.drew.store(self.draws(now), Relaxed);
        self.showed.store(self.shows(now) == Power::On, Relaxed);
        self.on.store(on, Relaxed);
        self.changed_at.store(now.as_micros(), Relaxed);
        // What nobody turned on still draws while it settles.
        self.unbidden.fetch_and(!on, Relaxed);
    }

    fn has_settled(&self, now: Instant) -> bool {
        let changed_at = Instant::from_micros(self.changed_at.load(Relaxed));
        now >= changed_at.after(self.profile.settling)
    }

    pub(crate) fn draws(&self, now: Instant) -> bool {
        self.on.load(Relaxed) || (!self.has_settled(now) && self.drew.load(Relaxed))
    }

    pub(crate) fn shows(&self, now: Instant) -> Power {
        let on = if self.has_settled(now) { &self.on } else { &self.showed };
        if on.load(Relaxed) { Power::On } else { Power::Off }
    }
}

#[derive(Debug)]
pub(crate) struct Lamp<'w> {
    pub(crate) truth: &'w Truth,
    pub(crate) clock: &'w Hands,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    On,
    Off,
    Fault,
}

impl Device for Lamp<'_> {
    type Command = Switch;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        self.truth.profile
    }

    fn declare(command: &Switch) -> Declaration {
        let effect = match command {
            Switch::On => Effect::on(faregate_tickets::amount::Milliwatts::new(1)),
            Switch::Off => Effect::Off,
            Switch::Fault => Effect::Unchanged,
        };
        Declaration { code: *command as u16, wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, command: Switch) -> Result<(), ()> {
        match command {
            Switch::On => self.truth.turn(true, self.clock.now()),
            Switch::Off => self.truth.turn(false, self.clock.now()),
            Switch::Fault => return Err(()),
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        let deaf = &self.truth.deaf_to_safing;
        if deaf.load(Relaxed) > 0 {
            deaf.fetch_sub(1, Relaxed);
        } else {
            self.truth.turn(false, self.clock.now());
        }
        Ok(())
    }
}

thread_local! {
    /// Whether the gate that is entered next has a command that does not come
    /// back.
    static HUNG: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Runs `f` while the gates that it enters hang, or do not.
pub(crate) fn with_hung<R>(hung: bool, f: impl FnOnce() -> R) -> R {
    HUNG.set(hung);
    let result = f();
    HUNG.set(false);
    result
}

/// The strategy of a world with one thread.
#[derive(Debug)]
pub(crate) struct Alone;

impl Strategy for Alone {
    type Lock<T: Send> = AloneLock<T>;
}

#[derive(Debug)]
pub(crate) struct AloneLock<T>(parking_lot::Mutex<T>);

impl<T: Send> Exclusion<T> for AloneLock<T> {
    type Way<'l>
        = &'l Self
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, _: Duration) -> &'l Self {
        self
    }

    fn new(value: T) -> Self {
        Self(parking_lot::Mutex::new(value))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        Ok(f(&mut self.0.lock()))
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.with(f)
    }

    fn with_until<R>(
        &self,
        _timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        if HUNG.get() {
            return Err(Shut::TimedOut);
        }
        Ok(f(&mut self.0.lock(), Owner::Sound))
    }
}
