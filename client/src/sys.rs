//! The one module with unsafe code: a file descriptor that is known by its
//! number alone.
#![expect(unsafe_code, reason = "an inherited descriptor arrives as a number in the environment")]

use std::io;
use std::os::fd::{FromRawFd, OwnedFd};

/// A copy of the file descriptor with this number, closed at `exec`; the one
/// with the number stays as it is, for programs that this one calls.
///
/// # Errors
/// `EBADF`, if the number is none of an open file descriptor.
pub(crate) fn duplicate(number: i32) -> io::Result<OwnedFd> {
    // SAFETY: `F_DUPFD_CLOEXEC` reads and writes no memory of ours, and answers
    // a number that is no open descriptor with an error.
    let copy = unsafe { libc::fcntl(number, libc::F_DUPFD_CLOEXEC, 3) };
    if copy < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the kernel has just made this descriptor, for us alone.
    Ok(unsafe { OwnedFd::from_raw_fd(copy) })
}
