//! How each wish is put to the host.

use std::hint::black_box;

use rustix::io::Errno;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_setaffinity};

use super::{Reason, Wish};
use crate::sys;

/// What stays untouched at the end of the stack: a guard page that the C
/// library may count in, and the frames of prefaulting itself.
const STACK_RESERVE: usize = 64 * 1024;

/// No host has smaller pages.
const PAGE: usize = 4096;

pub(super) fn grant(wish: Wish) -> Result<(), Reason> {
    match wish {
        Wish::LockedMemory => {
            mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).map_err(Reason::from)
        }
        Wish::PrefaultedStack { bytes } => prefault(bytes),
        Wish::Cpu(cpu) => sched_setaffinity(None, &only(cpu)).map_err(Reason::from),
        Wish::Fifo(priority) => sys::set_fifo(priority).map_err(|errno| Reason::Host { errno }),
    }
}

/// The set of this CPU. One for which a set has no room leaves it empty, which
/// the kernel refuses as it refuses any CPU that is not there.
fn only(cpu: usize) -> CpuSet {
    let mut set = CpuSet::new();
    if cpu < CpuSet::MAX_CPU {
        set.set(cpu);
    }
    set
}

fn prefault(bytes: usize) -> Result<(), Reason> {
    let stack = sys::stack().map_err(|errno| Reason::Host { errno })?;
    let here = (&raw const stack).addr();
    let available = here.saturating_sub(stack.start.saturating_add(STACK_RESERVE));
    if bytes > available {
        return Err(Reason::StackEnds { available });
    }
    touch_down_to(here - bytes);
    Ok(())
}

/// Writes to every page of the stack from here to `lowest`.
#[inline(never)]
fn touch_down_to(lowest: usize) {
    let page = [0_u8; PAGE];
    // The compiler may neither leave the page out nor, as it is looked at again
    // afterwards, turn the recursion into a loop that stays where it is.
    if black_box(&page).as_ptr().addr() > lowest {
        touch_down_to(lowest);
    }
    black_box(&page);
}

impl From<Errno> for Reason {
    fn from(errno: Errno) -> Self {
        Self::Host { errno: errno.raw_os_error() }
    }
}
