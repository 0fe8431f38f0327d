//! Records as a manager writes them.

use std::path::PathBuf;

use faregate_scheduler::manager::{Attempt, Occurrence, Record};
use faregate_scheduler::task::{Body, Outcome, Task, TaskId};
use faregate_scheduler::time::{Duration, Instant, UnixTime};

use crate::support::Failure;

/// A task as a schedule file has it: a program with arguments.
pub(crate) fn accepted(number: u32) -> Result<Record, Failure> {
    let id = TaskId::new(number).ok_or("a task's number is not 0")?;
    let arguments = vec!["--target".into(), format!("{number}"), "--exposure".into(), "250".into()];
    let body = Body::Process { program: "/opt/payload/bin/image".into(), arguments };
    let task = Task { duration: Duration::from_secs(30), ..Task::new(id, body) };
    Ok(Record::Accepted {
        task: Box::new(task),
        load: 0,
        position: number.into(),
        at: Instant::START,
        wall: UnixTime::from_secs(1_900_000_000),
    })
}

/// The life of an occurrence, record by record.
pub(crate) fn life(number: u32, occurrence: u64) -> Result<[Record; 4], Failure> {
    let task = TaskId::new(number).ok_or("a task's number is not 0")?;
    let occurrence = Occurrence { task, load: 0, number: occurrence };
    let attempt = Attempt { occurrence, number: 1 };
    let (outcome, wall) = (Outcome::Succeeded, UnixTime::from_secs(1_900_000_000));
    Ok([
        Record::Armed { occurrence },
        Record::Starting { attempt },
        Record::Over { attempt, outcome: Some(outcome) },
        Record::Ended { occurrence, outcome, wall },
    ])
}

/// A directory that goes away, on a disk: where the build is, since `/tmp` may
/// be memory.
pub(crate) fn place() -> Result<tempfile::TempDir, Failure> {
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    let target = PathBuf::from(target);
    std::fs::create_dir_all(&target)?;
    Ok(tempfile::tempdir_in(target)?)
}
