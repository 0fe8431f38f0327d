//! The copies that the compiler calls for: part of the object, so that the
//! audit sees their loops. One byte at a time, because their turns are then
//! the length, which is known at each call.

use core::arch::asm;

// Volatile, so that the compiler does not find the copy in here and call it.

/// The place after this one, in a way that the compiler cannot follow: it would
/// make several turns one.
#[inline(always)]
fn next(at: usize) -> usize {
    let mut next = at + 1;
    // SAFETY: it is no instruction.
    unsafe { asm!("/* {0} */", inout(reg) next, options(nomem, nostack, preserves_flags)) };
    next
}

/// # Safety
/// As C's.
// SAFETY: it is C's `memcpy`, as the compiler expects of that name.
#[unsafe(no_mangle)]
unsafe extern "C" fn memcpy(to: *mut u8, from: *const u8, length: usize) -> *mut u8 {
    let mut at = 0;
    while at < length {
        // SAFETY: the caller promises `length` bytes to read.
        let byte = unsafe { from.wrapping_add(at).read_volatile() };
        // SAFETY: the caller promises `length` bytes to write.
        unsafe { to.wrapping_add(at).write_volatile(byte) };
        at = next(at);
    }
    to
}

/// # Safety
/// As C's.
// SAFETY: it is C's `memmove`, as the compiler expects of that name.
#[unsafe(no_mangle)]
unsafe extern "C" fn memmove(to: *mut u8, from: *const u8, length: usize) -> *mut u8 {
    if to.cast_const() <= from {
        // SAFETY: as ours. A byte is read before anything at or after it is written.
        return unsafe { memcpy(to, from, length) };
    }
    let mut done = 0;
    while done < length {
        done = next(done);
        let left = length - done;
        // SAFETY: the caller promises `length` bytes to read.
        let byte = unsafe { from.wrapping_add(left).read_volatile() };
        // SAFETY: the caller promises `length` bytes to write.
        unsafe { to.wrapping_add(left).write_volatile(byte) };
    }
    to
}

/// # Safety
/// As C's.
// SAFETY: it is C's `memset`, as the compiler expects of that name.
#[unsafe(no_mangle)]
unsafe extern "C" fn memset(to: *mut u8, byte: i32, length: usize) -> *mut u8 {
    let [byte, ..] = byte.to_le_bytes();
    let mut at = 0;
    while at < length {
        // SAFETY: the caller promises `length` bytes to write.
        unsafe { to.wrapping_add(at).write_volatile(byte) };
        at = next(at);
    }
    to
}

/// # Safety
/// As C's.
// SAFETY: it is C's `memcmp`, as the compiler expects of that name.
#[unsafe(no_mangle)]
unsafe extern "C" fn memcmp(one: *const u8, other: *const u8, length: usize) -> i32 {
    let mut at = 0;
    while at < length {
        // SAFETY: the caller promises `length` bytes to read.
        let ours = unsafe { one.wrapping_add(at).read_volatile() };
        // SAFETY: the caller promises `length` bytes to read.
        let theirs = unsafe { other.wrapping_add(at).read_volatile() };
        if ours != theirs {
            return i32::from(ours) - i32::from(theirs);
        }
        at = next(at);
    }
    0
}

/// # Safety
/// As C's.
// SAFETY: it is C's `bcmp`, as the compiler expects of that name.
#[unsafe(no_mangle)]
unsafe extern "C" fn bcmp(one: *const u8, other: *const u8, length: usize) -> i32 {
    // SAFETY: as ours.
    unsafe { memcmp(one, other, length) }
}
