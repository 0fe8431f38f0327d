//! What a task of the native format does.

use core::ops::Range;

use toml::de::{DeTable, DeValue};

use crate::format::body;
use crate::format::diagnostic::Rule;
use crate::format::draft::Draft;
use crate::format::native::table::Table;
use crate::format::native::{keys, value};
use crate::format::policy;
use crate::format::scalar;
use crate::format::wrong::{Report, Wrong};
use crate::task::{Body, BuiltIn, Step, TaskId};

/// Reads what the task does, and the gates that it commands.
pub(crate) fn body(table: &mut Table<'_, '_, '_>, draft: &mut Draft) {
    let gates = table.list("gates", value::name);
    let kinds = table.present(keys::BODY);
    for second in kinds.iter().skip(1) {
        let message =
            format!("{} and {second} exclude each other", kinds.first().unwrap_or(second));
        let wrong = Wrong::new(Rule::Duplicate, message).expected("one of them");
        table.error(table.span(second), second, wrong);
    }
    let Some(kind) = kinds.first().copied() else {
        let wrong = Wrong::new(Rule::Missing, "the task does nothing")
            .expected(format!("one of {}", keys::BODY.join(", ")))
            .help("hold = true only occupies its categories");
        table.error(table.at.clone(), "", wrong);
        return;
    };
    draft.body = kind;
    if kind != "function" && table.value("args").is_some() && !kinds.contains(&"function") {
        let wrong = Wrong::new(Rule::NoEffect, format!("{kind} has no args"));
        table.error(table.span("args"), "args", wrong.help("put them behind the program in run"));
    }
    draft.task.gates = gates.unwrap_or_default();
    if let Some(body) = of_kind(kind, table) {
        commanded(&body, &mut draft.task.gates);
        draft.task.preemption = policy::usual(&body);
        draft.task.body = body;
    }
}

fn of_kind(kind: &'static str, table: &mut Table<'_, '_, '_>) -> Option<Body> {
    let built_in = match kind {
        "run" => {
            let words = words(table, kind)?;
            let body = body::process(words);
            return table.report.take(table.span(kind), kind, body);
        }
        "function" => return function(table),
        "step" => return sequence(table),
        "hold" => return table.read(kind, hold).map(|()| Body::Hold),
        "clear" => BuiltIn::Clear { all: table.read(kind, clear)? },
        "remove" => BuiltIn::Remove(remove(table)?),
        "load" => BuiltIn::Load(table.read(kind, value::name)?),
        "enter_mode" => BuiltIn::EnterMode(table.read(kind, value::name)?),
        _ => BuiltIn::LeaveMode(table.read(kind, value::name)?),
    };
    Some(Body::BuiltIn(built_in))
}

fn words(table: &mut Table<'_, '_, '_>, key: &'static str) -> Option<Vec<String>> {
    let read = table.read(key, value::words)?;
    if let Some(warning) = read.warning {
        table.report.warn(table.span(key), key, warning);
    }
    Some(read.words)
}

fn function(table: &mut Table<'_, '_, '_>) -> Option<Body> {
    let number = table.read("function", value::number("a type, 16 to 65535", registered));
    let arguments = match table.value("args") {
        Some(_) => words(table, "args"),
        None => Some(Vec::new()),
    };
    Some(Body::Function { number: number?, arguments: arguments? })
}

fn registered(text: &str) -> Result<u16, Wrong> {
    match scalar::type_number(text)? {
        number if number < body::REGISTERED => {
            Err(Wrong::new(Rule::Range, format!("type {number} is no registered function"))
                .expected("16 to 65535"))
        }
        number => Ok(number),
    }
}

fn hold(value: &DeValue<'_>) -> Result<(), Wrong> {
    match value::truth(value)? {
        true => Ok(()),
        false => Err(Wrong::new(Rule::Value, "a task that does not hold").expected("true")),
    }
}

fn clear(value: &DeValue<'_>) -> Result<bool, Wrong> {
    match value {
        DeValue::String(what) if what == "pending" => Ok(false),
        DeValue::String(what) if what == "all" => Ok(true),
        _ => Err(value::other(value, "\"pending\", or \"all\" (what runs ends, too)")),
    }
}

fn remove(table: &mut Table<'_, '_, '_>) -> Option<Vec<TaskId>> {
    let tasks = table.list("remove", value::number("the number of a task", scalar::task_id))?;
    if tasks.is_empty() {
        let wrong = Wrong::new(Rule::Missing, "there is no task to remove");
        table.error(table.span("remove"), "remove", wrong.expected("the numbers of tasks"));
        return None;
    }
    Some(tasks)
}

fn sequence(table: &mut Table<'_, '_, '_>) -> Option<Body> {
    let before = table.report.found.len();
    let steps = table.tables("step");
    if steps.is_empty() && table.report.found.len() == before {
        let wrong = Wrong::new(Rule::Missing, "there is no step").expected("at least one");
        table.error(table.span("step"), "step", wrong);
    }
    let all: Vec<_> = steps.into_iter().map(|(one, at)| step(one, at, table.report)).collect();
    let good = table.report.found.len() == before;
    all.into_iter().collect::<Option<_>>().filter(|_| good).map(Body::Sequence)
}

fn step(table: &DeTable<'_>, at: Range<usize>, report: &mut Report<'_>) -> Option<Step> {
    let mut table = Table::new(table, at, "step.", report);
    let offset = table.need("at", value::duration);
    let gate = table.need("gate", value::name);
    let command = table.need("command", value::name);
    let arguments = match table.value("args") {
        Some(_) => table.read("args", value::words).map(|read| read.words),
        None => Some(Vec::new()),
    };
    let continues = match table.value("continue") {
        Some(_) => table.read("continue", value::truth),
        None => Some(false),
    };
    table.finish(keys::STEP);
    Some(Step {
        offset: offset?,
        gate: gate?,
        command: command?,
        arguments: arguments?,
        continues: continues?,
    })
}

/// A sequence commands the gates of its steps, whether they are listed or not.
pub(crate) fn commanded(body: &Body, gates: &mut Vec<String>) {
    let Body::Sequence(steps) = body else { return };
    for step in steps {
        if !gates.contains(&step.gate) {
            gates.push(step.gate.clone());
        }
    }
}
