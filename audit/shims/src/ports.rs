//! The ports that the entries stand on, each of them the least that there is.

use core::marker::PhantomData;
use core::sync::atomic::{AtomicU32, Ordering};

use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Effect, Profile};
use faregate_tickets::lock::{
    Exclusion, Fenced, Locked, Masked, Outcome, Owner, Restartable, Sections, Shut, Strategy, Wait,
    Watch,
};
#[cfg(target_os = "linux")]
use faregate_tickets::lock::{PiLocked, Rseq};
use faregate_tickets::recorder::{Lane, NoLane, Record};
use faregate_tickets::ticket::Seat;

use crate::sys::Register;
use crate::sys::mutex::{OneExchange, OneThread};

/// What the valve's register was last told.
static REGISTER: Register<u32> = Register::new(0);
/// What the valve answers: anything but 0 is a fault.
pub(crate) static STATUS: Register<u32> = Register::new(0);
/// The time.
pub(crate) static NOW: Register<u64> = Register::new(0);

pub(crate) const DRAW: Milliwatts = Milliwatts::from_watts(8);

#[derive(Clone, Copy, Debug)]
pub(crate) enum Setting {
    Off,
    On,
    Same,
}

impl Setting {
    fn declare(self) -> Declaration {
        let effect = match self {
            Self::Off => Effect::Off,
            Self::On => Effect::on(DRAW),
            Self::Same => Effect::Unchanged,
        };
        Declaration { code: self as u16, wcet: Duration::from_millis(1), effect }
    }
}

/// A driver that is made when its gate is.
pub(crate) trait Bench:
    Device<Command = Setting, Response = (), Fault = ()> + 'static
{
    const NEW: Self;
}

/// A device whose commands are one store in a register.
#[derive(Debug)]
pub(crate) struct Valve(());

/// A device whose commands are one store, and which says whether it obeyed.
#[derive(Debug)]
pub(crate) struct Answering(());

impl Bench for Valve {
    const NEW: Self = Self(());
}

impl Bench for Answering {
    const NEW: Self = Self(());
}

impl Device for Valve {
    type Command = Setting;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new().drawing(DRAW)
    }

    fn declare(command: &Setting) -> Declaration {
        command.declare()
    }

    fn issue(&mut self, command: Setting) -> Result<(), ()> {
        REGISTER.write(command as u32);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.issue(Setting::Off)
    }
}

impl Device for Answering {
    type Command = Setting;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new().drawing(DRAW)
    }

    fn declare(command: &Setting) -> Declaration {
        command.declare()
    }

    fn issue(&mut self, command: Setting) -> Result<(), ()> {
        REGISTER.write(command as u32);
        if STATUS.read() == 0 { Ok(()) } else { Err(()) }
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.issue(Setting::Off)
    }
}

/// A clock that is one word.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Word;

impl Clock for Word {
    fn now(&self) -> Instant {
        Instant::from_micros(NOW.read())
    }
}

const RECORDS: usize = 8;

/// A lane that keeps the latest few records in a ring of its own.
#[derive(Debug)]
pub(crate) struct Ring {
    records: [Option<Record>; RECORDS],
    next: usize,
}

impl Default for Ring {
    fn default() -> Self {
        Self { records: [None; RECORDS], next: 0 }
    }
}

impl Lane for Ring {
    fn record(&mut self, record: Record) {
        // The mask changes nothing: it spares the check of the bounds.
        self.records[self.next & (RECORDS - 1)] = Some(record);
        self.next = self.next.wrapping_add(1) & (RECORDS - 1);
    }
}

/// A device whose commands are one store, which its gate may do itself.
#[derive(Debug)]
pub(crate) struct Latch(());

static LATCH: AtomicU32 = AtomicU32::new(0);

impl Bench for Latch {
    const NEW: Self = Self(());
}

