//! What memory and storage there is, and what tasks use of it.
//!
//! A thread of its own measures, once in a while, and only where somebody wants
//! to know: a mission that says how much there is, a task that says how much it
//! needs. The manager's thread is told, and never looks itself.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use parking_lot::{Condvar, Mutex};
use rustix::fs::statvfs;

use crate::bodies::cgroup;
use crate::bodies::procfs;
use crate::executive::Waker;
use crate::manager::{Attempt, Reading};
use crate::mission::Mission;

/// How long after a measurement the next one is made.
const PERIOD: Duration = Duration::from_secs(1);

/// Where an attempt's processes are found.
#[derive(Clone, Debug)]
pub(super) struct Whereabouts {
    pub(super) main: i32,
    pub(super) group: Option<PathBuf>,
}

/// The attempts whose use is measured: those of tasks that say how much memory
/// they need.
#[derive(Clone, Debug, Default)]
pub(crate) struct Users(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    users: BTreeMap<Attempt, Whereabouts>,
    /// The last measurement, until it is taken.
    readings: Vec<Reading>,
    over: bool,
}

impl Users {
    pub(super) fn add(&self, attempt: Attempt, whereabouts: Whereabouts) {
        self.0.state.lock().users.insert(attempt, whereabouts);
        self.0.changed.notify_all();
    }

    pub(super) fn remove(&self, attempt: Attempt) {
        self.0.state.lock().users.remove(&attempt);
    }
}

/// Measures for a manager, until it goes.
#[derive(Debug)]
pub(crate) struct Gauge {
    users: Users,
    thread: Option<JoinHandle<()>>,
}

/// What of the host is measured.
#[derive(Clone, Debug)]
struct Host {
    memory: bool,
    storage: bool,
}

impl Gauge {
    /// Measures what this mission and these users want to know, once before
    /// this returns. The bell is rung when there is something to tell.
    ///
    /// # Errors
    /// When the host has no thread left.
    pub(crate) fn start(mission: &Mission, users: Users, manager: Waker) -> io::Result<Self> {
        let host = Host {
            memory: mission.memory.or(mission.memory_low).is_some(),
            storage: mission.storage.is_some(),
        };
        users.0.state.lock().readings = host.readings();
        let shared = Arc::clone(&users.0);
        let thread = std::thread::Builder::new().name("faregate-gauge".into());
        let thread = thread.spawn(move || measure(&host, &shared, &manager))?;
        Ok(Self { users, thread: Some(thread) })
    }

    /// What was measured since this was last asked; the last time counts.
    pub(crate) fn take(&self) -> Vec<Reading> {
        core::mem::take(&mut self.users.0.state.lock().readings)
    }
}

impl Drop for Gauge {
    fn drop(&mut self) {
        self.users.0.state.lock().over = true;
        self.users.0.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // What it reads is no disk: this is soon.
            let _ = thread.join();
        }
    }
}

fn measure(host: &Host, shared: &Shared, manager: &Waker) {
    let mut state = shared.state.lock();
    while !state.over {
        if state.users.is_empty() && !host.memory && !host.storage {
            shared.changed.wait(&mut state);
            continue;
        }
        // Users come and go meanwhile, and wait for their turn.
        shared.changed.wait_while_for(&mut state, |state| !state.over, PERIOD);
        if state.over {
            return;
        }
        let users = state.users.clone();
        parking_lot::MutexGuard::unlocked(&mut state, || {
            let mut readings = host.readings();
            readings.extend(users.iter().map(|(attempt, whereabouts)| Reading::Used {
                attempt: *attempt,
                memory: whereabouts.memory(),
            }));
            shared.state.lock().readings = readings;
            manager.wake();
        });
    }
}

impl Host {
    fn readings(&self) -> Vec<Reading> {
        let memory = self.memory.then(available_memory).flatten().map(Reading::Memory);
        let storage = self.storage.then(available_storage).flatten().map(Reading::Storage);
        memory.into_iter().chain(storage).collect()
    }
}

/// Bytes that can be had before the host is short of memory.
fn available_memory() -> Option<u64> {
    kibibytes(Path::new("/proc/meminfo"), "MemAvailable:")
}

/// Bytes that the file system has left on which tasks are started.
fn available_storage() -> Option<u64> {
    let host = statvfs(".").ok()?;
    Some(host.f_bavail.saturating_mul(host.f_frsize))
}

impl Whereabouts {
    /// Bytes of memory that the processes have in use. What they share with
    /// others is divided among all who do: a task's end hangs on it.
    fn memory(&self) -> u64 {
        let pids = match &self.group {
            Some(group) => cgroup::pids_below(group),
            None => procfs::family_of(self.main)
                .map_or_else(Vec::new, |all| all.iter().map(|stat| stat.pid).collect()),
        };
        pids.into_iter().filter_map(share).fold(0, u64::saturating_add)
    }
}

fn share(pid: i32) -> Option<u64> {
    kibibytes(&PathBuf::from(format!("/proc/{pid}/smaps_rollup")), "Pss:")
}

/// The line of this name in a file of the kernel's.
fn kibibytes(file: &Path, name: &str) -> Option<u64> {
    let text = fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let number: u64 = line.split_whitespace().next()?.parse().ok()?;
    number.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;
    use std::process::{Command, Stdio};

    use super::*;

    #[test]
    fn the_host_is_measured_where_the_mission_wants_to_know() {
        let measured = |mission: &Mission| {
            let gauge = Gauge::start(mission, Users::default(), Waker::new().unwrap()).unwrap();
            gauge.take()
        };
        assert_eq!(measured(&Mission::default()), []);
        let wants = Mission { memory_low: Some(1), storage: Some(1), ..Mission::default() };
        let readings = measured(&wants);
        let [Reading::Memory(memory), Reading::Storage(storage)] = &*readings else {
            panic!("{readings:?}")
        };
        assert!(*memory > 1 << 20 && *storage > 0, "{readings:?}");
    }

    /// What a shell uses once it has said that it is ready.
    fn used(script: &str) -> u64 {
        let mut shell = Command::new("sh");
        shell.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut shell = shell.spawn().unwrap();
        let mut ready = [0; 1];
        shell.stdout.take().unwrap().read_exact(&mut ready).unwrap();
        let main = shell.id().try_into().unwrap();
        let used = Whereabouts { main, group: None }.memory();
        // Whoever reads there ends.
        drop(shell.stdin.take());
        shell.wait().unwrap();
        used
    }

    #[test]
    fn a_process_uses_what_it_and_its_children_do() {
        let large = "all=$(head -c 30000000 /dev/zero | tr '\\0' x); echo; read -r end";
        let (small, child) = (used("echo; read -r end"), used(&format!("({large}); true")));
        assert!(small > 0 && small < 20_000_000, "{small}");
        assert!(child > 30_000_000, "{child}");
    }
}
