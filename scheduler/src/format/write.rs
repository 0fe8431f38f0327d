//! Tasks and mission as a file, and what the file cannot hold.

mod differences;
mod mission;
mod native;
mod rows;
mod text;

use core::fmt;

use serde::Serialize;

use crate::format::{self, Against, Kind, Options};
use crate::mission::Mission;
use crate::task::{Task, TaskId};

/// Something that a format cannot hold.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotHeld {
    /// Of which task; none: of the mission.
    pub task: Option<TaskId>,
    /// Which field, by its name in the native format; `task` where the whole
    /// task is left out.
    pub field: &'static str,
    /// Why.
    pub why: String,
}

impl fmt::Display for NotHeld {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.task {
            Some(task) => write!(f, "{task}: {}: {}", self.field, self.why),
            None => write!(f, "{}: {}", self.field, self.why),
        }
    }
}

/// Writes a file, and lists what it does not hold.
///
/// The list is not what a format is thought to lose: each task is read again
/// from what was written of it and compared. A task that could not be read
/// again is left out.
#[must_use]
pub fn write(kind: Kind, tasks: &[Task], mission: Option<&Mission>) -> (String, Vec<NotHeld>) {
    let mut lost = Vec::new();
    let kept: Vec<&Task> =
        tasks.iter().filter(|task| is_kept(kind, task, mission, &mut lost)).collect();
    if let Some(mission) = mission {
        differences::of_mission(kind, mission, &mut lost);
    }
    let text = match kind {
        Kind::Toml => native::write(&kept, mission, mission),
        Kind::Csv | Kind::Txt => rows_of(kind, &kept),
    };
    (text, lost)
}

fn rows_of(kind: Kind, tasks: &[&Task]) -> String {
    if kind == Kind::Txt { rows::txt(tasks) } else { rows::csv(tasks) }
}

/// Writes one task, reads it again, and lists what is not the same; `false` if
/// it cannot be read again.
fn is_kept(kind: Kind, task: &Task, mission: Option<&Mission>, lost: &mut Vec<NotHeld>) -> bool {
    let of_task = |field, why| NotHeld { task: Some(task.id), field, why };
    if let Some(why) = rows::why_not(kind, task) {
        lost.push(of_task("task", why));
        return false;
    }
    let text = match kind {
        Kind::Toml => native::write(&[task], None, mission),
        Kind::Csv | Kind::Txt => rows_of(kind, &[task]),
    };
    match read_again(kind, &text, mission) {
        Err(why) => {
            lost.push(of_task("task", why));
            false
        }
        Ok(again) => {
            let fields = differences::of_tasks(task, &again);
            lost.extend(
                fields.into_iter().map(|field| of_task(field, differences::why(kind, field))),
            );
            true
        }
    }
}

/// The one task of a text, whatever mission it needs.
fn read_again(kind: Kind, text: &str, mission: Option<&Mission>) -> Result<Task, String> {
    let options =
        Options { kind: Some(kind), whole: false, against: Against::Nothing, ..Options::default() };
    let mut loaded =
        format::read_named(options, "", text.as_bytes(), mission).map_err(|found| {
            let first = found.into_iter().find(format::Diagnostic::is_error);
            first.map_or_else(String::new, |first| format!("left out: {}", first.message))
        })?;
    match (loaded.tasks.pop(), loaded.tasks.is_empty()) {
        (Some(task), true) => Ok(task),
        _ => Err("left out: it would not be read as one task".to_owned()),
    }
}
