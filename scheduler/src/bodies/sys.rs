//! The one module with unsafe code: a process is forked into its control group
//! and executes a program, and which child of ours is dead is looked up.
//!
//! Between fork and exec the child makes system calls and nothing else: it is
//! a copy of one thread, and any lock that another thread held at the fork
//! (the allocator's, for one) is held for ever.
#![expect(unsafe_code, reason = "raw system calls between fork and exec; a dead child's number")]

use core::ffi::{CStr, c_char, c_int};
use core::mem::{self, MaybeUninit};
use core::ptr;
use std::ffi::CString;
use std::io;
use std::os::fd::{AsRawFd, BorrowedFd, FromRawFd, OwnedFd, RawFd};

use rustix::process::Pid;

/// The descriptor under which a process finds its command port.
pub(super) const PORT: RawFd = 3;

/// The exit code of a child that could not execute its program. It is told
/// apart from a program's own by what the child wrote.
const NOT_EXECUTED: c_int = 127;

/// `CLONE_INTO_CGROUP` of `linux/sched.h`; does not fit `libc`'s type.
const INTO_CGROUP: u64 = 0x2_0000_0000;

/// What a child needs, made before the fork. No descriptor is [`PORT`] or less.
pub(super) struct Plan<'a> {
    pub(super) program: &'a CStr,
    pub(super) arguments: &'a [CString],
    pub(super) environment: &'a [CString],
    pub(super) input: BorrowedFd<'a>,
    pub(super) output: BorrowedFd<'a>,
    pub(super) errors: BorrowedFd<'a>,
    pub(super) port: Option<BorrowedFd<'a>>,
    /// Where a child that fails says so, by [`Failure::to_bytes`].
    pub(super) failure: BorrowedFd<'a>,
    /// Its soft limit of open files; none: this program's.
    pub(super) open_files: Option<u64>,
    /// The directory of its control group.
    pub(super) group: Option<BorrowedFd<'a>>,
}

/// What a child could not do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Prepare,
    Execute,
}

/// What a child could not do, and the kernel's reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Failure {
    pub(super) step: Step,
    pub(super) errno: i32,
}

impl Failure {
    const LENGTH: usize = 5;

    const fn to_bytes(self) -> [u8; Self::LENGTH] {
        let [a, b, c, d] = self.errno.to_ne_bytes();
        [matches!(self.step, Step::Execute) as u8, a, b, c, d]
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let &[step, a, b, c, d] = bytes else { return None };
        let step = if step == 0 { Step::Prepare } else { Step::Execute };
        Some(Self { step, errno: i32::from_ne_bytes([a, b, c, d]) })
    }
}

/// The kernel's `struct clone_args`, as of Linux 5.7.
#[repr(C)]
#[derive(Default)]
struct CloneArguments {
    flags: u64,
    pidfd: u64,
    child_tid: u64,
    parent_tid: u64,
    exit_signal: u64,
    stack: u64,
    stack_size: u64,
    tls: u64,
    set_tid: u64,
    set_tid_size: u64,
    cgroup: u64,
}

