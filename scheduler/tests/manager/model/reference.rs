//! Who should run, by looking at everything.

use std::collections::BTreeSet;

use faregate_scheduler::task::{Preemption, Task, TaskId, When};

/// A task as the reference knows it. Times are seconds.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    pub(crate) task: Task,
    pub(crate) loaded: i64,
    pub(crate) position: u64,
    pub(crate) held: bool,
    /// The last occurrence that is over.
    pub(crate) last: Option<u64>,
    pub(crate) body: Option<Body>,
    /// The occurrence that was pre-empted, and is to be run again.
    pub(crate) rerun: Option<u64>,
    pub(crate) over: bool,
}

/// A body that was started and is not over.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) number: u64,
    pub(crate) attempt: u32,
    pub(crate) state: Does,
    /// It is being ended for good.
    pub(crate) ends: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Does {
    Runs,
    Stops,
    Stands,
}

fn after(when: When) -> Option<i64> {
    match when {
        When::AfterLoad(after) => Some(i64::try_from(after.as_micros() / 1_000_000).unwrap()),
        _ => None,
    }
}

impl Known {
    pub(crate) fn due(&self, number: u64) -> i64 {
        self.loaded + after(self.task.windows[0].opens).unwrap_or(0) + self.shift(number)
    }

    fn shift(&self, number: u64) -> i64 {
        let interval = self.task.interval.map_or(0, |interval| interval.as_micros() / 1_000_000);
        i64::try_from(interval * number).unwrap()
    }

    pub(crate) fn is_open(&self, number: u64, now: i64) -> bool {
        let closes = after(self.task.windows[0].closes);
        closes.is_none_or(|closes| now <= self.loaded + closes + self.shift(number))
    }

    /// What a checkpoint saved is gone on with: that is no start.
    pub(crate) fn may_rerun(&self, number: u64, now: i64) -> bool {
        let saves = matches!(self.task.preemption, Preemption::Checkpoint { .. });
        saves || self.is_open(number, now)
    }

    /// The last occurrence that is due by now.
    pub(crate) fn last_due(&self, now: i64) -> Option<u64> {
        match self.task.interval {
            None => (self.due(0) <= now).then_some(0),
            Some(_) => (0..).take_while(|number| self.due(*number) <= now).last(),
        }
    }

    /// Which occurrence wants to run now, if one does.
    fn wants(&self, now: i64) -> Option<u64> {
        if self.over {
            return None;
        }
        if let Some(body) = &self.body {
            return (!body.ends).then_some(body.number);
        }
        if let Some(number) = self.rerun {
            return self.may_rerun(number, now).then_some(number);
        }
        let number = self.last_due(now)?;
        let is_new = self.last.is_none_or(|last| number > last);
        (is_new && self.is_open(number, now)).then_some(number)
    }
}

/// What there is.
pub(crate) const SUPPLY: u64 = 3_000;
pub(crate) const MEMORY: u64 = 3;

#[derive(Debug, Default)]
pub(crate) struct Taken {
    pub(crate) categories: u128,
    pub(crate) draw: u64,
    pub(crate) memory: u64,
}

impl Taken {
    pub(crate) fn fits(&self, task: &Task, with_memory: bool) -> bool {
        self.categories & task.categories.mask() == 0
            && (task.peak_draw.is_zero() || self.draw + task.peak_draw.get() <= SUPPLY)
            && (!with_memory || task.memory == 0 || self.memory + task.memory <= MEMORY)
    }

    pub(crate) fn take(&mut self, task: &Task, with_memory: bool) {
        self.categories |= task.categories.mask();
        self.draw += task.peak_draw.get();
        if with_memory {
            self.memory += task.memory;
        }
    }
}

fn share(a: &Task, b: &Task) -> bool {
    a.categories.overlaps(b.categories)
        || (!a.peak_draw.is_zero() && !b.peak_draw.is_zero())
        || (a.memory > 0 && b.memory > 0)
}

/// Who runs when everything is at rest.
pub(crate) fn expected(
    known: &[Known],
    gaps: u128,
    barred: impl Fn(TaskId) -> bool,
    now: i64,
) -> BTreeSet<TaskId> {
    let mut taken = Taken { categories: gaps, ..Taken::default() };
    let mut runs = BTreeSet::new();
    let stays = |known: &Known| {
        let waits = known.task.preemption == Preemption::Wait;
        let body = known.body.as_ref();
        waits && !known.held && body.is_some_and(|body| body.state == Does::Runs && !body.ends)
    };
    for one in known {
        let pauses = matches!(one.task.preemption, Preemption::Pause | Preemption::Wait);
        if stays(one) {
            taken.take(&one.task, true);
            runs.insert(one.task.id);
        } else if one.body.is_some() && pauses {
            taken.memory += one.task.memory;
        }
    }
    let mut order: Vec<_> = known
        .iter()
        .filter(|one| !stays(one) && !one.held)
        .filter_map(|one| Some((one, one.wants(now)?)))
        .filter(|(one, number)| one.body.is_some() || one.due(*number) <= now)
        .collect();
    order.sort_by_key(|(one, number)| {
        (u8::MAX - one.task.priority.level(), one.due(*number), one.position)
    });
    let mut waiting: Vec<&Task> = Vec::new();
    for (one, _) in order {
        let idle = one.body.is_none();
        let keeps = !idle && one.task.preemption == Preemption::Pause;
        let starves = idle
            && one.task.preemption == Preemption::Wait
            && waiting.iter().any(|other| share(other, &one.task));
        if !barred(one.task.id) && !starves && taken.fits(&one.task, !keeps) {
            taken.take(&one.task, !keeps);
            runs.insert(one.task.id);
        } else {
            waiting.push(&one.task);
        }
    }
    runs
}
