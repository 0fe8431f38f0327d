//! Chooses where atomics and the modelled lock come from. Nothing else in this
//! crate says `cfg(loom)`.

#[cfg(loom)]
pub(crate) use loom::sync::atomic::{AtomicUsize, Ordering, fence};

#[cfg(not(loom))]
pub(crate) use portable_atomic::{AtomicUsize, Ordering, fence};
