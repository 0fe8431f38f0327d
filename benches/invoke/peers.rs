//! Other ways to guard the same call: what a program would write that has no
//! tickets.
//!
//! Each looks whether it is still allowed, where there is something to look at,
//! and then makes the call. Those of the first group do not keep Closed Door:
//! the permission can be withdrawn between the look and the call.

use std::hint::black_box;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering, fence};
use std::sync::{Mutex, RwLock};

use faregate::runtime::host::HostStrategy;
use faregate::tickets::lock::{Exclusion, Locked, Strategy};

use crate::register::Register;
use crate::support::{Contest, Entrant};

/// What every command stores.
pub(crate) const VALUE: u32 = 7;

/// The peers that ratios are taken with.
pub(crate) struct Peers {
    pub(crate) bare_store: Entrant,
    pub(crate) flag: Entrant,
    pub(crate) one_fence: Entrant,
    pub(crate) host_lock: Entrant,
    pub(crate) parking_lot: Entrant,
}

/// Makes an entrant of one operation, by repeating it.
pub(crate) fn repeat<'a, R>(
    contest: &mut Contest<'a>,
    name: &str,
    mut operation: impl FnMut(u32) -> R + 'a,
) -> Entrant {
    contest.enter(name, move |n| {
        let value = black_box(VALUE);
        for _ in 0..n {
            // By reference: a copy of a large answer would be paid for, too.
            black_box(&operation(value));
        }
    })
}

/// Whoever guards the call, this is it.
fn if_allowed(allowed: bool, register: &Register, value: u32) -> bool {
    if allowed {
        register.command(value);
    }
    allowed
}

pub(crate) fn enter(contest: &mut Contest<'_>) -> Peers {
    repeat(contest, "an empty loop", |_| ());
    let register = Register::installed();
    let bare_store = repeat(contest, "bare store", |value| register.store(value));
    repeat(contest, "bare call", |value| register.command(value));
    flags(contest);
    let peers = Peers {
        bare_store,
        flag: acquire_flag(contest),
        one_fence: one_fence(contest),
        host_lock: ours::<HostStrategy>(contest, "the host's lock (priority inheritance)"),
        parking_lot: ours::<Locked<parking_lot::RawMutex, parking_lot::RawThreadId>>(
            contest,
            "Locked<parking_lot>",
        ),
    };
    locks(contest);
    #[cfg(target_os = "linux")]
    priority_inheriting_lock(contest);
    reclaimers(contest);
    tokens(contest);
    peers
}

fn flags(contest: &mut Contest<'_>) {
    let (register, flag) = (Register::installed(), AtomicBool::new(true));
    repeat(contest, "relaxed flag + call", move |value| {
        if_allowed(flag.load(Ordering::Relaxed), register, value)
    });
}

pub(crate) fn acquire_flag(contest: &mut Contest<'_>) -> Entrant {
    let (register, flag) = (Register::installed(), AtomicBool::new(true));
    repeat(contest, "acquire flag + call", move |value| {
        if_allowed(flag.load(Ordering::Acquire), register, value)
    })
}

/// The lower bound for a portable check-and-announce ("Laws of Order", POPL
/// 2011): announce, fence, look, call, leave.
fn one_fence(contest: &mut Contest<'_>) -> Entrant {
    let (register, in_flight, epoch) =
        (Register::installed(), AtomicUsize::new(0), AtomicUsize::new(1));
    let mut sequence = 0;
    repeat(contest, "one-fence protocol + call", move |value| {
        in_flight.store(sequence + 1, Ordering::Release);
        fence(Ordering::SeqCst);
        let issued = if_allowed(epoch.load(Ordering::Relaxed) == 1, register, value);
        sequence += 2;
        in_flight.store(sequence, Ordering::Release);
        issued
    })
}

/// One of our strategies around the call, without gate and ticket.
fn ours<S: Strategy>(contest: &mut Contest<'_>, name: &str) -> Entrant {
    let lock = <S as Strategy>::Lock::<&'static Register>::new(Register::installed());
    repeat(contest, &format!("{name} + call"), move |value| {
        lock.with(|register| register.command(value))
    })
}

/// Permission and device behind one lock: sound, as long as nobody dies or is
/// pre-empted inside.
fn locks(contest: &mut Contest<'_>) {
    let guarded = || (true, Register::installed());
    let lock = Mutex::new(guarded());
    repeat(contest, "std Mutex + call", move |value| {
        lock.lock().is_ok_and(|held| if_allowed(held.0, held.1, value))
    });
    let lock = RwLock::new(guarded());
    repeat(contest, "std RwLock read + call", move |value| {
        lock.read().is_ok_and(|held| if_allowed(held.0, held.1, value))
    });
    let lock = parking_lot::Mutex::new(guarded());
    repeat(contest, "parking_lot Mutex + call", move |value| {
        let held = lock.lock();
        if_allowed(held.0, held.1, value)
    });
    let lock = parking_lot::RwLock::new(guarded());
    repeat(contest, "parking_lot RwLock read + call", move |value| {
        let held = lock.read();
        if_allowed(held.0, held.1, value)
    });
}

#[cfg(target_os = "linux")]
fn priority_inheriting_lock(contest: &mut Contest<'_>) {
    let lock = priority_inheriting_lock::PriorityInheritingLock::new((true, Register::installed()));
    repeat(contest, "priority-inheriting-lock + call", move |value| {
        let held = lock.lock();
        if_allowed(held.0, held.1, value)
    });
}

/// A permission that is read while somebody may replace it. Who withdrew it
/// waits for the readers in its own way.
fn reclaimers(contest: &mut Contest<'_>) {
    let (register, flag) = (Register::installed(), AtomicBool::new(true));
    repeat(contest, "crossbeam-epoch pin + call", move |value| {
        let _pinned = crossbeam::epoch::pin();
        if_allowed(flag.load(Ordering::Acquire), register, value)
    });
    let permission = arc_swap::ArcSwap::from_pointee((true, Register::installed()));
    repeat(contest, "arc-swap load + call", move |value| {
        let held = permission.load();
        if_allowed(held.0, held.1, value)
    });
    hazard(contest);
    let (mut writer, reader) = left_right::new_from_empty(Permission(false));
    writer.append(Set(true)).publish();
    repeat(contest, "left-right enter + call", move |value| {
        // Kept: with the writer gone there is nothing to enter.
        let _writer = &writer;
        reader.enter().map(|held| if_allowed(held.0, register, value))
    });
}

fn hazard(contest: &mut Contest<'_>) {
    let register = Register::installed();
    let permission = haphazard::AtomicPtr::<bool>::from(Box::new(true));
    let mut pointer = haphazard::HazardPointer::new();
    repeat(contest, "haphazard load + call", move |value| {
        let issued =
            permission.safe_load(&mut pointer).map(|held| if_allowed(*held, register, value));
        pointer.reset_protection();
        issued
    });
}

#[derive(Clone)]
struct Permission(bool);
struct Set(bool);

impl left_right::Absorb<Set> for Permission {
    fn absorb_first(&mut self, Set(allowed): &mut Set, _: &Self) {
        self.0 = *allowed;
    }

    fn sync_with(&mut self, first: &Self) {
        self.0 = first.0;
    }
}

fn tokens(contest: &mut Contest<'_>) {
    let (register, token) = (Register::installed(), tokio_util::sync::CancellationToken::new());
    repeat(contest, "CancellationToken + call", move |value| {
        if_allowed(!token.is_cancelled(), register, value)
    });
}
