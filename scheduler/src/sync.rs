//! The atomics of what is modelled: a model that takes a file of this crate has
//! a module of this name with loom's own.

pub(crate) use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

#[cfg(feature = "mutant")]
compile_error!("a mutant is broken on purpose; only the models build it");
