//! Control groups: the kernel's own list of what an attempt has started.
//!
//! A process is in its group from birth, and so is what it forks, whatever it
//! does to its session or its parents. The whole group is frozen, and killed,
//! by one write. Used where the manager may make groups below its own one
//! (version 2 of the interface, Linux 5.14).

use core::cell::Cell;
use std::fs::{self, File};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use rustix::fs::{CWD, Mode, OFlags, openat};

/// What the names of managers' groups begin with.
const PREFIX: &str = "faregate-";

/// How many groups without an attempt are kept for the next ones: a start that
/// is due need not wait until one is made.
const KEPT: usize = 8;

/// The group of one manager, above those of its attempts.
#[derive(Debug)]
pub(super) struct Groups {
    path: PathBuf,
    made: u64,
    free: Vec<Group>,
}

impl Groups {
    /// Makes the group of this run.
    ///
    /// # Errors
    /// Why there is none, for people.
    pub(super) fn make(run: &str) -> Result<Self, String> {
        let own = own_group()?;
        let path = own.join(format!("{PREFIX}{run}"));
        fs::create_dir(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut groups = Self { path, made: 0, free: Vec::new() };
        for file in ["cgroup.freeze", "cgroup.kill"] {
            if !groups.path.join(file).exists() {
                return Err(format!("the kernel has no {file}: it is older than Linux 5.14"));
            }
        }
        for _ in 0..KEPT {
            let group = groups.another().map_err(|error| error.to_string())?;
            groups.free.push(group);
        }
        Ok(groups)
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// A group for one attempt.
    ///
    /// # Errors
    /// The kernel's.
    pub(super) fn group(&mut self) -> io::Result<Group> {
        self.free.pop().map_or_else(|| self.another(), Ok)
    }

    /// Takes a group back that nobody is in. One that was killed is replaced:
    /// who is forked into it later may be killed at birth. Linux 6.18 kills a
    /// child if its group and its parent's were not killed equally often.
    pub(super) fn keep(&mut self, group: Group) {
        if self.free.len() >= KEPT {
            return;
        }
        let usable = !group.killed.get() && !group.state().populated;
        let next = if usable && group.freeze(false).is_ok() {
            Some(group)
        } else {
            drop(group);
            self.another().ok()
        };
        self.free.extend(next);
    }

    fn another(&mut self) -> io::Result<Group> {
        let path = self.path.join(self.made.to_string());
        self.made += 1;
        fs::create_dir(&path)?;
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
        let open = || {
            let directory = openat(CWD, &path, flags, Mode::empty())?;
            Ok((directory, File::open(path.join("cgroup.events"))?))
        };
        match open() {
            Ok((directory, events)) => {
                Ok(Group { path, directory, events, killed: Cell::new(false) })
            }
            Err(error) => {
                let _ = fs::remove_dir(&path);
                Err(error)
            }
        }
    }
}

impl Drop for Groups {
    fn drop(&mut self) {
        self.free.clear();
        // What is not empty stays, for the sweep of the next start.
        let _ = fs::remove_dir(&self.path);
    }
}

/// The group of one attempt.
#[derive(Debug)]
pub(super) struct Group {
    path: PathBuf,
    directory: OwnedFd,
    events: File,
    killed: Cell<bool>,
}

/// What the kernel says of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GroupState {
    /// It has a process that lives.
    pub(super) populated: bool,
    /// Nothing of it runs.
    pub(super) frozen: bool,
}

impl Group {
    /// Its name, which is nobody else's: that of its manager's group, and its
    /// own.
    pub(super) fn name(&self) -> String {
        let parts = self.path.iter().rev().take(2).collect::<Vec<_>>();
        parts.into_iter().rev().collect::<PathBuf>().display().to_string()
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Where a process is forked into.
    pub(super) fn directory(&self) -> BorrowedFd<'_> {
        self.directory.as_fd()
    }

