//! Functions that the audit must reject, each for its own reason, and some that
//! it must accept: `rows.toml` says which. They prove that the audit can fail.
#![no_std]

mod accepted;
mod machine;
mod memory;

use core::hint::black_box;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicPtr, AtomicU32, Ordering};

/// Never comes back. That a panic comes here is what the audit reports, before
/// it would report the loop.
#[panic_handler]
fn on_panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}

/// Inputs that no optimiser knows.
pub(crate) static INPUT: [AtomicU32; 8] = [const { AtomicU32::new(3) }; 8];

pub(crate) fn input(at: usize) -> u32 {
    INPUT.get(at).map_or(0, |input| input.load(Ordering::Relaxed))
}

pub(crate) fn output(value: u32) {
    INPUT[7].store(value, Ordering::Relaxed);
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_division() {
    output(input(0).checked_div(input(1)).unwrap_or(0));
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_wide_division() {
    let wide = |at: usize| u128::from(input(at)) << 64 | u128::from(input(at + 1));
    output(wide(0).checked_div(wide(2)).unwrap_or(0) as u32);
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_long_division() {
    let long = |at: usize| u64::from(input(at)) << 32 | u64::from(input(at + 1));
    output(long(0).checked_div(long(2)).unwrap_or(0) as u32);
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_index() {
    let at = input(0) as usize;
    output(INPUT[at].load(Ordering::Relaxed));
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_unwrap() {
    output(input(0).checked_sub(input(1)).unwrap());
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_slice_sum() {
    let some: &[AtomicU32] = black_box(&INPUT);
    output(some.iter().fold(0, |sum, one| sum ^ one.load(Ordering::Relaxed)));
}

/// Something that is called through a table.
pub trait Port: Sync {
    /// Is called.
    fn call(&self) -> u32;
}

struct One;
struct Two;

impl Port for One {
    fn call(&self) -> u32 {
        input(1)
    }
}

impl Port for Two {
    fn call(&self) -> u32 {
        input(2) + 5
    }
}

fn port() -> &'static dyn Port {
    if input(0) == 3 { black_box(&One) } else { black_box(&Two) }
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_dyn_call() {
    output(port().call());
}

static HANDLERS: [AtomicPtr<()>; 4] = [const { AtomicPtr::new(core::ptr::null_mut()) }; 4];

/// Or the table would be known to be empty.
#[unsafe(no_mangle)]
pub extern "C" fn set_handler(handler: *mut ()) {
    HANDLERS[0].store(handler, Ordering::Relaxed);
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_indirect_jump() {
    let Some(handler) = HANDLERS.get(input(0) as usize) else { return };
    let handler = handler.load(Ordering::Relaxed);
    // SAFETY: never executed: the audit only reads it.
    let handler = unsafe { core::mem::transmute::<*mut (), extern "C" fn()>(handler) };
    handler();
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_spin() {
    while INPUT[0].load(Ordering::Acquire) != 0 {
        core::hint::spin_loop();
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_fetch_max() {
    INPUT[0].fetch_max(input(1), Ordering::Relaxed);
}

/// One instruction on x86-64, if its old value were not used.
#[unsafe(no_mangle)]
pub extern "C" fn reject_fetch_and_used() {
    output(INPUT[0].fetch_and(!1, Ordering::AcqRel) & 4);
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_recursion() {
    output(descend(input(0)));
}

#[inline(never)]
fn descend(depth: u32) -> u32 {
    if depth == 0 { input(1) } else { descend(black_box(depth) - 1) ^ input(2) }
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_mutual_recursion() {
    output(ping(input(0)));
}

#[inline(never)]
fn ping(depth: u32) -> u32 {
    if depth == 0 { input(1) } else { pong(black_box(depth) - 1) ^ input(2) }
}

#[inline(never)]
fn pong(depth: u32) -> u32 {
    if depth == 0 { input(3) } else { ping(black_box(depth) - 1) | input(2) }
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_empty() {}

/// A bound is stated for the outer loop alone.
#[unsafe(no_mangle)]
pub extern "C" fn reject_inner_loop() {
    let mut sum = 0;
    for _ in 0..8 {
        sum ^= drain();
    }
    output(sum);
}

#[inline(always)]
fn drain() -> u32 {
    let mut sum = 0;
    while INPUT[1].load(Ordering::Relaxed) != 0 {
        sum += 1;
    }
    sum
}
