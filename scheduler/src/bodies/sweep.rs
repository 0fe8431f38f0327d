//! What a manager that was killed has left behind, and its end.
//!
//! The main processes of its attempts have died with it. What those had started
//! may live on, adopted by the host's first process. The next manager finds it
//! by the control group of that run, or by the mark in its environment, and
//! kills it before it starts anything.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{PidfdFlags, Signal, pidfd_open, pidfd_send_signal};
use serde::{Deserialize, Serialize};

use crate::bodies::cgroup::{self, Groups};
use crate::bodies::family::MARK;
use crate::bodies::launch;
use crate::bodies::procfs::{self, Stat};
use crate::bodies::settings::Settings;

/// Where a run of the manager is written down.
const FILE: &str = "bodies.json";

/// How often everything is looked at again, until nothing is left.
const ROUNDS: u32 = 200;

/// How long one of those that were killed is waited for in each round.
const ROUND: Timespec = Timespec { tv_sec: 0, tv_nsec: 50_000_000 };

/// One run of the manager, as the next one finds it.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Written {
    run: String,
    /// The host's own name for the time since it was started: processes do not
    /// outlive that.
    boot: String,
    manager: i32,
    manager_start: u64,
    control_group: Option<PathBuf>,
}

/// This run of the manager.
#[derive(Debug)]
pub(super) struct Run {
    id: String,
    state: Option<PathBuf>,
    pub(super) groups: Result<Groups, String>,
    pub(super) swept: Vec<Swept>,
}

impl Run {
    /// A run that no other one is confused with. If the settings say where runs
    /// are written down, the last one is swept before this one is.
    ///
    /// # Errors
    /// As [`sweep`], and when the host shows no processes.
    pub(super) fn begin(settings: &Settings) -> io::Result<Self> {
        let swept = settings.state.as_deref().map(sweep).transpose()?.unwrap_or_default();
        let id = fs::read_to_string("/proc/sys/kernel/random/uuid")?.trim().to_owned();
        let groups = if settings.control_groups {
            Groups::make(&id).and_then(|mut groups| {
                let group = groups.group().map_err(|error| error.to_string())?;
                launch::lives_in(&group)?;
                groups.keep(group);
                Ok(groups)
            })
        } else {
            Err("they are not to be used".to_owned())
        };
        let run = Self { id, state: settings.state.clone(), groups, swept };
        if let Some(state) = &run.state {
            run.write(state)?;
        }
        Ok(run)
    }

    /// Nothing of it is left: there is nothing to be swept.
    pub(super) fn is_over(&self) {
        if let Some(state) = &self.state {
            let _ = fs::remove_file(state.join(FILE));
        }
    }

    /// What marks the processes of an attempt.
    pub(super) fn mark(&self, serial: u64) -> String {
        format!("{}.{serial}", self.id)
    }

    /// Written beside, and then put in place: a file is whole or not there.
    /// Nothing is synced: after a loss of power there are no processes.
    fn write(&self, state: &Path) -> io::Result<()> {
        let pid = rustix::process::getpid().as_raw_nonzero().get();
        let me = Stat::of(pid).ok_or_else(|| io::Error::other("/proc shows no processes"))?;
        let written = Written {
            run: self.id.clone(),
            boot: boot()?,
            manager: pid,
            manager_start: me.start,
            control_group: self.groups.as_ref().ok().map(|groups| groups.path().to_owned()),
        };
        let beside = state.join(format!("{FILE}.new"));
        fs::create_dir_all(state)?;
        fs::write(&beside, serde_json::to_vec(&written)?)?;
        fs::rename(&beside, state.join(FILE))
    }
}

/// A process that a sweep has killed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Swept {
    /// Its number.
    pub pid: i32,
    /// The task whose attempt had started it, where it says so.
    pub task: Option<u32>,
    /// What it was executed as, where it may be seen.
    pub command: String,
}

/// Ends what the last manager that kept its state here has left behind, and
/// answers what was killed. [`RealBodies`](crate::bodies::RealBodies) does it
/// when it is made, before anything can be started.
///
/// # Errors
/// That manager is still there; the file cannot be read; or something does not
/// die, and the error names it.
pub fn sweep(state: &Path) -> io::Result<Vec<Swept>> {
    let swept = end_left(state)?;
    if let Some(group) = last(state)?.and_then(|run| run.control_group) {
        cgroup::remove(&group);
    }
    match fs::remove_file(state.join(FILE)) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(swept),
    }
}