/// Forks a child that executes the program. It dies with the calling *thread*,
/// has a session of its own, no descriptor beyond the plan's, and the default
/// action for every signal.
///
/// # Timing
/// As long as the kernel takes to copy the page tables. What the child fails
/// to do is not waited for.
///
/// # Errors
/// The kernel's, for the fork.
pub(super) fn spawn(plan: &Plan<'_>) -> io::Result<(Pid, OwnedFd)> {
    let arguments = pointers(plan.arguments);
    let environment = pointers(plan.environment);
    let parent = rustix::process::getpid().as_raw_nonzero().get();
    let mut pidfd: RawFd = -1;
    let mut clone = CloneArguments {
        flags: u64::from(libc::CLONE_PIDFD.unsigned_abs()),
        pidfd: (&raw mut pidfd).expose_provenance() as u64,
        exit_signal: u64::from(libc::SIGCHLD.unsigned_abs()),
        ..CloneArguments::default()
    };
    if let Some(group) = plan.group {
        clone.flags |= INTO_CGROUP;
        clone.cgroup = u64::from(group.as_raw_fd().unsigned_abs());
    }
    // A signal that came between fork and exec would run this program's
    // handler in the child, and be lost there.
    let before = block_signals()?;
    let size = mem::size_of::<CloneArguments>();
    // SAFETY: `clone` is what the kernel reads, of the size that it is told,
    // and `pidfd` has room for what it writes. Without CLONE_VM the child is a
    // copy that shares no memory; it goes into `run`, which makes system calls
    // only and never returns.
    let pid = unsafe { libc::syscall(libc::SYS_clone3, &raw mut clone, size) };
    if pid == 0 {
        run(plan, &arguments, &environment, parent);
    }
    let failed = io::Error::last_os_error();
    set_signals(&before);
    let Some(pid) = i32::try_from(pid).ok().filter(|pid| *pid > 0).and_then(Pid::from_raw) else {
        return Err(failed);
    };
    // SAFETY: the kernel has just made this descriptor for us.
    Ok((pid, unsafe { OwnedFd::from_raw_fd(pidfd) }))
}

/// The array that `execve` wants. Valid as long as the strings are.
fn pointers(strings: &[CString]) -> Vec<*const c_char> {
    strings.iter().map(|string| string.as_ptr()).chain([ptr::null()]).collect()
}

fn block_signals() -> io::Result<libc::sigset_t> {
    let mut all = MaybeUninit::uninit();
    let mut before = MaybeUninit::uninit();
    // SAFETY: `all` is room for a set.
    unsafe { libc::sigfillset(all.as_mut_ptr()) };
    // SAFETY: `all` is a set, and `before` is room for one.
    match unsafe { libc::pthread_sigmask(libc::SIG_SETMASK, all.as_ptr(), before.as_mut_ptr()) } {
        // SAFETY: filled by the call, which succeeded.
        0 => Ok(unsafe { before.assume_init() }),
        errno => Err(io::Error::from_raw_os_error(errno)),
    }
}

fn set_signals(set: &libc::sigset_t) {
    // SAFETY: `set` is a set, and the former one is not asked for.
    unsafe { libc::pthread_sigmask(libc::SIG_SETMASK, ptr::from_ref(set), ptr::null_mut()) };
}

/// The child's whole life up to its program. Panics nowhere, allocates nowhere.
fn run(plan: &Plan<'_>, argv: &[*const c_char], envp: &[*const c_char], parent: i32) -> ! {
    let failure = match prepare(plan, parent) {
        Ok(()) => {
            // SAFETY: the path and all strings of both arrays end with a zero,
            // both arrays end with a null pointer.
            unsafe { libc::execve(plan.program.as_ptr(), argv.as_ptr(), envp.as_ptr()) };
            Failure { step: Step::Execute, errno: errno() }
        }
        Err(errno) => Failure { step: Step::Prepare, errno },
    };
    let bytes = failure.to_bytes();
    // SAFETY: reads `bytes` only. Five bytes into an empty pipe do not block.
    unsafe { libc::write(plan.failure.as_raw_fd(), bytes.as_ptr().cast(), bytes.len()) };
    // SAFETY: ends the child, without handlers of the copied program.
    unsafe { libc::_exit(NOT_EXECUTED) }
}

fn prepare(plan: &Plan<'_>, parent: i32) -> Result<(), i32> {
    die_with(parent)?;
    // SAFETY: takes nothing.
    ok(unsafe { libc::setsid() })?;
    be_ordinary();
    default_signals();
    let standard = [(plan.input, 0), (plan.output, 1), (plan.errors, 2)];
    let mut first_closed = PORT;
    for (from, to) in standard.into_iter().chain(plan.port.map(|port| (port, PORT))) {
        // SAFETY: both are plain numbers; `to` belongs to nobody in the child.
        ok(unsafe { libc::dup2(from.as_raw_fd(), to) })?;
        first_closed = first_closed.max(to + 1);
    }
    // Closed by the exec: the failure's pipe is among them.
    // SAFETY: plain numbers; nobody in the child uses what is marked here.
    let closed = unsafe {
        libc::syscall(libc::SYS_close_range, first_closed, u32::MAX, libc::CLOSE_RANGE_CLOEXEC)
    };
    if closed != 0 {
        return Err(errno());
    }
    plan.open_files.map_or(Ok(()), limit_open_files)?;
    unblock_signals()
}

