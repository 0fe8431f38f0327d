//! Schedules that are loaded together.

use std::collections::BTreeMap;

use crate::format::Loaded;
use crate::format::check::references::unknown_task;
use crate::format::diagnostic::{Diagnostic, Rule, Severity};
use crate::format::wrong::{Wrong, shown};
use crate::task::TaskId;

/// What is wrong between files of which each is right by itself: a number that
/// two of them give and, where these are all files there are, a task that none
/// of them has.
#[must_use]
pub fn together(files: &[(&str, &Loaded)], whole: bool) -> Vec<Diagnostic> {
    let mut first: BTreeMap<TaskId, &str> = BTreeMap::new();
    let mut found = Vec::new();
    for (file, loaded) in files {
        for id in loaded.tasks.iter().map(|task| task.id) {
            if let Some(before) = first.get(&id) {
                let message = format!("{id} is in {} already", shown(before));
                let wrong = Wrong::new(Rule::Duplicate, message)
                    .expected("a number that no other task has");
                found.push(at(file, loaded, id, "id", wrong));
            } else {
                first.insert(id, file);
            }
        }
    }
    if whole {
        for (file, loaded) in files {
            found.extend(missing(file, loaded, |id| first.contains_key(&id)));
        }
    }
    found
}

fn missing(file: &str, loaded: &Loaded, is_there: impl Fn(TaskId) -> bool) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for task in &loaded.tasks {
        let after = task.after.iter().map(|prior| ("after", prior.task));
        let others = after.chain(task.cleanup.map(|cleanup| ("cleanup", cleanup)));
        for (field, other) in others.filter(|(_, other)| !is_there(*other)) {
            found.push(at(file, loaded, task.id, field, unknown_task(other)));
        }
    }
    found
}

/// Where the task stands: what is known of a file that was read is no finer.
fn at(file: &str, loaded: &Loaded, id: TaskId, field: &str, wrong: Wrong) -> Diagnostic {
    let place = loaded.places.get(&id).cloned().unwrap_or_default();
    let wrong = Diagnostic::of(Severity::Error, file, place, wrong);
    Diagnostic { field: Some(field.to_owned()), ..wrong }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::{Options, read_with};

    fn loaded(name: &str, text: &str) -> Loaded {
        let options = Options { whole: false, ..Options::default() };
        read_with(options, name, text.as_bytes()).unwrap()
    }

    #[test]
    fn a_number_is_given_once_in_all_files_and_a_task_may_be_in_any() {
        let one =
            loaded("a.toml", "[[task]]\nid = 1\nhold = true\n[[task]]\nid = 2\nhold = true\n");
        let text = "[[task]]\nid = 3\nhold = true\nafter = [1, 9]\ncleanup = 2\n\n\
                    [[task]]\nid = 2\nhold = true\n";
        let other = loaded("b.toml", text);
        let files = [("a.toml", &one), ("b.toml", &other)];
        let told = |whole| -> Vec<_> {
            let found = together(&files, whole).into_iter();
            found.map(|one| (one.rule, one.file, one.place.line, one.field.unwrap())).collect()
        };
        let twice = (Rule::Duplicate, "b.toml".to_owned(), 7, "id".to_owned());
        let nobody = (Rule::UnknownTask, "b.toml".to_owned(), 1, "after".to_owned());
        assert_eq!(told(true), [twice.clone(), nobody]);
        assert_eq!(told(false), [twice]);
        assert_eq!(together(&files[..1], true), []);
    }
}