/// The same, and what is written of that manager stays: for who has no lock
/// yet, and may not be the only one who does this.
///
/// # Errors
/// As [`sweep`].
pub(crate) fn end_left(state: &Path) -> io::Result<Vec<Swept>> {
    let mut swept = Vec::new();
    if let Some(run) = last(state)? {
        run.is_over()?;
        run.kill_all(&mut swept)?;
    }
    Ok(swept)
}

/// What is written of the last run in this start of the host.
fn last(state: &Path) -> io::Result<Option<Written>> {
    let text = match fs::read(state.join(FILE)) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    // A file is whole as long as the host runs. One that is not has come
    // through a loss of power, which no process has.
    let run = serde_json::from_slice::<Written>(&text).ok();
    Ok(run.filter(|run| boot().is_ok_and(|boot| run.boot == boot)))
}

impl Written {
    fn is_over(&self) -> io::Result<()> {
        let lives = Stat::of(self.manager)
            .is_some_and(|stat| stat.start == self.manager_start && !stat.is_dead());
        if lives {
            let pid = self.manager;
            let why = format!("another manager (process {pid}) keeps its state here");
            return Err(io::Error::new(ErrorKind::AddrInUse, why));
        }
        Ok(())
    }

    fn kill_all(&self, swept: &mut Vec<Swept>) -> io::Result<()> {
        let mut left = Vec::new();
        for _ in 0..ROUNDS {
            left = self.left();
            if left.is_empty() {
                return Ok(());
            }
            for stat in &left {
                if !swept.iter().any(|known| known.pid == stat.pid) {
                    swept.push(describe(stat));
                }
            }
            if let Some(group) = &self.control_group {
                let _ = fs::write(group.join("cgroup.kill"), "1");
            }
            left.iter().for_each(end);
        }
        let pids: Vec<_> = left.iter().map(|stat| stat.pid.to_string()).collect();
        Err(io::Error::other(format!("killed, and does not die: process {}", pids.join(", "))))
    }

    /// What lives of that run: who is in its group, who has its mark, who is in
    /// a session with one of them, and their descendants.
    fn left(&self) -> Vec<Stat> {
        let all: Vec<Stat> =
            procfs::everybody().into_iter().filter(|stat| !stat.is_dead()).collect();
        let mine = rustix::process::getpid().as_raw_nonzero().get();
        let own_session = all.iter().find(|stat| stat.pid == mine).map(|stat| stat.session);
        let listed = self.control_group.iter().flat_map(|group| cgroup::pids_below(group));
        let mut found: BTreeSet<i32> = listed.collect();
        found.extend(all.iter().filter(|stat| self.has_marked(stat)).map(|stat| stat.pid));
        let mut known = 0;
        while known < found.len() {
            known = found.len();
            let sessions: BTreeSet<i32> = all
                .iter()
                .filter(|stat| found.contains(&stat.pid) && Some(stat.session) != own_session)
                .map(|stat| stat.session)
                .collect();
            let related =
                |stat: &&Stat| found.contains(&stat.parent) || sessions.contains(&stat.session);
            let more: Vec<i32> = all.iter().filter(related).map(|stat| stat.pid).collect();
            found.extend(more);
        }
        found.remove(&mine);
        all.into_iter().filter(|stat| found.contains(&stat.pid)).collect()
    }

    fn has_marked(&self, stat: &Stat) -> bool {
        let environment = procfs::environment(stat.pid).unwrap_or_default();
        let mark = procfs::variable(&environment, MARK);
        mark.and_then(|mark| mark.split('.').next()) == Some(&*self.run)
    }
}

/// Kills who was seen, and waits until it is dead, but not for ever.
fn end(seen: &Stat) {
    let Some(pid) = procfs::pid(seen.pid) else { return };
    let Ok(pidfd) = pidfd_open(pid, PidfdFlags::empty()) else { return };
    if seen.is_still_there() {
        let _ = pidfd_send_signal(&pidfd, Signal::KILL);
        let _ = poll(&mut [PollFd::new(&pidfd, PollFlags::IN)], Some(&ROUND));
    }
}

fn describe(stat: &Stat) -> Swept {
    let environment = procfs::environment(stat.pid).unwrap_or_default();
    let task = procfs::variable(&environment, "FAREGATE_TASK");
    let command = fs::read(format!("/proc/{}/cmdline", stat.pid)).unwrap_or_default();
    let words = command.split(|byte| *byte == 0).filter(|word| !word.is_empty());
    let words: Vec<_> = words.map(String::from_utf8_lossy).collect();
    let task = task.and_then(|number| number.parse().ok());
    Swept { pid: stat.pid, task, command: words.join(" ") }
}

fn boot() -> io::Result<String> {
    Ok(fs::read_to_string("/proc/sys/kernel/random/boot_id")?.trim().to_owned())
}
