//! All that is unsafe in this crate.
//!
//! | module | what it answers for |
//! |---|---|
//! | [`pi`] | the futex lock: a system call, and the cell behind it |
//! | [`fenced`] | the cell that the tenant reaches without the lock |
//! | [`rseq`] | a store that the kernel undoes, before it is done, where its thread is disturbed |
#![expect(unsafe_code, reason = "cells that are shared by a protocol, and system calls")]

use super::Strategy;

pub(super) mod fenced;
#[cfg(all(feature = "linux", target_os = "linux", not(loom)))]
pub(super) mod pi;
#[cfg(all(
    feature = "linux",
    target_os = "linux",
    any(target_arch = "x86_64", target_arch = "aarch64"),
    not(loom)
))]
pub(super) mod rseq;

/// A strategy on which memory safety may rest: [`Fenced`](super::Fenced) stands
/// on one.
///
/// # Safety
/// Of the closures that are given to one lock, at most one runs at a time; and
/// what one did happens before the next one begins.
pub unsafe trait Excludes: Strategy {}

// SAFETY: One Inside, of `pi`.
#[cfg(all(feature = "linux", target_os = "linux", not(loom)))]
unsafe impl<I: pi::CurrentThread> Excludes for super::PiLocked<I> {}

// SAFETY: it stands on a `RawMutex`, whose own contract this is.
#[cfg(feature = "lock-api")]
unsafe impl<R, I> Excludes for super::Locked<R, I> where Self: Strategy {}

// SAFETY: it stands on a critical section, whose own contract this is; the
// `RefCell` inside refuses who enters twice.
#[cfg(feature = "critical-section")]
unsafe impl Excludes for super::Masked {}

// SAFETY: it stands on loom's mutex.
#[cfg(loom)]
unsafe impl Excludes for super::LoomLocked {}
