//! What `/proc` says of processes.
//!
//! Eight fields of one file, read with three system calls: the manager's thread
//! walks all processes of the host when an attempt ends, and waits for it.

use std::fs;
use std::io;
use std::path::Path;

use rustix::fs::{CWD, Mode, OFlags, openat};
use rustix::process::{Pid, Signal};

/// One process at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stat {
    pub(super) pid: i32,
    pub(super) state: u8,
    pub(super) parent: i32,
    pub(super) session: i32,
    pub(super) threads: u32,
    /// When it was started, in the kernel's ticks since boot: with the number,
    /// it names a process for good.
    pub(super) start: u64,
    pub(super) resident_pages: u64,
}

impl Stat {
    /// The process as it is now; `None`: there is none.
    pub(super) fn of(pid: i32) -> Option<Self> {
        let mut buffer = [0; 1024];
        let length = read_into(&format!("/proc/{pid}/stat"), &mut buffer).ok()?;
        parse(buffer.get(..length)?)
    }

    /// Whether nothing of it runs any more. A dead leader may have threads that
    /// go on.
    pub(super) fn is_dead(&self) -> bool {
        matches!(self.state, b'Z' | b'X') && self.threads <= 1
    }

    /// Whether it still is the process that was seen.
    pub(super) fn is_still_there(&self) -> bool {
        Self::of(self.pid).is_some_and(|now| now.start == self.start)
    }
}

/// All processes that can be seen. Not of one moment: while it is read, some
/// end and some begin.
pub(super) fn everybody() -> Vec<Stat> {
    let Ok(entries) = fs::read_dir("/proc") else { return Vec::new() };
    let pids = entries.flatten().filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    pids.filter_map(Stat::of).collect()
}

/// This process and its descendants, at the cost of these alone. Where a child
/// ends while it is read, another may be passed over. `None`: the kernel keeps
/// no lists of children.
pub(super) fn family_of(me: i32) -> Option<Vec<Stat>> {
    children(me)?;
    let mut found = vec![Stat::of(me)?];
    let mut next = 0;
    while let Some(pid) = found.get(next).map(|stat| stat.pid) {
        found.extend(children(pid).into_iter().flatten().filter_map(Stat::of));
        next += 1;
    }
    Some(found)
}

/// Each thread of a process has children of its own.
fn children(pid: i32) -> Option<Vec<i32>> {
    let mut found: Vec<i32> = Vec::new();
    for thread in fs::read_dir(format!("/proc/{pid}/task")).ok()?.flatten() {
        match fs::read_to_string(thread.path().join("children")) {
            Ok(pids) => {
                found.extend(pids.split_whitespace().filter_map(|pid| pid.parse::<i32>().ok()))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound && thread.path().exists() => {
                return None;
            }
            Err(_) => {}
        }
    }
    Some(found)
}

/// Whether no thread of the process executes another instruction of its program
/// before it is let go on: each is stopped or dead, or inside the kernel, where
/// a signal to stop awaits it. (A shell that waits for the child that it has
/// just forked does so in there, for as long as that child is stopped.)
pub(super) fn stands_still(pid: i32) -> bool {
    let Ok(threads) = fs::read_dir(format!("/proc/{pid}/task")) else { return true };
    let states: Vec<u8> = threads.flatten().filter_map(|thread| state(&thread.path())).collect();
    let stopped = |state: &u8| matches!(state, b'T' | b't');
    let is_still = |state: &u8| stopped(state) || matches!(state, b'Z' | b'X' | b'D');
    let awaited = || states.iter().any(stopped) || stop_is_pending(pid);
    states.iter().all(is_still) && (!states.contains(&b'D') || awaited())
}

fn state(thread: &Path) -> Option<u8> {
    let mut buffer = [0; 1024];
    let length = read_into(&format!("{}/stat", thread.display()), &mut buffer).ok()?;
    buffer.get(..length).and_then(parse).map(|stat| stat.state)
}

/// Whether SIGSTOP was sent to the process and nobody has taken it yet.
fn stop_is_pending(pid: i32) -> bool {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let mut masks = status.lines().filter_map(|line| line.strip_prefix("ShdPnd:"));
    let mask = masks.next().and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    let stop = 1 << (Signal::STOP.as_raw() - 1);
    mask.is_some_and(|mask: u64| mask & stop != 0)
}

/// The environment that the process was executed with, as `NAME=value` lines
/// that end with a zero. Empty where it may not be seen. `None`: the process is
/// between two programs, or about to be none, and has no environment.
pub(super) fn environment(pid: i32) -> Option<Vec<u8>> {
    let read = || fs::read(format!("/proc/{pid}/environ"));
    match read() {
        Ok(empty) if empty.is_empty() => {
            let mut buffer = [0; 1024];
            let length = read_into(&format!("/proc/{pid}/stat"), &mut buffer).unwrap_or(0);
            let fields = buffer.get(..length).and_then(fields);
            let begins = fields.and_then(|(_, fields)| fields.get(ENVIRONMENT).copied());
            // It may have come to its program since it was read.
            if begins == Some("0") { None } else { Some(read().unwrap_or_default()) }
        }
        Ok(environment) => Some(environment),
        Err(_) => Some(Vec::new()),
    }
}

/// The control group that the process is in, below the root of the groups.
pub(super) fn control_group(pid: i32) -> String {
    let groups = fs::read_to_string(format!("/proc/{pid}/cgroup")).unwrap_or_default();
    groups.lines().find_map(|line| line.strip_prefix("0::")).unwrap_or_default().to_owned()
}

/// The value of a variable in what [`environment`] gave.
pub(super) fn variable<'a>(environment: &'a [u8], name: &str) -> Option<&'a str> {
    let value = environment.split(|byte| *byte == 0).find_map(|line| {
        line.strip_prefix(name.as_bytes()).and_then(|rest| rest.strip_prefix(b"="))
    })?;
    str::from_utf8(value).ok()
}

