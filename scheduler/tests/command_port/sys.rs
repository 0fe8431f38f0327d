//! Descriptors that a test's process inherited by number.
#![expect(unsafe_code, reason = "an inherited descriptor arrives as a number in the environment")]

use std::os::fd::{FromRawFd, OwnedFd};

/// The descriptor of this number.
pub(crate) fn inherited(number: &str) -> OwnedFd {
    // SAFETY: the process was started with this descriptor, for this one use.
    unsafe { OwnedFd::from_raw_fd(number.parse().unwrap()) }
}