/// What is open beyond the limit stays open.
fn limit_open_files(most: u64) -> Result<(), i32> {
    let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: `limit` has room for the answer.
    ok(unsafe { libc::getrlimit(libc::RLIMIT_NOFILE, &raw mut limit) })?;
    limit.rlim_cur = most.min(limit.rlim_max);
    // SAFETY: `limit` is read during the call only.
    ok(unsafe { libc::setrlimit(libc::RLIMIT_NOFILE, &raw const limit) })
}

/// The child is killed when the thread that forked it ends. Whether that came
/// before the kernel was asked is seen by the parent's number.
fn die_with(parent: i32) -> Result<(), i32> {
    // SAFETY: takes numbers only.
    ok(unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL) })?;
    // SAFETY: takes nothing.
    if unsafe { libc::getppid() } == parent { Ok(()) } else { Err(libc::ESRCH) }
}

/// A task does not inherit the real-time priority of the manager's thread: it
/// could keep the manager itself from running.
fn be_ordinary() {
    // SAFETY: asks about the calling thread.
    let policy = unsafe { libc::sched_getscheduler(0) };
    if policy & !libc::SCHED_RESET_ON_FORK == libc::SCHED_OTHER {
        return;
    }
    // SAFETY: all fields of `sched_param` are integers, for which zero is a value.
    let param: libc::sched_param = unsafe { mem::zeroed() };
    // SAFETY: `param` is read during the call only.
    unsafe { libc::sched_setscheduler(0, libc::SCHED_OTHER, &raw const param) };
}

/// What this program ignores (SIGPIPE, as every Rust program does) its tasks do
/// not. Past the C library, which keeps two signals to itself that this program
/// may have been started with. The kernel refuses SIGKILL and SIGSTOP.
fn default_signals() {
    // The kernel's `struct sigaction`: no handler (SIG_DFL), no flags, no mask.
    let action = [0_u64; 4];
    let none: *const u64 = ptr::null();
    for signal in 1..=64 {
        // SAFETY: `action` is as long as what the kernel reads during the call,
        // and the former action is not asked for. 8 is the size of its mask.
        unsafe { libc::syscall(libc::SYS_rt_sigaction, signal, action.as_ptr(), none, 8_usize) };
    }
}

fn unblock_signals() -> Result<(), i32> {
    let mut none = MaybeUninit::uninit();
    // SAFETY: `none` is room for a set.
    unsafe { libc::sigemptyset(none.as_mut_ptr()) };
    // SAFETY: `none` is a set; the former one is not asked for.
    ok(unsafe { libc::sigprocmask(libc::SIG_SETMASK, none.as_ptr(), ptr::null_mut()) })
}

fn ok(result: c_int) -> Result<(), i32> {
    if result < 0 { Err(errno()) } else { Ok(()) }
}

fn errno() -> i32 {
    // SAFETY: gives the address of the calling thread's own variable.
    let errno = unsafe { libc::__errno_location() };
    // SAFETY: which lives as long as the thread.
    unsafe { *errno }
}

/// A child of this program that is dead and was not reaped, and is left so.
pub(super) fn a_dead_child() -> Option<Pid> {
    // SAFETY: zero is a value of all fields of `siginfo_t`.
    let mut info: libc::siginfo_t = unsafe { mem::zeroed() };
    let options = libc::WEXITED | libc::WNOHANG | libc::WNOWAIT;
    // SAFETY: `info` has room for the answer.
    let asked = unsafe { libc::waitid(libc::P_ALL, 0, &raw mut info, options) };
    if asked != 0 {
        return None;
    }
    // SAFETY: `waitid` has filled this field, or left it zero: nobody is dead.
    Pid::from_raw(unsafe { info.si_pid() })
}