/// The number as the kernel's calls take it.
pub(super) fn pid(raw: i32) -> Option<Pid> {
    if raw > 0 { Pid::from_raw(raw) } else { None }
}

fn read_into(path: &str, buffer: &mut [u8]) -> io::Result<usize> {
    let file = openat(CWD, path, OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?;
    Ok(rustix::io::read(&file, buffer)?)
}

/// Where the environment begins, among the fields after the name.
const ENVIRONMENT: usize = 47;

/// `pid (name) state parent group session ...`. The name may have spaces and
/// parentheses in it: what counts begins after the last one.
fn fields(line: &[u8]) -> Option<(&str, Vec<&str>)> {
    let (opens, closes) =
        (line.iter().position(|b| *b == b'(')?, line.iter().rposition(|b| *b == b')')?);
    let pid = str::from_utf8(line.get(..opens)?).ok()?;
    let rest = str::from_utf8(line.get(closes + 1..)?).ok()?;
    Some((pid.trim(), rest.split_ascii_whitespace().collect()))
}

fn parse(line: &[u8]) -> Option<Stat> {
    let (pid, fields) = fields(line)?;
    Some(Stat {
        pid: pid.parse().ok()?,
        state: *fields.first()?.as_bytes().first()?,
        parent: fields.get(1)?.parse().ok()?,
        session: fields.get(3)?.parse().ok()?,
        threads: fields.get(17)?.parse().ok()?,
        start: fields.get(19)?.parse().ok()?,
        resident_pages: fields.get(21)?.parse().unwrap_or(0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_parentheses_does_not_shift_the_fields() {
        let line = b"42 (a) R (b) S 7 42 40 0 -1 0 1 2 3 4 5 6 7 8 20 0 3 0 991 10 555 0";
        let stat = parse(line).unwrap();
        let expected = Stat {
            pid: 42,
            state: b'S',
            parent: 7,
            session: 40,
            threads: 3,
            start: 991,
            resident_pages: 555,
        };
        assert_eq!(stat, expected);
        assert_eq!(parse(b"42 (a) S 7"), None);
    }

    #[test]
    fn this_process_is_seen_with_its_parent_and_is_not_still() {
        let me = rustix::process::getpid().as_raw_nonzero().get();
        let stat = everybody().into_iter().find(|stat| stat.pid == me).unwrap();
        let parent = rustix::process::getppid().map(|pid| pid.as_raw_nonzero().get());
        assert_eq!(Some(stat.parent), parent);
        assert!(!stat.is_dead() && stat.is_still_there() && !stands_still(me));
    }

    #[test]
    fn a_child_is_found_by_either_way() {
        let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
        let me = rustix::process::getpid().as_raw_nonzero().get();
        let sees = |all: Vec<Stat>| {
            all.iter().any(|stat| Some(stat.pid) == child.id().try_into().ok() && stat.parent == me)
        };
        assert!(sees(everybody()));
        match family_of(me) {
            Some(family) => {
                assert!(sees(family.clone()));
                assert!(family.iter().all(|stat| stat.pid != 1), "it is not the family alone");
            }
            None => println!("skipped: this kernel keeps no lists of children"),
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }

    #[test]
    fn a_variable_is_found_by_its_whole_name() {
        let environment = b"A_B=1\0B=2=3\0";
        assert_eq!(variable(environment, "B"), Some("2=3"));
        assert_eq!(variable(environment, "A"), None);
    }
}
