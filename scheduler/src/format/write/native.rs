//! The native format, written.

use core::str::FromStr;
use std::collections::BTreeMap;

use faregate_agents::Categories;
use jiff::Timestamp;
use toml_edit::{Array, ArrayOfTables, Datetime, DocumentMut, InlineTable, Item, Table, Value};

use crate::format::native::{policies, steps, task as read};
use crate::format::write::{mission, text};
use crate::format::{body, policy};
use crate::mission::Mission;
use crate::task::{
    Body, BuiltIn, Dependency, Preemption, Restart, Status, Step, Task, When, Window,
};
use crate::time::Duration;

pub(crate) type Names = BTreeMap<String, u8>;

/// The tasks, and the mission, if it is to be in the file. Categories are
/// called as the mission that is known calls them.
pub(crate) fn write(tasks: &[&Task], mission: Option<&Mission>, known: Option<&Mission>) -> String {
    let mut document = DocumentMut::new();
    if let Some(mission) = mission {
        document.insert("mission", Item::Table(mission::table(mission)));
    }
    let names = known.map(|known| &known.categories);
    let tasks: ArrayOfTables = tasks.iter().map(|task| task_table(task, names)).collect();
    if !tasks.is_empty() {
        document.insert("task", Item::ArrayOfTables(tasks));
    }
    document.to_string()
}

/// A table that leaves out what is as if it were not written.
#[derive(Default)]
pub(crate) struct Out {
    pub(crate) table: Table,
}

impl Out {
    pub(crate) fn put(&mut self, key: &str, value: impl Into<Value>) {
        self.table.insert(key, Item::Value(value.into()));
    }

    pub(crate) fn unless<T: PartialEq>(
        &mut self,
        key: &str,
        usual: T,
        value: T,
        write: impl Fn(T) -> Value,
    ) {
        if value != usual {
            self.put(key, write(value));
        }
    }
}

fn task_table(task: &Task, names: Option<&Names>) -> Table {
    let usual = Task::new(task.id, task.body.clone());
    let mut out = Out::default();
    out.put("id", i64::from(task.id.get()));
    if let Some(name) = &task.name {
        out.put("name", name.as_str());
    }
    put_body(&task.body, &mut out);
    put_times(task, &usual, &mut out);
    if task.categories != usual.categories {
        out.put("con", categories(task.categories, names));
    }
    out.unless("gap", usual.gap, task.gap, duration);
    out.unless("pri", 0, task.priority.level(), |level| i64::from(level).into());
    put_needs(task, &mut out);
    if task.preemption != usual.preemption {
        put_pre_emption(task.preemption, &mut out);
    }
    put_policies(task, &mut out);
    out.table
}

fn put_body(body: &Body, out: &mut Out) {
    match body {
        Body::Process { program, arguments } => {
            let all: Vec<&str> =
                core::iter::once(program).chain(arguments).map(String::as_str).collect();
            out.put("run", words(&all));
        }
        Body::Function { number, arguments } => {
            out.put("function", i64::from(*number));
            if !arguments.is_empty() {
                out.put("args", strings(arguments));
            }
        }
        Body::Sequence(all) => {
            let all: ArrayOfTables = all.iter().map(step).collect();
            out.table.insert("step", Item::ArrayOfTables(all));
        }
        Body::Hold => out.put("hold", true),
        Body::BuiltIn(BuiltIn::Clear { all }) => {
            out.put("clear", if *all { "all" } else { "pending" })
        }
        Body::BuiltIn(BuiltIn::Remove(tasks)) => {
            out.put("remove", tasks.iter().map(|task| i64::from(task.get())).collect::<Array>());
        }
        Body::BuiltIn(BuiltIn::Load(file)) => out.put("load", file.as_str()),
        Body::BuiltIn(BuiltIn::EnterMode(mode)) => out.put("enter_mode", mode.as_str()),
        Body::BuiltIn(BuiltIn::LeaveMode(mode)) => out.put("leave_mode", mode.as_str()),
    }
}

/// One string where no word needs quotes.
fn words(words: &[&str]) -> Value {
    let plain = words.join(" ");
    let quoted = body::line(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>());
    if quoted.as_ref() == Some(&plain) { plain.into() } else { strings(words).into() }
}

pub(crate) fn strings<T: AsRef<str>>(all: &[T]) -> Array {
    all.iter().map(|one| one.as_ref()).collect()
}

fn step(step: &Step) -> Table {
    let mut out = Out::default();
    out.put("at", duration(step.offset));
    out.put("gate", step.gate.as_str());
    out.put("command", step.command.as_str());
    if !step.arguments.is_empty() {
        out.put("args", strings(&step.arguments));
    }
    out.unless("continue", false, step.continues, Value::from);
    out.table
}

