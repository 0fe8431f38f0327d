//! Copies, and memory from an allocator.

use core::alloc::{GlobalAlloc, Layout};
use core::hint::black_box;
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::Ordering;

use crate::{INPUT, input, output};

/// Always the same place.
struct OnePlace;

// SAFETY: never executed: the audit only reads it.
unsafe impl GlobalAlloc for OnePlace {
    #[inline(never)]
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        INPUT[0].fetch_add(1, Ordering::Relaxed);
        INPUT.as_ptr().cast_mut().cast()
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[unsafe(no_mangle)]
pub extern "C" fn reject_allocation() {
    // SAFETY: never executed: the audit only reads it.
    let place = unsafe { OnePlace.alloc(Layout::new::<u32>()) };
    output(black_box(place).addr() as u32);
}

static FROM: [u8; 512] = [7; 512];

#[unsafe(no_mangle)]
pub extern "C" fn reject_copy() {
    let mut to = [0; 512];
    let length = (input(0) & 511) as usize;
    if let (Some(to), Some(from)) = (to.get_mut(..length), black_box(&FROM).get(..length)) {
        to.copy_from_slice(from);
    }
    black_box(&to);
}

/// As long as the code says.
#[unsafe(no_mangle)]
pub extern "C" fn accept_copy() {
    let copy = *black_box(&FROM);
    black_box(&copy);
}

/// What copies are made of here. Volatile, or the compiler would see that this
/// is a copy, and call it.
///
/// # Safety
/// As `memcpy` of C.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn memcpy(to: *mut u8, from: *const u8, length: usize) -> *mut u8 {
    for at in 0..length {
        // SAFETY: both have `length` bytes.
        unsafe { write_volatile(to.add(at), read_volatile(from.add(at))) };
    }
    to
}

/// As [`memcpy`].
///
/// # Safety
/// As `memset` of C.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn memset(to: *mut u8, byte: i32, length: usize) -> *mut u8 {
    for at in 0..length {
        // SAFETY: it has `length` bytes.
        unsafe { write_volatile(to.add(at), byte as u8) };
    }
    to
}
