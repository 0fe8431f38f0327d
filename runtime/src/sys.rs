//! The one module with unsafe code: what is asked of the operating system and
//! has no safe wrapper elsewhere.
#![expect(unsafe_code, reason = "thread ids that a lock may trust, and the C library on threads")]

use core::cell::Cell;
use core::mem::MaybeUninit;
use core::ops::Range;
use core::sync::atomic::{AtomicIsize, Ordering};
use std::sync::OnceLock;

use faregate_tickets::lock::CurrentThread;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
use faregate_tickets::lock::Registered;

thread_local! {
    /// The id of this thread, or 0 while it is not known. `const`, and without
    /// `Drop`: a thread's first look at it allocates nothing.
    static TID: Cell<u32> = const { Cell::new(0) };
}

/// The kernel's id of the calling thread, asked for once per thread.
///
/// # Timing
/// One load. A thread's first use makes one system call; the first of the
/// whole process also registers what is done at a fork, which may allocate.
/// [`RealTime::apply`](crate::realtime::RealTime::apply) does both beforehand.
#[derive(Clone, Copy, Debug)]
pub enum Tid {}

// SAFETY: `tid` answers what `gettid` would. The cell is of this thread, is only
// ever set to what `gettid` said in this thread, and that does not change while
// the thread lives. `fork` alone carries the cell into another thread, the
// child's only one: there `forget` clears it before `fork` returns, and where
// `forget` could not be registered nothing is kept. (A child of `vfork` may use
// no gate, nor anything else before it calls `exec`. Who makes a thread with a
// raw `clone`, past the C library, breaks its thread-locals and answers for it.)
unsafe impl CurrentThread for Tid {
    fn tid() -> u32 {
        match TID.get() {
            0 => ask(),
            tid => tid,
        }
    }
}

#[cold]
fn ask() -> u32 {
    let tid = rustix::thread::gettid().as_raw_nonzero().get().unsigned_abs();
    if forgets_at_fork() {
        TID.set(tid);
    }
    tid
}

/// Whether a forked child is sure to forget its parent's id.
fn forgets_at_fork() -> bool {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    // SAFETY: `forget` is a function of the required type that lives as long as
    // the program, and does in the child only what a signal handler may do.
    *REGISTERED.get_or_init(|| unsafe { libc::pthread_atfork(None, None, Some(forget)) } == 0)
}

unsafe extern "C" fn forget() {
    TID.set(0);
}

/// The `rseq` area that the C library (glibc 2.35 or later) registers for each
/// of its threads.
#[derive(Clone, Copy, Debug)]
pub enum RseqArea {}

/// The distance of the areas from the threads' thread pointers; 0: not known.
static RSEQ_OFFSET: AtomicIsize = AtomicIsize::new(0);

// SAFETY: glibc registers the area of a thread, with the signature that
// `Registered` names, before the thread runs anything else, at the distance
// that it publishes. The offset is zero until `threads_are_registered` has seen
// that it does. (Who makes a thread past the C library answers for it.)
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
unsafe impl Registered for RseqArea {
    fn offset() -> isize {
        // Relaxed: it is zero or right, whoever reads it when.
        RSEQ_OFFSET.load(Ordering::Relaxed)
    }
}

/// Whether each thread of this process has its area, and the kernel knows it.
pub(crate) fn threads_are_registered() -> bool {
    let (Some(offset), Some(size)) = (find(c"__rseq_offset"), find(c"__rseq_size")) else {
        return false;
    };
    // SAFETY: glibc's `__rseq_size` is an `unsigned int` that stays as it is.
    let size = unsafe { size.cast::<core::ffi::c_uint>().read() };
    // SAFETY: glibc's `__rseq_offset` is a `ptrdiff_t` that stays as it is.
    let offset = unsafe { offset.cast::<isize>().read() };
    // A size of zero is how glibc says that it has registered nothing.
    let offset = if size > 0 { offset } else { 0 };
    RSEQ_OFFSET.store(offset, Ordering::Relaxed);
    offset != 0
}

