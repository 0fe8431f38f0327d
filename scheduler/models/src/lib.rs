//! Loom models of what is concurrent in the schedule manager.
//!
//! The files that are modelled are those of `faregate-scheduler`, taken by
//! their paths: that crate as a whole stands on locks of the operating system,
//! which loom cannot see. Without `--cfg loom` there is nothing here.
#![cfg(loom)]

#[path = "../../src/port/beat.rs"]
pub mod beat;
#[path = "../../src/port/entrance.rs"]
pub mod entrance;

/// Loom's atomics, under the name by which the files know them.
mod sync {
    pub(crate) use loom::sync::atomic::{AtomicBool, AtomicU32, Ordering};
}
