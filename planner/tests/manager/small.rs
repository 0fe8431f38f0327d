//! A morning with little in it, on the rover of the example sols: the computer
//! is up, and nothing happens but what a test asks for.

use std::sync::Arc;

use faregate_agents::Categories;
use faregate_planner::plan::StartRange;
use faregate_planner::state::Mode;
use faregate_planner::tasks::Setting;
use faregate_planner::units::{Ppm, Span, Time};
use faregate_planner::{Activity, Plan, State};
use faregate_scheduler::manager::Note;
use faregate_scheduler::task::{Body, Preemption, Task, TaskPriority, When, Window};
use faregate_scheduler::time::Duration;

use crate::stage::{Fates, Stage, clock, id, setting, state, task_id};

/// The number of what is no activity.
const OUTSIDE: u32 = 9_000;

/// An optional activity that can start from then until four in the afternoon.
pub(crate) fn activity(number: u32, minutes: i64, from: Time) -> Activity {
    let starts = vec![StartRange { from, to: clock(16, 0), cutoff: clock(17, 30) }];
    Activity { priority: 50, starts, ..Activity::new(id(number), Span::from_mins(minutes)) }
}

pub(crate) const fn bit(number: u32) -> Categories {
    Categories::from_mask(1 << number)
}

/// From ten on, until six, with all day to plan for.
pub(crate) fn plan(activities: Vec<Activity>) -> Plan {
    let (handover, end) = (clock(18, 0), clock(18, 0));
    Plan {
        handover,
        end,
        handover_min_soc: Ppm::ZERO,
        next_plan: None,
        activities,
        ..Plan::clone(&setting().plan)
    }
}

pub(crate) fn setting_of(plan: Plan) -> Setting {
    Setting { plan: Arc::new(plan), ..setting() }
}

/// At ten.
pub(crate) fn morning() -> State {
    let (mode, mode_since) = (Mode::Awake, clock(9, 0));
    State { now: clock(10, 0), mode, mode_since, windows: Vec::new(), ..state() }
}

pub(crate) fn small(activities: Vec<Activity>, fates: Fates) -> Stage {
    Stage::of(setting_of(plan(activities)), morning(), fates)
}

/// More important than anything, it holds something and does not let go of it.
pub(crate) fn outside(from: Time, minutes: u64) -> Task {
    let opens = When::At(setting().epoch.wall(from));
    Task {
        windows: vec![Window { opens, closes: When::Unrestricted }],
        priority: TaskPriority::TOP,
        duration: Duration::from_secs(60 * minutes),
        preemption: Preemption::Wait,
        ..Task::new(task_id(OUTSIDE), Body::Hold)
    }
}

/// When it was over.
pub(crate) fn end_of(stage: &Stage, number: u32) -> Option<Time> {
    let over = |note: &Note| matches!(note, Note::Ended { occurrence, .. } if occurrence.task.get() == number);
    stage.story.iter().find(|(_, note)| over(note)).map(|(at, _)| *at)
}