/// Where the C library has this variable, if it has it.
fn find(name: &core::ffi::CStr) -> Option<core::ptr::NonNull<core::ffi::c_void>> {
    // SAFETY: `name` ends with a zero; the default handle names all libraries.
    core::ptr::NonNull::new(unsafe { libc::dlsym(libc::RTLD_DEFAULT, name.as_ptr()) })
}

/// Gives the calling thread `SCHED_FIFO` with this priority. Threads that it
/// starts later are ordinary ones again.
///
/// # Errors
/// The kernel's `errno`.
pub(crate) fn set_fifo(priority: u8) -> Result<(), i32> {
    // SAFETY: all fields of `sched_param` are integers, for which zero is a value.
    let mut param: libc::sched_param = unsafe { core::mem::zeroed() };
    param.sched_priority = priority.into();
    let policy = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;
    // SAFETY: takes nothing, and gives the calling thread, which is alive.
    let this = unsafe { libc::pthread_self() };
    // SAFETY: `this` is alive, and `param` is read during the call only.
    ok(unsafe { libc::pthread_setschedparam(this, policy, &raw const param) })
}

/// The addresses that the calling thread's stack may come to occupy, a guard
/// page at the low end included with some C libraries.
///
/// # Errors
/// The C library's `errno`.
pub(crate) fn stack() -> Result<Range<usize>, i32> {
    let mut attributes = MaybeUninit::uninit();
    // SAFETY: takes nothing, and gives the calling thread, which is alive.
    let this = unsafe { libc::pthread_self() };
    // SAFETY: `this` is alive, and `attributes` is room for what is written.
    ok(unsafe { libc::pthread_getattr_np(this, attributes.as_mut_ptr()) })?;
    let (mut lowest, mut size) = (core::ptr::null_mut(), 0);
    // SAFETY: `attributes` was filled by the call before, which succeeded, and
    // both results have room.
    let got =
        unsafe { libc::pthread_attr_getstack(attributes.as_ptr(), &raw mut lowest, &raw mut size) };
    // SAFETY: `attributes` was filled, and is not used again.
    unsafe { libc::pthread_attr_destroy(attributes.as_mut_ptr()) };
    ok(got)?;
    let lowest = lowest.addr();
    Ok(lowest..lowest.saturating_add(size))
}

/// What the `pthread` functions answer, as a result.
fn ok(errno: i32) -> Result<(), i32> {
    if errno == 0 { Ok(()) } else { Err(errno) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel_says() -> u32 {
        rustix::thread::gettid().as_raw_nonzero().get().unsigned_abs()
    }

    #[test]
    fn each_thread_has_the_id_that_the_kernel_gave_it() {
        let here = Tid::tid();
        let there = std::thread::spawn(|| {
            assert_eq!(Tid::tid(), kernel_says());
            Tid::tid()
        });
        assert_ne!(here, there.join().unwrap());
        assert_eq!((here, Tid::tid()), (kernel_says(), kernel_says()));
    }

    #[test]
    fn a_forked_child_does_not_take_its_parents_id() {
        Tid::tid();
        // SAFETY: the child does only what a signal handler may do: it looks at
        // a thread-local, asks for its id, and leaves without unwinding.
        let child = unsafe { libc::fork() };
        if child == 0 {
            let told_apart = Tid::tid() == kernel_says();
            // SAFETY: ends the child at once.
            unsafe { libc::_exit(i32::from(!told_apart)) };
        }
        let mut status = -1;
        // SAFETY: `child` is our own child, and `status` has room for its end.
        let ended = unsafe { libc::waitpid(child, &raw mut status, 0) };
        assert_eq!((ended, status), (child, 0), "the child went by its parent's id");
    }

    #[test]
    fn a_local_variable_is_on_the_stack() {
        let local = 0_u8;
        assert!(stack().unwrap().contains(&(&raw const local).addr()));
    }
}
