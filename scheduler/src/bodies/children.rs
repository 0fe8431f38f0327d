//! Children of this program: started, found dead, reaped.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::net::UnixStream;

use rustix::io::Errno;
use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
use signal_hook::SigId;
use signal_hook::consts::SIGCHLD;

use crate::bodies::family::{FAMILY, Kin};
use crate::bodies::procfs::{self, Stat};
use crate::bodies::sys::{self, Plan};
use crate::manager::Exit;

/// Starts a main process.
///
/// # Errors
/// The kernel's, for the fork.
pub(super) fn start(
    plan: &Plan<'_>,
    mark: String,
    group: Option<String>,
) -> io::Result<(Pid, OwnedFd)> {
    // Held over the fork: to a census, or to somebody who reaps orphans, a
    // child that nobody knows is an orphan.
    let mut family = FAMILY.lock();
    let (pid, pidfd) = sys::spawn(plan)?;
    let main = pid.as_raw_nonzero().get();
    family.insert(main, Kin::new(main, mark, group));
    Ok((pid, pidfd))
}

/// How a main process has ended, if it has. It is left unreaped, so that its
/// number and its session belong to nobody else while its kin is ended.
pub(super) fn ended(pidfd: &OwnedFd) -> Option<Exit> {
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    let status = match waitid(WaitId::PidFd(pidfd.as_fd()), options) {
        Ok(status) => status?,
        // A program that embeds the schedule manager may wait for whatever
        // child has ended. It is dead, and nobody knows how.
        Err(Errno::CHILD) => {
            return Some(Exit::Failed("somebody else has taken its exit status".to_owned()));
        }
        Err(_) => return None,
    };
    let signal = status.terminating_signal().map(Exit::Signal);
    signal.or_else(|| status.exit_status().map(Exit::Code))
}

/// Reaps a main process that has ended.
pub(super) fn reap(pid: Pid, pidfd: &OwnedFd) {
    let mut family = FAMILY.lock();
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG;
    let _ = waitid(WaitId::PidFd(pidfd.as_fd()), options);
    family.remove(&pid.as_raw_nonzero().get());
}

/// Reaps orphans that are dead. Other children of this program are left to who
/// started them: they are in this program's session, and orphans are not.
pub(super) fn reap_orphans() {
    let me = rustix::process::getpid().as_raw_nonzero().get();
    let family = FAMILY.lock();
    let own_session = Stat::of(me).map_or(0, |stat| stat.session);
    let is_orphan = |stat: &Stat| {
        stat.parent == me && stat.session != own_session && !family.contains_key(&stat.pid)
    };
    let reap = |pid: i32| {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG;
        procfs::pid(pid).is_some_and(|pid| matches!(waitid(WaitId::Pid(pid), options), Ok(Some(_))))
    };
    while let Some(dead) = sys::a_dead_child() {
        let dead = dead.as_raw_nonzero().get();
        if !(Stat::of(dead).is_some_and(|stat| is_orphan(&stat)) && reap(dead)) {
            // The kernel shows the first one only, and this one is not ours.
            // There may be more behind it.
            let hidden = procfs::family_of(me).unwrap_or_else(procfs::everybody);
            let hidden = hidden.iter().filter(|stat| stat.is_dead() && is_orphan(stat));
            for stat in hidden {
                reap(stat.pid);
            }
            return;
        }
    }
}

/// Readable when a child has ended or stopped, until it is silenced.
#[derive(Debug)]
pub(super) struct Bell {
    readable: UnixStream,
    handler: SigId,
}

impl Bell {
    /// A bell beside whatever else listens to the signal.
    ///
    /// # Errors
    /// When the host has no descriptor left.
    pub(super) fn new() -> io::Result<Self> {
        let (readable, writable) = UnixStream::pair()?;
        readable.set_nonblocking(true)?;
        writable.set_nonblocking(true)?;
        let handler = signal_hook::low_level::pipe::register(SIGCHLD, writable)?;
        Ok(Self { readable, handler })
    }

    /// To be called before the children are looked at, or a ring is lost.
    pub(super) fn silence(&self) {
        let mut buffer = [0; 64];
        while rustix::io::read(&self.readable, &mut buffer).is_ok_and(|length| length > 0) {}
    }
}

impl AsFd for Bell {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.readable.as_fd()
    }
}

impl Drop for Bell {
    fn drop(&mut self) {
        signal_hook::low_level::unregister(self.handler);
    }
}
