//! The parent's side: starts the child, and steps it through its calls.

use std::path::Path;
use std::process::{Child as Process, Command, Stdio};

use anyhow::{Context as _, Result, bail};
use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
use nix::sys::ptrace;
use nix::sys::resource::{Resource, getrlimit, setrlimit};
use nix::sys::signal::Signal;
use nix::sys::wait::{WaitStatus, waitpid};
use nix::unistd::Pid;

use super::Call;

/// A traced child, which calls one function again and again.
pub(super) struct Child {
    process: Process,
    pid: Pid,
    has_stopped: bool,
    has_ended: bool,
}

/// A child that stands before a call.
pub(super) struct Stopped<'a>(&'a mut Child);

/// Lets the children have stacks as deep as they are allowed to be: what sets
/// up a large static may build it there first.
///
/// # Errors
/// Where the kernel refuses.
pub(super) fn deepen_stacks() -> Result<()> {
    let (_, most) = getrlimit(Resource::RLIMIT_STACK).context("no limits are known")?;
    let depth = most.min(STACK);
    setrlimit(Resource::RLIMIT_STACK, depth, most).context("the stack's limit cannot be raised")
}

/// Enough for a static of some ten megabytes, built and moved.
const STACK: u64 = 1 << 30;

/// The processors that this process may be on.
///
/// # Errors
/// Where the kernel does not say.
pub(super) fn processors() -> Result<Vec<usize>> {
    let allowed = sched_getaffinity(Pid::from_raw(0)).context("no processors are known")?;
    Ok((0..CpuSet::count()).filter(|&cpu| allowed.is_set(cpu) == Ok(true)).collect())
}

/// Keeps this thread, and children that it starts, on one processor: from one to
/// another each step would take several times as long.
///
/// # Errors
/// Where the kernel refuses.
pub(super) fn stay_on(processor: usize) -> Result<()> {
    let mut one = CpuSet::new();
    one.set(processor)?;
    sched_setaffinity(Pid::from_raw(0), &one).context("no thread can stay on one processor")
}

impl Child {
    /// Starts the program itself as the child.
    pub(super) fn start(path: &Path, symbol: &str, calls: u64) -> Result<Self> {
        let program = std::env::current_exe().context("this program does not know where it is")?;
        let process = Command::new(program)
            .arg("step-host")
            .args([path.as_os_str(), symbol.as_ref()])
            .arg(calls.to_string())
            .stdin(Stdio::null())
            .spawn()
            .context("the child cannot be started")?;
        let pid = Pid::from_raw(i32::try_from(process.id())?);
        Ok(Self { process, pid, has_stopped: false, has_ended: false })
    }

    /// Lets the child run to its next call; `None` when it has made them all.
    pub(super) fn next(&mut self) -> Result<Option<Stopped<'_>>> {
        if self.has_stopped {
            ptrace::cont(self.pid, None).context("the child cannot be continued")?;
        }
        match self.wait()? {
            Some(()) => Ok(Some(Stopped(self))),
            None => Ok(None),
        }
    }

    /// Waits until the child stops; `None` where it has ended well.
    fn wait(&mut self) -> Result<Option<()>> {
        let status = waitpid(self.pid, None).context("the child cannot be waited for")?;
        self.has_ended = !matches!(status, WaitStatus::Stopped(..));
        match status {
            WaitStatus::Stopped(_, Signal::SIGTRAP) => {
                self.has_stopped = true;
                Ok(Some(()))
            }
            WaitStatus::Exited(_, 0) => Ok(None),
            WaitStatus::Exited(_, code) => bail!("the child ended with {code}: see above"),
            WaitStatus::Stopped(_, signal) | WaitStatus::Signaled(_, signal, _) => {
                bail!("the called function ended with {signal}")
            }
            other => bail!("the child did what no child does: {other:?}"),
        }
    }

    fn step(&mut self) -> Result<()> {
        ptrace::step(self.pid, None).context("the child cannot be stepped")?;
        match self.wait()? {
            Some(()) => Ok(()),
            None => bail!("the child ended inside the call"),
        }
    }

    fn at(&self) -> Result<u64> {
        Ok(ptrace::getregs(self.pid).context("the child has no registers")?.rip)
    }
}

impl Stopped<'_> {
    /// Steps through the call of the function whose own address is `start`,
    /// `most` instructions at most, and then lets it run to its end.
    pub(super) fn call(
        self,
        start: u64,
        is_audited: impl Fn(u64) -> bool,
        most: u64,
    ) -> Result<Call> {
        let child = self.0;
        child.step()?;
        let entered = ptrace::getregs(child.pid).context("the child has no registers")?;
        let back = ptrace::read(child.pid, entered.rsp as ptrace::AddressType)
            .context("the child has no stack")?
            .cast_unsigned();
        // The loader put the object somewhere.
        let moved = entered.rip.wrapping_sub(start);
        let mut call = Call { counted: 0, elsewhere: 0, first_elsewhere: None, is_whole: false };
        let mut at = entered.rip;
        while at != back && call.counted + call.elsewhere < most {
            let own = at.wrapping_sub(moved);
            if is_audited(own) {
                call.counted += 1;
            } else {
                call.elsewhere += 1;
                call.first_elsewhere.get_or_insert(own);
            }
            child.step()?;
            at = child.at()?;
        }
        call.is_whole = at == back;
        if call.is_whole {
            // To the breakpoint after the call.
            ptrace::cont(child.pid, None).context("the child cannot be continued")?;
            child.wait()?;
        }
        Ok(call)
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        if !self.has_ended {
            // What is not there any more needs no end.
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}
