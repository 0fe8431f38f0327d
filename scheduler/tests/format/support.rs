//! What the tests of formats share.

use faregate_scheduler::Task;
use faregate_scheduler::format::{self, Diagnostic, Loaded, Rule};

/// Line, column and rule of everything that is told.
pub(crate) fn told(found: &[Diagnostic]) -> Vec<(usize, usize, Rule)> {
    found.iter().map(|wrong| (wrong.place.line, wrong.place.column, wrong.rule)).collect()
}

/// What a good file has.
pub(crate) fn good(name: &str, text: &str) -> Loaded {
    match format::read(name, text.as_bytes()) {
        Ok(loaded) => loaded,
        Err(found) => panic!("{}", found.iter().map(|one| format!("{one}\n")).collect::<String>()),
    }
}

/// The only task of a good file.
pub(crate) fn only(name: &str, text: &str) -> Task {
    match <[Task; 1]>::try_from(good(name, text).tasks) {
        Ok([task]) => task,
        Err(tasks) => panic!("{} tasks", tasks.len()),
    }
}

/// What is wrong with a bad file.
pub(crate) fn bad(name: &str, text: &str) -> Vec<(usize, usize, Rule)> {
    match format::read(name, text.as_bytes()) {
        Ok(_) => panic!("{name} is loaded:\n{text}"),
        Err(found) => told(&found),
    }
}
