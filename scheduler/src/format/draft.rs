//! A task while it is read: what is known of it, and where that stands.

use core::ops::Range;
use std::collections::BTreeMap;

use crate::task::{Body, Task, TaskId};

/// A task that is being read.
#[derive(Clone, Debug)]
pub(crate) struct Draft {
    /// Its number, if it could be read.
    pub(crate) id: Option<TaskId>,
    /// Everything else. Its own id is meaningless.
    pub(crate) task: Task,
    /// The row or the table.
    pub(crate) whole: Range<usize>,
    /// Where each field stands.
    pub(crate) fields: BTreeMap<&'static str, Span>,
    /// The field that says what it does.
    pub(crate) body: &'static str,
}

/// Where a field stands, and whether it could be read.
#[derive(Clone, Debug)]
pub(crate) struct Span {
    pub(crate) at: Range<usize>,
    pub(crate) good: bool,
}

impl Draft {
    /// A task of which nothing is known but where it stands.
    pub(crate) fn new(whole: Range<usize>) -> Self {
        let nobody = const { TaskId::new(u32::MAX).unwrap() };
        let task = Task::new(nobody, Body::Hold);
        Self { id: None, task, whole, fields: BTreeMap::new(), body: "args" }
    }

    /// Where a field stands, or the task where the field is not given.
    pub(crate) fn span(&self, field: &str) -> Range<usize> {
        self.fields.get(field).map_or_else(|| self.whole.clone(), |span| span.at.clone())
    }

    /// Notes where a field stands, and whether it could be read.
    pub(crate) fn note(&mut self, field: &'static str, at: Range<usize>, good: bool) {
        self.fields.insert(field, Span { at, good });
    }

    /// Whether the field is given.
    pub(crate) fn has(&self, field: &str) -> bool {
        self.fields.contains_key(field)
    }

    /// Whether all of these fields are as they were meant: what could not be
    /// read is not judged a second time.
    pub(crate) fn good<const N: usize>(&self, fields: [&str; N]) -> bool {
        fields.iter().all(|field| self.fields.get(field).is_none_or(|span| span.good))
    }

    /// The task, if its number is known.
    pub(crate) fn into_task(self) -> Option<Task> {
        let mut task = self.task;
        task.id = self.id?;
        Some(task)
    }
}
