//! What the tests of the locks ask of the operating system.
#![expect(unsafe_code, reason = "thread ids, priorities and deaths are system calls")]

use std::{io, mem};

use faregate_tickets::lock::CurrentThread;

/// All by which a thread can ask for a priority-inheriting futex.
pub(super) const PI_OPERATIONS: &[libc::c_int] =
    &[libc::FUTEX_LOCK_PI, libc::FUTEX_LOCK_PI2, libc::FUTEX_TRYLOCK_PI, libc::FUTEX_UNLOCK_PI];

pub(super) enum Kernel {}

// SAFETY: it is what `gettid` answers.
unsafe impl CurrentThread for Kernel {
    fn tid() -> u32 {
        tid()
    }
}

pub(super) fn tid() -> u32 {
    // SAFETY: asks nothing of its caller.
    unsafe { libc::gettid() }.cast_unsigned()
}

/// Ends the calling thread alone, without unwinding.
pub(super) fn die() -> ! {
    // SAFETY: what the thread borrowed is leaked by the tests; what it
    // owned stays allocated.
    unsafe { libc::syscall(libc::SYS_exit, 0) };
    unreachable!("a dead thread goes on");
}

pub(super) fn run_at_fifo(priority: i32) -> io::Result<()> {
    let parameters = libc::sched_param { sched_priority: priority };
    // SAFETY: `parameters` is readable; 0 is the calling thread.
    match unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// Pins the calling thread to one of the first CPUs.
pub(super) fn run_on_cpu(cpu: u32) {
    let cpus = 1_usize << cpu;
    // SAFETY: `cpus` is readable for the length given, as a set of bits; 0
    // is the calling thread.
    let answer =
        unsafe { libc::sched_setaffinity(0, size_of::<usize>(), (&raw const cpus).cast()) };
    assert_eq!(answer, 0, "{}", io::Error::last_os_error());
}

/// From now on these futex operations fail for the calling thread.
pub(super) fn refuse_futex(operations: &[libc::c_int], errno: libc::c_int) {
    let nr = u32::try_from(mem::offset_of!(libc::seccomp_data, nr)).unwrap();
    // The low half of the second argument.
    let half = if cfg!(target_endian = "big") { 4 } else { 0 };
    let operation = u32::try_from(mem::offset_of!(libc::seccomp_data, args)).unwrap() + 8 + half;
    let refuse = libc::SECCOMP_RET_ERRNO | errno.cast_unsigned();
    let number = u32::try_from(libc::SYS_futex).unwrap();
    let command = !(libc::FUTEX_PRIVATE_FLAG | libc::FUTEX_CLOCK_REALTIME).cast_unsigned();
    let mut filter = vec![
        step(libc::BPF_LD | libc::BPF_W | libc::BPF_ABS, nr, 0, 0),
        step(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, number, 1, 0),
        step(libc::BPF_RET | libc::BPF_K, libc::SECCOMP_RET_ALLOW, 0, 0),
        step(libc::BPF_LD | libc::BPF_W | libc::BPF_ABS, operation, 0, 0),
        step(libc::BPF_ALU | libc::BPF_AND | libc::BPF_K, command, 0, 0),
    ];
    for refused in operations {
        filter.push(step(
            libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K,
            refused.cast_unsigned(),
            0,
            1,
        ));
        filter.push(step(libc::BPF_RET | libc::BPF_K, refuse, 0, 0));
    }
    filter.push(step(libc::BPF_RET | libc::BPF_K, libc::SECCOMP_RET_ALLOW, 0, 0));
    install(&mut filter);
}

fn step(code: u32, k: u32, jt: u8, jf: u8) -> libc::sock_filter {
    libc::sock_filter { code: u16::try_from(code).unwrap(), jt, jf, k }
}

fn install(filter: &mut [libc::sock_filter]) {
    let program =
        libc::sock_fprog { len: u16::try_from(filter.len()).unwrap(), filter: filter.as_mut_ptr() };
    // SAFETY: takes numbers only.
    let answer = unsafe { libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) };
    assert_eq!(answer, 0, "{}", io::Error::last_os_error());
    // SAFETY: `program` and the filter it points to are readable.
    let answer =
        unsafe { libc::prctl(libc::PR_SET_SECCOMP, libc::SECCOMP_MODE_FILTER, &raw const program) };
    assert_eq!(answer, 0, "{}", io::Error::last_os_error());
}
