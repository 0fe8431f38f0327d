//! Chooses where atomics and the modelled lock come from. Nothing else in this
//! crate says `cfg(loom)`, but the locks and the tests.

#[cfg(loom)]
pub(crate) use loom::cell::UnsafeCell;
#[cfg(loom)]
pub(crate) use loom::sync::atomic::{AtomicUsize, Ordering, fence};

#[cfg(not(loom))]
pub(crate) use portable_atomic::{AtomicUsize, Ordering, fence};

/// A cell that is shared by a protocol; loom's finds out who breaks it.
#[cfg(not(loom))]
#[derive(Debug)]
pub(crate) struct UnsafeCell<T>(core::cell::UnsafeCell<T>);

#[cfg(not(loom))]
impl<T> UnsafeCell<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self(core::cell::UnsafeCell::new(value))
    }

    #[inline(always)]
    pub(crate) fn with_mut<R>(&self, f: impl FnOnce(*mut T) -> R) -> R {
        f(self.0.get())
    }
}

/// How many tickets of one gate can have a short way of `lock::Fenced`. A model
/// of more than two would only take longer.
pub(crate) const SHORT_WAYS: usize = if cfg!(loom) { 2 } else { 8 };

/// Makes a constructor `const`, which with loom's atomics none can be.
#[cfg(not(loom))]
macro_rules! const_unless_loom {
    ($(#[$meta:meta])* $vis:vis fn $($rest:tt)*) => {
        $(#[$meta])* $vis const fn $($rest)*
    };
}
#[cfg(loom)]
macro_rules! const_unless_loom {
    ($($constructor:tt)*) => { $($constructor)* };
}
pub(crate) use const_unless_loom;

/// An array of so many values, each made by the same expression.
#[cfg(not(loom))]
macro_rules! array_of {
    ($new:expr, $n:expr) => {
        [const { $new }; $n]
    };
}
#[cfg(loom)]
macro_rules! array_of {
    ($new:expr, $n:expr) => {
        core::array::from_fn::<_, { $n }, _>(|_| $new)
    };
}
pub(crate) use array_of;

#[cfg(all(feature = "mutant", not(loom)))]
compile_error!("a mutant is broken on purpose; only `ci/loom.sh` builds it");
