//! Restartable sequences: a check and a store that the kernel undoes, before
//! the store, where their thread is disturbed.
//!
//! Between its first instruction and its store the section has registered
//! itself in its thread's `rseq` area. If the thread is pre-empted, moved or
//! signalled there, or another thread's `membarrier` finds it there, the kernel
//! lets it go on at the abort address instead. So a section that has not stored
//! when [`end_all`](Sections::end_all) returns compares again, after it.
//!
//! `membarrier(PRIVATE_EXPEDITED_RSEQ)` is a full barrier of the caller, and of
//! each thread of the process that is running; one that is not running passes
//! one before it runs again. So who compares after `end_all` sees what was
//! written before it.

use core::marker::PhantomData;
use core::sync::atomic::AtomicU32;

use super::super::{Outcome, Sections, Watch};

#[cfg(target_arch = "aarch64")]
use self::aarch64::section;
#[cfg(target_arch = "x86_64")]
use self::x86_64::section;

#[cfg(target_arch = "aarch64")]
mod aarch64;
#[cfg(target_arch = "x86_64")]
mod x86_64;

/// Says where each thread's `rseq` area is.
///
/// # Safety
/// At the distance that [`offset`](Registered::offset) answers, if it is not
/// zero, each thread's thread pointer is followed or preceded by the area that
/// this thread registered with the kernel, with the signature `0x53053053`
/// (x86-64) or `0xd428bc00` (aarch64), for as long as it runs code of this crate.
pub unsafe trait Registered: 'static {
    /// The distance, in bytes, of the area from the thread pointer; zero while
    /// it is not known. Then every command goes through the lock.
    ///
    /// # Timing
    /// Called for each section: one load.
    fn offset() -> isize;
}

/// The sections of Linux, for threads whose area `I` knows.
#[derive(Debug)]
pub struct Rseq<I>(PhantomData<fn() -> I>);

impl<I: Registered> Rseq<I> {
    /// Tells the kernel that this process ends sections; answers whether the
    /// kernel can. Ask at start-up: without it no section ever ends.
    #[must_use]
    pub fn is_supported() -> bool {
        membarrier(libc::MEMBARRIER_CMD_REGISTER_PRIVATE_EXPEDITED_RSEQ) && Self::end_all()
    }
}

impl<I: Registered> Sections for Rseq<I> {
    fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Outcome {
        // The sections compare words of 64 bits: with 32-bit pointers on these
        // processors they would read past each of them.
        const { assert!(usize::BITS == 64) };
        match I::offset() {
            0 => Outcome::Refused,
            // SAFETY: `Registered` promises the area at this offset.
            offset => unsafe { section(watch, register, word, offset) },
        }
    }

    fn end_all() -> bool {
        membarrier(libc::MEMBARRIER_CMD_PRIVATE_EXPEDITED_RSEQ)
    }
}

fn membarrier(command: libc::c_int) -> bool {
    let no_flags: libc::c_uint = 0;
    let any_cpu: libc::c_int = 0;
    // SAFETY: the call takes plain numbers.
    unsafe { libc::syscall(libc::SYS_membarrier, command, no_flags, any_cpu) == 0 }
}
