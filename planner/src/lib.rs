//! The onboard planner: which activities run, when, and why the others do not.
//!
//! A pure function: a plan from the ground, parameters, the present state and
//! the present instant go in; a timed plan that keeps every limit comes out,
//! with a reason for each activity that was left out. The same lines run on the
//! ground, on board and in a test. There is no clock, thread, file or random
//! number inside, and equal input gives an equal plan.
//!
//! After Rabideau and Benowitz, *Prototyping an Onboard Scheduler for the Mars
//! 2020 Rover* (IWPSS 2017).
//!
//! # The parts
//!
//! | part | what |
//! |---|---|
//! | [`units`] | instants, spans, fractions: integers |
//! | [`plan`] | what the ground writes: activities and limits of the plan |
//! | [`parameters`] | what only the ground changes: limits, powers, preheat tables |
//! | [`state`] | what is so now |
//! | [`timed`] | what the planner answers |
//! | [`timeline`] | what is used when, and where else something fits |
//! | [`mod@project`] | what every timeline will be |
//! | [`mod@schedule`] | the pass, and its improvement |
//! | [`generate`] | plans drawn from a seed |
//! | [`mod@file`] | plans, parameters and states in files |
//! | [`execute`] | the control thread: dispatches, checks, aborts |
//! | [`tasks`] | a timed plan as tasks of the schedule manager |
//! | [`words`] | the same in words |
//! | [`picture`] | the same as a picture |
//! | [`trace`] | what happened when a plan was executed |
//! | [`products`] | all of an execution, as files for the ground |

#![forbid(unsafe_code)]

mod derive;
mod draws;
mod energy;
pub mod execute;
pub mod explain;
pub mod file;
pub mod generate;
mod judge;
pub mod parameters;
pub mod picture;
pub mod plan;
pub mod problem;
pub mod products;
pub mod project;
pub mod schedule;
pub mod search;
pub mod state;
pub mod tasks;
pub mod timed;
pub mod timeline;
pub mod trace;
pub mod units;
pub mod words;

pub use explain::explain;
pub use parameters::Parameters;
pub use plan::{Activity, ActivityId, Plan};
pub use problem::Problem;
pub use project::project;
pub use schedule::{Budget, Improved, Worth, improve, schedule};
pub use schedule::{schedule_in_order, schedule_plainly};
pub use state::State;
pub use timed::TimedPlan;
pub use trace::Trace;