    /// Reports urgent data when the state has changed since it was last read.
    pub(super) fn events(&self) -> BorrowedFd<'_> {
        self.events.as_fd()
    }

    pub(super) fn state(&self) -> GroupState {
        let mut buffer = [0; 256];
        let length = self.events.read_at(&mut buffer, 0).unwrap_or(0);
        let says = |line: &[u8]| {
            buffer.get(..length).is_some_and(|text| text.split(|b| *b == b'\n').any(|l| l == line))
        };
        GroupState { populated: says(b"populated 1"), frozen: says(b"frozen 1") }
    }

    pub(super) fn freeze(&self, frozen: bool) -> io::Result<()> {
        fs::write(self.path.join("cgroup.freeze"), if frozen { "1" } else { "0" })
    }

    /// Kills everything in it at once, a fork in progress included.
    pub(super) fn kill(&self) -> io::Result<()> {
        self.killed.set(true);
        fs::write(self.path.join("cgroup.kill"), "1")
    }

    /// Whom it holds, the dead that were not reaped not among them. A task may
    /// make groups below its own: it is frozen and killed with them.
    pub(super) fn pids(&self) -> Vec<i32> {
        pids_below(&self.path)
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        remove(&self.path);
    }
}

/// Whom a group and the groups below it hold.
pub(super) fn pids_below(path: &Path) -> Vec<i32> {
    let mut pids = pids_in(path);
    for entry in fs::read_dir(path).into_iter().flatten().flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            pids.extend(pids_below(&entry.path()));
        }
    }
    pids
}

/// Removes a group and the groups below it, as far as they are empty.
pub(super) fn remove(path: &Path) {
    for entry in fs::read_dir(path).into_iter().flatten().flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            remove(&entry.path());
        }
    }
    let _ = fs::remove_dir(path);
}

fn pids_in(path: &Path) -> Vec<i32> {
    let list = fs::read_to_string(path.join("cgroup.procs")).unwrap_or_default();
    list.lines().filter_map(|line| line.parse().ok()).collect()
}

/// The directory of the group that this process is in.
fn own_group() -> Result<PathBuf, String> {
    let text = |path: &str| fs::read_to_string(path).map_err(|error| format!("{path}: {error}"));
    let groups = text("/proc/self/cgroup")?;
    let own = groups.lines().find_map(|line| line.strip_prefix("0::"));
    let own = own.ok_or("the host has no control groups of version 2")?;
    let mounts = text("/proc/self/mountinfo")?;
    mounts
        .lines()
        .find_map(|line| mounted(line, own))
        .ok_or_else(|| format!("the control group {own} is mounted nowhere"))
}

/// Where this mount shows the group, if it is one of control groups. Of
/// `id parent device root point options ... - kind ...` these matter.
fn mounted(line: &str, group: &str) -> Option<PathBuf> {
    let (mount, kind) = line.split_once(" - ")?;
    let mut fields = mount.split(' ').skip(3);
    let (root, point) = (fields.next()?, fields.next()?);
    if kind.split(' ').next() != Some("cgroup2") {
        return None;
    }
    let below = Path::new(group).strip_prefix(root).ok()?;
    Some(Path::new(point).join(below))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_is_found_below_the_root_that_is_mounted() {
        let whole = "34 24 0:29 / /sys/fs/cgroup rw,nosuid - cgroup2 cgroup2 rw";
        let part = "34 24 0:29 /a /mnt rw - cgroup2 none rw";
        let other = "34 24 0:29 / /sys/fs/cgroup rw - tmpfs tmpfs rw";
        let found = |line, group| mounted(line, group).map(|path| path.display().to_string());
        assert_eq!(found(whole, "/a/b").as_deref(), Some("/sys/fs/cgroup/a/b"));
        assert_eq!(found(part, "/a/b").as_deref(), Some("/mnt/b"));
        assert_eq!(found(part, "/c"), None);
        assert_eq!(found(other, "/a"), None);
    }
}
