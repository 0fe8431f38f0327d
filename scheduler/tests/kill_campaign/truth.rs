//! What really happened: one file, to which everybody appends a line by one
//! write. It is no part of what is tested, and nobody's death takes from it.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Fact {
    /// A manager begins its life: it has swept what was left of the one before.
    Life,
    /// The acceptance of a task was answered.
    Accepted(u32),
    /// The process of a task began.
    Began(Try),
    /// It came to its end, and exits with this code.
    Ended(Try, i32),
    /// The device was turned on, or off.
    Device(bool),
}

/// An attempt, and the process that it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Try {
    pub(crate) task: u32,
    pub(crate) occurrence: u64,
    pub(crate) attempt: u32,
    pub(crate) process: u32,
}

/// Appends to the file.
#[derive(Debug)]
pub(crate) struct Chronicle(File);

fn file(place: &Path) -> PathBuf {
    place.join("truth")
}

impl Chronicle {
    pub(crate) fn open(place: &Path) -> io::Result<Self> {
        Ok(Self(OpenOptions::new().create(true).append(true).open(file(place))?))
    }

    pub(crate) fn note(&mut self, fact: &Fact) -> io::Result<()> {
        self.0.write_all(line(fact).as_bytes())
    }
}

fn line(fact: &Fact) -> String {
    let of = |one: &Try| format!("{} {} {} {}", one.task, one.occurrence, one.attempt, one.process);
    match fact {
        Fact::Life => "life\n".into(),
        Fact::Accepted(task) => format!("accepted {task}\n"),
        Fact::Began(one) => format!("began {}\n", of(one)),
        Fact::Ended(one, code) => format!("ended {} {code}\n", of(one)),
        Fact::Device(on) => format!("device {}\n", u8::from(*on)),
    }
}

/// Everything that happened there, in order.
pub(crate) fn read(place: &Path) -> io::Result<Vec<Fact>> {
    let text = std::fs::read_to_string(file(place))?;
    text.lines()
        .map(|line| parse(line).ok_or_else(|| io::Error::other(format!("no fact: {line:?}"))))
        .collect()
}

fn parse(line: &str) -> Option<Fact> {
    let words: Vec<_> = line.split(' ').collect();
    let one = |words: &[&str]| {
        let [task, occurrence, attempt, process] = words else { return None };
        Some(Try {
            task: task.parse().ok()?,
            occurrence: occurrence.parse().ok()?,
            attempt: attempt.parse().ok()?,
            process: process.parse().ok()?,
        })
    };
    Some(match &*words {
        ["life"] => Fact::Life,
        ["accepted", task] => Fact::Accepted(task.parse().ok()?),
        ["began", rest @ ..] => Fact::Began(one(rest)?),
        ["ended", rest @ .., code] => Fact::Ended(one(rest)?, code.parse().ok()?),
        ["device", on] => Fact::Device(*on == "1"),
        _ => return None,
    })
}
