//! The ports of a host, chosen together.

use std::io;
use std::marker::PhantomData;

use faregate_tickets::Platform;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::lock::{Fenced, Strategy, Wait};
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
use faregate_tickets::lock::{Restartable, Rseq};

use crate::clock::MonotonicClock;
use crate::contain::Caught;
use crate::lanes::RingLane;
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
pub use crate::sys::RseqArea;
#[cfg(target_os = "linux")]
pub use crate::sys::Tid;

/// The platform of a host with threads, whose gates are entered by `S`.
#[derive(Clone, Copy, Debug)]
pub struct Host<S = HostStrategy>(PhantomData<fn() -> S>);

/// How the host enters critical sections.
#[cfg(target_os = "linux")]
pub type HostStrategy = faregate_tickets::lock::PiLocked<Tid>;

/// How the host enters critical sections. Without priority inheritance,
/// *Bounded Hand-over* holds only where no thread of a priority between holder
/// and requester runs.
#[cfg(not(target_os = "linux"))]
pub type HostStrategy =
    faregate_tickets::lock::Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

/// For holders that are not pre-empted inside a command: the tenant enters with
/// one fence, everybody else as [`HostStrategy`] does.
pub type HostFenced = Fenced<HostStrategy, SpinThenSleep>;

/// For commands that are one store: the tenant's are restartable sequences,
/// everybody enters as [`HostStrategy`] does and then ends them.
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
pub type HostRestartable = Restartable<HostStrategy, Rseq<RseqArea>>;

impl<S: Strategy> Platform for Host<S> {
    type Strategy = S;
    type Clock = MonotonicClock;
    type Lane = RingLane;
    type Containment = Caught;
}

/// Spins for a moment, then sleeps between its looks: what is waited for runs on
/// another core, or is let run on this one. (A yield would let nobody run who is
/// less important.)
#[derive(Debug)]
pub enum SpinThenSleep {}

/// How long a command that runs on another core takes at most, in looks at it.
const SPINS: u32 = 256;

/// How long is slept between two looks, and a little more.
const NAP: std::time::Duration = std::time::Duration::from_micros(20);

impl Wait for SpinThenSleep {
    #[expect(clippy::disallowed_methods, reason = "a command in flight takes real time")]
    fn until(timeout: Duration, mut over: impl FnMut() -> bool) -> bool {
        for _ in 0..SPINS {
            if over() {
                return true;
            }
            std::hint::spin_loop();
        }
        let clock = MonotonicClock::new();
        let deadline = clock.now().after(timeout);
        while !over() {
            if clock.now() >= deadline {
                return over();
            }
            std::thread::sleep(NAP);
        }
        true
    }
}

/// A strategy that gates of this host can have.
///
/// [`Builder::gate_behind`](crate::broker::Builder::gate_behind) asks before it
/// makes one: no silent fallback, since another strategy has other promises.
pub trait Supported: Strategy {
    /// Whether the host has what the strategy needs.
    ///
    /// # Errors
    /// [`io::ErrorKind::Unsupported`], with what is missing.
    fn check() -> io::Result<()>;
}

impl Supported for HostStrategy {
    fn check() -> io::Result<()> {
        check()
    }
}

impl Supported for HostFenced {
    fn check() -> io::Result<()> {
        check()
    }
}

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
impl Supported for HostRestartable {
    fn check() -> io::Result<()> {
        check()?;
        if !crate::sys::threads_are_registered() {
            return Err(unsupported(
                "the C library has registered no restartable sequences for its threads: it takes \
                 glibc 2.35, Linux 4.18, and GLIBC_TUNABLES without glibc.pthread.rseq=0",
            ));
        }
        if Rseq::<RseqArea>::is_supported() {
            return Ok(());
        }
        Err(unsupported(
            "this kernel cannot end restartable sequences: it takes Linux 5.10, built with \
             CONFIG_MEMBARRIER and CONFIG_RSEQ, and a sandbox that lets membarrier through",
        ))
    }
}

/// Whether the host has what the strategy needs. No silent fallback: a lock
/// without priority inheritance would break *Bounded Hand-over*.
#[cfg(target_os = "linux")]
pub(crate) fn check() -> io::Result<()> {
    if HostStrategy::is_supported() {
        return Ok(());
    }
    Err(unsupported("this kernel has no priority-inheriting futex (CONFIG_FUTEX_PI)"))
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn check() -> io::Result<()> {
    Ok(())
}

#[cfg(target_os = "linux")]
fn unsupported(why: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::Unsupported, why)
}