impl Device for Latch {
    type Command = Setting;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        // A ticket for a device without draw has no lease, and a gate stores by
        // itself only where nothing runs out.
        Profile::new()
    }

    fn declare(_: &Setting) -> Declaration {
        Setting::Same.declare()
    }

    fn register(&self) -> Option<&'static AtomicU32> {
        Some(&LATCH)
    }

    fn word(command: &Setting) -> Option<(u32, ())> {
        Some((*command as u32, ()))
    }

    fn issue(&mut self, command: Setting) -> Result<(), ()> {
        LATCH.store(command as u32, Ordering::Relaxed);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.issue(Setting::Off)
    }
}

/// The strategy `S`, of which the audit stops at the entrance: what is behind
/// it has rows of its own. Whoever is refused before it, and whoever has a way
/// of its own past it, shows its own cost.
#[derive(Debug)]
pub(crate) struct Apart<S>(PhantomData<fn() -> S>);

/// The lock behind [`Apart`].
#[derive(Debug)]
pub(crate) struct ApartLock<L>(L);

impl<S: Strategy> Strategy for Apart<S> {
    type Lock<T: Send> = ApartLock<S::Lock<T>>;
}

impl<T: Send, L: Exclusion<T>> Exclusion<T> for ApartLock<L> {
    type Way<'l>
        = &'l Self
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, _: Duration) -> &'l Self {
        self
    }

    fn new(value: T) -> Self {
        Self(L::new(value))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        entrance(|| self.0.with(f))
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        entrance(|| self.0.try_with(f))
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        self.0.with_until(timeout, f)
    }
}

/// Where the audit stops.
#[inline(never)]
fn entrance<R>(enter: impl FnOnce() -> R) -> R {
    enter()
}

/// Sections of one thread that nobody disturbs: a comparison, then the store.
#[derive(Debug)]
pub(crate) struct Undisturbed;

impl Sections for Undisturbed {
    fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Outcome {
        if !watch.is_as_expected() {
            return Outcome::Refused;
        }
        register.store(word, Ordering::Release);
        Outcome::Stored
    }

    fn end_all() -> bool {
        true
    }
}

/// Looks once whether a command in flight is over: how to wait for it is the
/// port's, and nobody else is here.
#[derive(Debug)]
pub(crate) struct Glance;

impl Wait for Glance {
    fn until(_: Duration, mut over: impl FnMut() -> bool) -> bool {
        over()
    }
}

/// The default of Linux hosts.
#[cfg(target_os = "linux")]
pub(crate) type Pi<L = NoLane> = (PiLocked<crate::sys::thread::TheThread>, Word, L);
/// The default of one core without an operating system.
pub(crate) type Bare<L = NoLane> = (Masked, Word, L);
/// The adapter for any `lock_api` mutex, over the least of them.
pub(crate) type Adapted<L = NoLane> = (Locked<OneExchange, OneThread>, Word, L);
/// Whoever goes through the lock leaves the row.
pub(crate) type Refusing = (Apart<Masked>, Word, NoLane);
/// The tenant's own way with one fence, past a lock that leaves the row.
pub(crate) type ShortWay = (Fenced<Apart<Masked>, Glance>, Word, NoLane);
/// One fence, and the lock behind it.
pub(crate) type OneFence = (Fenced<Masked, Glance>, Word, NoLane);
/// The same way, in sections that the platform has otherwise.
pub(crate) type OwnSections = (Restartable<Apart<Masked>, Undisturbed>, Word, NoLane);
/// The tenant's own way with one store, past a lock that leaves the row.
#[cfg(target_os = "linux")]
pub(crate) type OneStore =
    (Restartable<Apart<Masked>, Rseq<crate::sys::thread::TheThread>>, Word, NoLane);
/// One store, and the lock behind it.
#[cfg(target_os = "linux")]
pub(crate) type StoreOrLock = (
    Restartable<PiLocked<crate::sys::thread::TheThread>, Rseq<crate::sys::thread::TheThread>>,
    Word,
    NoLane,
);