fn put_times(task: &Task, usual: &Task, out: &mut Out) {
    match task.windows.as_slice() {
        [only] => {
            out.unless("st", When::Unrestricted, only.opens, when);
            out.unless("et", When::Unrestricted, only.closes, when);
        }
        windows => out.put("window", windows.iter().map(window).collect::<Array>()),
    }
    out.unless("cutoff", usual.cutoff, task.cutoff, when);
    if let Some(interval) = task.interval {
        out.put("interval", duration(interval));
    }
    out.unless("dur", usual.duration, task.duration, duration);
    if let Some(spread) = task.spread {
        out.put("dur_min", duration(spread.shortest));
        out.put("dur_max", duration(spread.longest));
    }
}

fn window(window: &Window) -> InlineTable {
    let ends = [("st", window.opens), ("et", window.closes)];
    let given = ends.into_iter().filter(|(_, end)| *end != When::Unrestricted);
    given.map(|(key, end)| (key, when(end))).collect()
}

fn put_needs(task: &Task, out: &mut Out) {
    out.unless("memory", 0, task.memory, size);
    out.unless("storage", 0, task.storage, size);
    out.unless("power", 0, task.battery, |percent| i64::from(percent).into());
    out.unless("draw_w", 0, task.peak_draw.get(), |_| number(&text::watts(task.peak_draw)));
    if task.average_draw != task.peak_draw {
        out.put("average_draw_w", number(&text::watts(task.average_draw)));
    }
    out.unless("data", 0, task.data, size);
    let mut commanded = Vec::new();
    steps::commanded(&task.body, &mut commanded);
    if task.gates != commanded {
        out.put("gates", strings(&task.gates));
    }
}

fn put_pre_emption(preemption: Preemption, out: &mut Out) {
    let way = policy::column(preemption, text::seconds);
    out.put("preempt", way.split(':').next().unwrap_or_default());
    match preemption {
        Preemption::Wait | Preemption::Pause => {}
        Preemption::Kill { grace } => out.put("grace", duration(grace)),
        Preemption::Checkpoint { grace, signal } => {
            out.put("grace", duration(grace));
            out.unless("signal", Default::default(), signal, |signal| policy::name(signal).into());
        }
    }
}

fn put_policies(task: &Task, out: &mut Out) {
    if let Restart::OnFailure { limit, back_off } = task.restart {
        out.put("restart", "on_failure");
        out.put("restart_limit", i64::from(limit));
        out.put("back_off", duration(back_off));
    }
    out.unless("overrun", Default::default(), task.overrun, |overrun| {
        named(&policies::OVERRUNS, overrun).into()
    });
    if let Some(heartbeat) = task.heartbeat {
        out.put("heartbeat", duration(heartbeat));
    }
    if !task.after.is_empty() {
        out.put("after", task.after.iter().map(dependency).collect::<Array>());
    }
    if let Some(cleanup) = task.cleanup {
        out.put("cleanup", i64::from(cleanup.get()));
    }
    out.unless("mandatory", false, task.mandatory, Value::from);
}

fn dependency(dependency: &Dependency) -> Value {
    let task = i64::from(dependency.task.get());
    if dependency.status == Status::Succeeded {
        return task.into();
    }
    let status = named(&read::STATUSES, dependency.status);
    InlineTable::from_iter([("task", Value::from(task)), ("status", status.into())]).into()
}

fn named<T: PartialEq>(known: &[(&'static str, T)], meaning: T) -> &'static str {
    known.iter().find(|(_, known)| *known == meaning).map_or("", |(name, _)| name)
}

/// Names where the mission has some of them; else a mask.
pub(crate) fn categories(categories: Categories, names: Option<&Names>) -> Value {
    let mask = categories.mask();
    let bits: Vec<u8> = (0..128).filter(|bit| mask >> bit & 1 == 1).collect();
    let name = |bit: u8| names?.iter().find(|(_, known)| **known == bit).map(|(name, _)| name);
    if categories == Categories::ALL {
        "all".into()
    } else if bits.len() <= 16 && bits.iter().any(|bit| name(*bit).is_some()) {
        let one = |bit: &u8| name(*bit).map_or_else(|| i64::from(*bit).into(), Value::from);
        Value::Array(bits.iter().map(one).collect())
    } else {
        i64::try_from(mask).map_or_else(|_| format!("{mask:#x}").into(), Value::from)
    }
}

/// A number exactly as it is written, which no float could be.
pub(crate) fn number(digits: &str) -> Value {
    Value::from_str(digits).unwrap_or_else(|_| digits.into())
}

pub(crate) fn size(bytes: u64) -> Value {
    i64::try_from(bytes).map_or_else(|_| bytes.to_string().into(), Value::from)
}

pub(crate) fn duration(duration: Duration) -> Value {
    number(&text::seconds(duration))
}

fn when(when: When) -> Value {
    let When::At(time) = when else {
        return match when {
            When::Unrestricted => 0.into(),
            _ => text::when(when).into(),
        };
    };
    let date = Timestamp::from_microsecond(time.as_micros()).ok().map(|time| time.to_string());
    let date = date.and_then(|date| Datetime::from_str(&date).ok());
    date.map_or_else(|| text::when(when).into(), Value::from)
}
