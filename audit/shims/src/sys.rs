//! What the entries need of unsafe code: state in statics, words that the
//! optimiser may not look into, and the symbols that the object must bring.
#![expect(unsafe_code, reason = "entries take no arguments, so their state is in statics")]

mod copies;
#[cfg(not(target_os = "none"))]
mod interrupts;
pub(crate) mod mutex;
#[cfg(target_os = "linux")]
pub(crate) mod thread;

// The core's own way to mask interrupts, which is reached by its symbol.
#[cfg(target_os = "none")]
use cortex_m as _;

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use faregate_tickets::lock::Excludes;

/// A place in a static for what an entry works on.
///
/// Entries are called one at a time, by one thread, and each is called after
/// the set-up that fills its places: the *Turn Rule*, by which all that is
/// unsafe here is sound.
#[derive(Debug)]
#[repr(C)]
pub(crate) struct Slot<T> {
    /// Where it is, in a word that the optimiser may not look into: an entry
    /// reaches its state as a caller does, by an address that it has to load,
    /// and finds there nothing that is known beforehand.
    at: Register<*mut T>,
    place: UnsafeCell<MaybeUninit<T>>,
}

// SAFETY: by the Turn Rule one thread at a time has anything to do with it.
unsafe impl<T> Sync for Slot<T> {}

impl<T> Slot<T> {
    pub(crate) const fn empty() -> Self {
        let place = UnsafeCell::new(MaybeUninit::uninit());
        Self { at: Register::new(core::ptr::null_mut()), place }
    }

    /// Puts a value in, and forgets the one before without dropping it: it
    /// belonged to an earlier turn, as did whatever it pointed to.
    #[expect(clippy::mut_from_ref, reason = "by the Turn Rule there is no other reference")]
    pub(crate) fn fill(&'static self, value: T) -> &'static mut T {
        // SAFETY: by the Turn Rule no reference of an earlier turn is used any more.
        let place = unsafe { &mut *self.place.get() };
        self.at.write(place.write(value));
        self.get_mut()
    }

    pub(crate) fn get(&'static self) -> &'static T {
        // SAFETY: by the Turn Rule it was filled, and nobody changes it but
        // through what it shares by itself.
        unsafe { &*self.at.read() }
    }

    #[expect(clippy::mut_from_ref, reason = "by the Turn Rule there is no other reference")]
    pub(crate) fn get_mut(&'static self) -> &'static mut T {
        // SAFETY: by the Turn Rule it was filled, and there is no other reference.
        unsafe { &mut *self.at.read() }
    }

    /// Moves the value out; the place counts as empty from then on.
    pub(crate) fn take(&'static self) -> T {
        // SAFETY: by the Turn Rule it was filled, there is no other reference,
        // and the next set-up fills it again.
        unsafe { self.at.read().read() }
    }
}

/// A place whose value the optimiser may know, where it is the same in each
/// turn.
#[derive(Debug)]
pub(crate) struct Known<T>(UnsafeCell<MaybeUninit<T>>);

// SAFETY: by the Turn Rule one thread at a time has anything to do with it.
unsafe impl<T> Sync for Known<T> {}

impl<T> Known<T> {
    pub(crate) const fn empty() -> Self {
        Self(UnsafeCell::new(MaybeUninit::uninit()))
    }

    #[inline(always)]
    pub(crate) fn fill(&'static self, value: T) {
        // SAFETY: by the Turn Rule no reference of an earlier turn is used any more.
        unsafe { self.0.get().write(MaybeUninit::new(value)) };
    }

    #[inline(always)]
    pub(crate) fn get(&'static self) -> &'static T {
        // SAFETY: by the Turn Rule nobody changes it.
        let place = unsafe { &*self.0.get() };
        // SAFETY: by the Turn Rule it was filled.
        unsafe { place.assume_init_ref() }
    }
}

/// A word that is read and written as a device's register is: each access
/// happens, and nothing is known of what it reads.
#[derive(Debug)]
pub(crate) struct Register<T>(UnsafeCell<T>);

// SAFETY: by the Turn Rule one thread at a time reads or writes it.
unsafe impl<T> Sync for Register<T> {}

impl<T: Copy> Register<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self(UnsafeCell::new(value))
    }

    pub(crate) fn read(&self) -> T {
        // SAFETY: it is aligned and holds a `T`; by the Turn Rule nobody writes.
        unsafe { self.0.get().read_volatile() }
    }

    pub(crate) fn write(&self, value: T) {
        // SAFETY: it is aligned and holds a `T`; by the Turn Rule nobody reads.
        unsafe { self.0.get().write_volatile(value) }
    }
}

// SAFETY: one closure at a time is given on to `S`, whose own contract this is.
unsafe impl<S: Excludes> Excludes for crate::ports::Apart<S> {}

/// A set-up has failed. The core never comes here: the audit rejects an entry
/// that could.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
