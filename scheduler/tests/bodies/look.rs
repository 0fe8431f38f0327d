//! What a test sees of processes, from outside.

use std::collections::BTreeSet;
use std::fs;
use std::time::{Duration, Instant};

/// One process as `/proc` shows it.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(crate) pid: i32,
    pub(crate) state: char,
    pub(crate) parent: i32,
    pub(crate) session: i32,
    /// Processor time used, in ticks.
    pub(crate) ticks: u64,
}

pub(crate) fn seen(pid: i32) -> Option<Seen> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let fields: Vec<&str> = stat.rsplit_once(") ")?.1.split(' ').collect();
    Some(Seen {
        pid,
        state: fields[0].chars().next()?,
        parent: fields[1].parse().ok()?,
        session: fields[3].parse().ok()?,
        ticks: fields[11].parse::<u64>().ok()? + fields[12].parse::<u64>().ok()?,
    })
}

/// Whether the process lives: one that is dead and not reaped does not.
pub(crate) fn lives(pid: i32) -> bool {
    seen(pid).is_some_and(|seen| seen.state != 'Z')
}

/// Everybody whose environment has this in it: a test marks its tasks with a
/// word of its own.
pub(crate) fn marked(word: &str) -> BTreeSet<i32> {
    let pids = fs::read_dir("/proc").unwrap().flatten();
    let pids = pids.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    pids.filter(|pid| {
        let environment = fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
        environment.windows(word.len()).any(|part| part == word.as_bytes()) && lives(*pid)
    })
    .collect()
}

/// What the process was executed as.
pub(crate) fn command(pid: i32) -> String {
    let words = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    String::from_utf8_lossy(&words).trim_end_matches('\0').replace('\0', " ")
}

/// Processor time that these have used together.
pub(crate) fn ticks(pids: &BTreeSet<i32>) -> u64 {
    pids.iter().filter_map(|pid| seen(*pid)).map(|seen| seen.ticks).sum()
}

/// Looks until there is something to see.
pub(crate) fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(value) = look() {
            return value;
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "not until now: {what}");
        real_time(Duration::from_millis(2));
    }
}

/// Lets real time pass.
#[expect(clippy::disallowed_methods, reason = "other processes run in real time")]
pub(crate) fn real_time(duration: Duration) {
    std::thread::sleep(duration);
}
