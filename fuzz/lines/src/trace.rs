//! Runs a program with breakpoints, each of which counts once.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs::File;
use std::os::unix::fs::FileExt as _;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result, bail, ensure};
use nix::sys::ptrace::{self, Options};
use nix::sys::signal::Signal;
use nix::sys::wait::{WaitPidFlag, WaitStatus, waitpid};
use nix::unistd::Pid;

/// The first argument of the child.
pub(crate) const HOST: &str = "trace-host";

const BREAKPOINT: u8 = 0xCC;

/// Which of these addresses, as its file has them, the program reaches.
pub(crate) fn reached(
    program: &Path,
    arguments: &[PathBuf],
    addresses: impl Iterator<Item = u64>,
) -> Result<BTreeSet<u64>> {
    // This program itself is the child that asks to be traced, and becomes the
    // other.
    let mut command = Command::new(std::env::current_exe()?);
    command.arg(HOST).arg(program).args(arguments);
    let said = File::create(program.with_extension("said"))?;
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(said);
    let child =
        command.spawn().with_context(|| format!("{} cannot be started", program.display()))?;
    let pid = Pid::from_raw(i32::try_from(child.id())?);
    match waitpid(pid, None)? {
        WaitStatus::Stopped(_, Signal::SIGTRAP) => {}
        other => bail!("{} cannot be traced: {other:?}", program.display()),
    }
    ptrace::setoptions(pid, Options::PTRACE_O_TRACECLONE | Options::PTRACE_O_EXITKILL)?;
    let mut traced = Traced::new(pid, program)?;
    traced.set(addresses)?;
    traced.run().with_context(|| format!("{0} said what is in {0}.said", program.display()))
}

/// The child's side: asks to be traced, and becomes the program.
///
/// # Errors
///
/// Whenever it returns.
pub(crate) fn host(mut arguments: impl Iterator<Item = OsString>) -> Result<()> {
    let program = arguments.next().context("which program?")?;
    ptrace::traceme().context("this process cannot be traced")?;
    let mut command = Command::new(program);
    // No thread of its own looks after memory and time: only what is read runs.
    Err(command.args(["-rss_limit_mb=0", "-timeout=0"]).args(arguments).exec().into())
}

struct Traced {
    pid: Pid,
    memory: File,
    base: u64,
    /// What stood where the breakpoints stand.
    before: BTreeMap<u64, u8>,
    reached: BTreeSet<u64>,
}

impl Traced {
    fn new(pid: Pid, program: &Path) -> Result<Self> {
        let memory = File::options().read(true).write(true).open(format!("/proc/{pid}/mem"))?;
        let maps = std::fs::read_to_string(format!("/proc/{pid}/maps"))?;
        let name = program.canonicalize()?;
        let first = maps.lines().find(|line| line.ends_with(&*name.to_string_lossy()));
        let start =
            first.and_then(|line| line.split('-').next()).context("the program is nowhere")?;
        let base = u64::from_str_radix(start, 16)?;
        Ok(Self { pid, memory, base, before: BTreeMap::new(), reached: BTreeSet::new() })
    }

    fn set(&mut self, addresses: impl Iterator<Item = u64>) -> Result<()> {
        for address in addresses {
            let mut byte = [0];
            self.memory.read_exact_at(&mut byte, self.base + address)?;
            self.memory.write_all_at(&[BREAKPOINT], self.base + address)?;
            self.before.insert(address, byte[0]);
        }
        Ok(())
    }

    fn run(mut self) -> Result<BTreeSet<u64>> {
        ptrace::cont(self.pid, None)?;
        loop {
            let (pid, signal) = match waitpid(None, Some(WaitPidFlag::__WALL))? {
                WaitStatus::Exited(pid, code) if pid == self.pid => {
                    ensure!(code == 0, "the program fails with {code}");
                    return Ok(self.reached);
                }
                WaitStatus::Signaled(pid, signal, _) if pid == self.pid => {
                    bail!("the program is ended by {signal}")
                }
                WaitStatus::Stopped(pid, Signal::SIGTRAP) => {
                    self.meet(pid)?;
                    (pid, None)
                }
                // A new thread begins stopped.
                WaitStatus::Stopped(pid, Signal::SIGSTOP) => (pid, None),
                WaitStatus::Stopped(pid, signal) => (pid, Some(signal)),
                WaitStatus::PtraceEvent(pid, ..) => (pid, None),
                _ => continue,
            };
            ptrace::cont(pid, signal)?;
        }
    }

    /// Takes the breakpoint away that was met, and lets its line run.
    fn meet(&mut self, pid: Pid) -> Result<()> {
        let mut registers = ptrace::getregs(pid)?;
        let address = registers.rip - 1 - self.base;
        let byte = self.before.get(&address).context("a trap that nobody has set")?;
        self.memory.write_all_at(&[*byte], self.base + address)?;
        self.reached.insert(address);
        registers.rip -= 1;
        ptrace::setregs(pid, registers).context("the program cannot go on")
    }
}
