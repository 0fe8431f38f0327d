//! Where the tasks of a running manager stand.

use anstyle::Style;
use comfy_table::Cell;
use faregate_client::wire::control::{State, Status, TaskRow};

use crate::args::{Format, StatusArgs};
use crate::exit::{Exit, Failure};
use crate::out;
use crate::times::shown;

pub(crate) fn status(args: &StatusArgs) -> Result<Exit, Failure> {
    let mut control = args.socket.connect()?;
    let status = if args.tasks.is_empty() {
        control.status()?
    } else {
        control.status_of_tasks(&args.tasks)?
    };
    match args.format {
        Format::Json => out::json(&status)?,
        Format::Text => print(&status)?,
    }
    let missing: Vec<String> = args
        .tasks
        .iter()
        .filter(|id| !status.tasks.iter().any(|row| row.task == **id))
        .map(u32::to_string)
        .collect();
    if missing.is_empty() {
        return Ok(Exit::Done);
    }
    Err(Failure::Because(Exit::Never, format!("not in the schedule: task {}", missing.join(", "))))
}

fn print(status: &Status) -> Result<(), Failure> {
    if status.tasks.is_empty() {
        out::line("The schedule is empty.")?;
        return Ok(());
    }
    let mut table = out::table(&["task", "name", "priority", "state", "due", "waits for"]);
    for row in &status.tasks {
        table.add_row([
            Cell::new(row.task),
            Cell::new(row.name.as_deref().unwrap_or_default()),
            Cell::new(row.priority),
            state(row),
            Cell::new(due(row, status)),
            Cell::new(row.waits_for.as_deref().unwrap_or_default()),
        ]);
    }
    out::line(format_args!("{} s after the manager's start", shown(status.at_us, 3)))?;
    out::line(&table)?;
    Ok(())
}

fn state(row: &TaskRow) -> Cell {
    let (style, word) = words(row.state);
    let mut text = word.to_owned();
    if row.occurrence > 0 {
        text += &format!(", occurrence {}", row.occurrence);
    }
    if let Some(attempt) = row.attempt.filter(|attempt| *attempt > 1) {
        text += &format!(", attempt {attempt}");
    }
    out::cell(style, text)
}

fn words(state: State) -> (Style, &'static str) {
    match state {
        State::Pending => (out::FAINT, "pending"),
        State::Waiting => (out::ODD, "waiting"),
        State::Running => (out::GOOD, "running"),
        State::Stopping => (out::ODD, "stopping"),
        State::Paused => (out::ODD, "paused"),
        State::Succeeded => (out::FAINT, "succeeded"),
        State::Failed => (out::BAD, "failed"),
        State::Aborted => (out::BAD, "aborted"),
        State::Missed => (out::BAD, "missed"),
        _ => (out::ODD, "unknown to this program"),
    }
}

/// When it is due: in how long, and else at which time of day.
fn due(row: &TaskRow, status: &Status) -> String {
    if row.state != State::Pending {
        return String::new();
    }
    let later = match (row.due_us, row.due_unix_us) {
        (Some(due), _) => i128::from(due) - i128::from(status.at_us),
        (None, Some(due)) => i128::from(due) - i128::from(status.unix_us),
        (None, None) => return String::new(),
    };
    u64::try_from(later).map_or_else(|_| "now".into(), |us| format!("in {} s", shown(us, 1)))
}
