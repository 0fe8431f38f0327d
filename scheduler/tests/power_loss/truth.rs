//! What really happened, kept where no crash reaches it.

use std::collections::{BTreeMap, BTreeSet};

use faregate_scheduler::manager::{Attempt, Exit, Restored, RestoredTask};
use faregate_scheduler::task::{Outcome, Restart, Task, TaskId};
use faregate_scheduler::time::{Duration, UnixTime};

/// Everything that anybody could have seen.
#[derive(Debug)]
pub(crate) struct Truth {
    pub(crate) tasks: BTreeMap<TaskId, Task>,
    /// Whose acceptance was answered.
    pub(crate) accepted: BTreeSet<TaskId>,
    /// Attempts that began, and how they ended.
    began: BTreeMap<Attempt, Option<Exit>>,
    pub(crate) wall: UnixTime,
    pub(crate) power_was_lost: bool,
    /// How often a task was given back as interrupted.
    pub(crate) interrupted: u64,
    pub(crate) may_have_started: u64,
}

impl Truth {
    pub(crate) fn new(tasks: impl Iterator<Item = Task>) -> Self {
        Self {
            tasks: tasks.map(|task| (task.id, task)).collect(),
            accepted: BTreeSet::new(),
            began: BTreeMap::new(),
            wall: UnixTime::from_secs(1_900_000_000),
            power_was_lost: false,
            interrupted: 0,
            may_have_started: 0,
        }
    }

    pub(crate) fn starts(&self) -> usize {
        self.began.len()
    }

    pub(crate) fn wait(&mut self, time: Duration) {
        self.wall = self.wall.after(time);
    }

    /// A body begins.
    pub(crate) fn begins(&mut self, attempt: Attempt) {
        assert!(self.began.insert(attempt, None).is_none(), "{attempt} began twice");
        let task = &self.tasks[&attempt.occurrence.task];
        if task.restart == Restart::Never {
            let tries = self.began.keys().filter(|other| other.occurrence == attempt.occurrence);
            assert_eq!(tries.count(), 1, "{attempt}: its task is never to be begun again");
        }
    }

    pub(crate) fn ends(&mut self, attempt: Attempt, exit: Exit) {
        self.began.insert(attempt, Some(exit));
    }

    /// The bodies go with the manager.
    pub(crate) fn everybody_dies(&mut self) {
        for exit in self.began.values_mut().filter(|exit| exit.is_none()) {
            *exit = Some(Exit::Signal(9));
        }
    }

    /// The journal gives this back.
    pub(crate) fn restored(&mut self, restored: &Restored) {
        let known: BTreeMap<_, _> =
            restored.tasks.iter().map(|task| (task.task.id, task)).collect();
        for id in &self.accepted {
            assert!(known.contains_key(id), "{id} was accepted and is lost");
        }
        for attempt in self.began.keys() {
            let task = known.get(&attempt.occurrence.task);
            let task = task.expect("a task began that nobody knows");
            assert!(
                is_remembered(task, *attempt),
                "it is forgotten that {attempt} began: {task:?}"
            );
        }
        for task in known.values() {
            self.interrupted += u64::from(task.interrupted.is_some());
            self.may_have_started += u64::from(task.may_have_started);
            assert!(
                !task.may_have_started || self.power_was_lost,
                "it is doubted whether {} began, though nothing can be lost",
                task.task.id
            );
        }
    }

    /// The schedule is over, and the journal says this of it.
    pub(crate) fn check_at_the_end(&self, told: &Restored, history: &str) {
        for task in &told.tasks {
            let id = task.task.id;
            assert!(self.accepted.contains(&id), "{history}: {id} was never accepted");
            let exits: Vec<_> = self.of(id).collect();
            let succeeded = exits.contains(&&Some(Exit::Code(0)));
            let Some((_, outcome)) = task.ended else {
                panic!("{history}: {id} is lost: {exits:?}")
            };
            match (task.task.restart, outcome) {
                // Whatever is told to have succeeded did. One that did and was
                // not known to may have been done again.
                (_, Outcome::Succeeded) => assert!(succeeded, "{history}: {id} did not succeed"),
                // One that was about to begin is told to have failed, too: that
                // it had not begun is more than anybody knows.
                (Restart::Never, Outcome::Failed) => {}
                _ => panic!("{history}: {id} was given up: {exits:?}"),
            }
        }
        assert_eq!(told.tasks.len(), self.tasks.len(), "{history}: not all tasks are there");
    }

    fn of(&self, id: TaskId) -> impl Iterator<Item = &Option<Exit>> {
        self.began.iter().filter(move |(of, _)| of.occurrence.task == id).map(|(_, exit)| exit)
    }
}

/// Whether a manager that goes on from this cannot take the attempt for one
/// that never began.
fn is_remembered(task: &RestoredTask, attempt: Attempt) -> bool {
    let number = attempt.occurrence.number;
    task.ended.is_some_and(|(ended, outcome)| ended >= number && outcome != Outcome::Missed)
        || task.attempts.0 == number && task.attempts.1 >= attempt.number
        || task.interrupted == Some(attempt)
        || task.may_have_started
}
