//! What a client says, as what the manager understands.

use faregate_client::wire::control::{Ask, When as SaidWhen, Window as SaidWindow};
use faregate_client::{RefusalKind, Refused};

use crate::control::{MISTAKES, ReadSchedule, What, reading};
use crate::manager::{Addition, Telecommand};
use crate::task::{TaskId, TaskPriority, When, Window};
use crate::time::{Duration, UnixTime};

/// What is asked of the manager; `None`: nothing, it is the link's own affair.
pub(super) fn asked(ask: Ask, schedules: &dyn ReadSchedule) -> Result<Option<What>, Refused> {
    let telecommand = match ask {
        Ask::Add { name, text } => additions(&name, &text, schedules)?,
        Ask::Remove { tasks } => Telecommand::Remove(all(&tasks)?),
        Ask::SetPriority { task, priority } => {
            Telecommand::SetPriority(one(task)?, level(priority)?)
        }
        Ask::SetWindows { task, windows } => Telecommand::SetWindows(one(task)?, open(&windows)?),
        Ask::Clear { all } => Telecommand::Clear { all },
        Ask::Hold { task } => Telecommand::Hold(one(task)?),
        Ask::Resume { task } => Telecommand::Resume(one(task)?),
        Ask::EnterMode { mode } => Telecommand::EnterMode(mode),
        Ask::LeaveMode { mode } => Telecommand::LeaveMode(mode),
        Ask::ShutDown => Telecommand::ShutDown,
        Ask::Status(query) => return Ok(Some(What::Status(query))),
        Ask::Watch => return Ok(None),
    };
    Ok(Some(What::Telecommand(telecommand)))
}

fn invalid(why: impl Into<String>) -> Refused {
    Refused::new(RefusalKind::Invalid, why)
}

fn additions(name: &str, text: &str, schedules: &dyn ReadSchedule) -> Result<Telecommand, Refused> {
    let tasks = reading::read(schedules, name, text, MISTAKES)?;
    if tasks.is_empty() {
        return Err(invalid(format!("{name} holds no task")));
    }
    Ok(Telecommand::Add(tasks.into_iter().map(|task| Addition { task }).collect()))
}

fn one(number: u32) -> Result<TaskId, Refused> {
    TaskId::new(number).ok_or_else(|| invalid("0 is not a task"))
}

fn all(numbers: &[u32]) -> Result<Vec<TaskId>, Refused> {
    if numbers.is_empty() {
        return Err(invalid("no task is named: all of them are meant by a clear"));
    }
    numbers.iter().map(|&number| one(number)).collect()
}

fn level(level: u8) -> Result<TaskPriority, Refused> {
    TaskPriority::new(level).ok_or_else(|| {
        let top = TaskPriority::TOP.level();
        invalid(format!("priority {level} is for fault responses: a task has 0 to {top}"))
    })
}

fn open(windows: &[SaidWindow]) -> Result<Vec<Window>, Refused> {
    if windows.is_empty() {
        return Err(invalid("a task has at least one window"));
    }
    windows.iter().map(window).collect()
}

fn window(said: &SaidWindow) -> Result<Window, Refused> {
    let never = match (said.opens, said.closes) {
        (SaidWhen::AfterUs(opens), SaidWhen::AfterUs(closes)) => closes < opens,
        (SaidWhen::UnixUs(opens), SaidWhen::UnixUs(closes)) => closes < opens,
        _ => false,
    };
    if never {
        return Err(invalid("a window closes before it opens"));
    }
    Ok(Window { opens: when(said.opens), closes: when(said.closes) })
}

const fn when(said: SaidWhen) -> When {
    match said {
        SaidWhen::Unrestricted => When::Unrestricted,
        SaidWhen::AfterUs(us) => When::AfterLoad(Duration::from_micros(us)),
        SaidWhen::UnixUs(us) => When::At(UnixTime::from_micros(us)),
    }
}
