//! The timed plan as tasks of the schedule manager, which executes it on
//! tickets.
//!
//! Each scheduled activity becomes a task that can start from its planned start
//! until its start range closes. What the planner generated becomes tasks that
//! only hold: the computer's phases, heating, communication windows. So whoever
//! is more important can take heater power by the same means as anything else,
//! and what needs the heat does not start without it.
//!
//! | of the plan | of the task |
//! |---|---|
//! | resource usage bit | conflict category of the same number |
//! | sequence engine | a category that the mission calls `engine 1`, `engine 2`, ...; which one is chosen here |
//! | peak power | draw at the mission's first agent, what its devices draw there subtracted |
//! | what a sequence commands | gates, found in its steps |
//! | priority | ticket priority, in the same order; see [`ticket_priority`] |
//! | a planned prior | a task that it comes after |
//! | a zone | comes after the task that heats it |
//!
//! Engines are categories because agents count power and nothing else: a task
//! would need a second place at a second agent. To choose an engine for each is
//! always possible where the planner counted enough of them.
//!
//! | part | what |
//! |---|---|
//! | [`tasks()`] | a timed plan as tasks |
//! | [`Director`] | has it executed: tells when to plan again, and what changes |
//! | [`Library`] | what sequences do |
//! | [`mission_fits`] | whether the parameters and a mission agree |
//! | [`plan_fits`] | whether a plan's activities and a mission agree |

mod activity;
mod director;
mod engines;
mod fits;
mod generated;
mod library;
mod priority;
mod together;
mod translate;

use core::fmt;
use std::sync::Arc;

use faregate_scheduler::Mission;
use faregate_scheduler::time::UnixTime;

use crate::plan::ActivityId;
use crate::units::Time;
use crate::{Parameters, Plan};

pub use director::{Director, NotPlanned};
pub use fits::{Disagreement, mission_fits};
pub use library::{Library, NoLibrary};
pub use priority::ticket_priority;
pub use together::plan_fits;
pub use translate::tasks;

/// What a plan is executed with.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The plan.
    pub plan: Arc<Plan>,
    /// The parameters.
    pub parameters: Arc<Parameters>,
    /// What its sequences do.
    pub library: Arc<Library>,
    /// What it is executed on.
    pub mission: Arc<Mission>,
    /// When the plan's time begins.
    pub epoch: Epoch,
}

/// The time of day at the origin of the plan's time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Epoch(UnixTime);

impl Epoch {
    /// The plan's time begins at this time of day.
    #[must_use]
    pub const fn new(origin: UnixTime) -> Self {
        Self(origin)
    }

    /// The time of day at an instant of the plan.
    #[must_use]
    pub const fn wall(self, at: Time) -> UnixTime {
        UnixTime::from_micros(self.0.as_micros().saturating_add(at.get().saturating_mul(1_000)))
    }

    /// The instant of the plan at a time of day: the millisecond that it is in.
    #[must_use]
    pub const fn time(self, at: UnixTime) -> Time {
        Time::new(at.as_micros().saturating_sub(self.0.as_micros()).div_euclid(1_000))
    }
}

/// Why an activity cannot become a task.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Misfit {
    /// Nobody knows its sequence.
    Sequence(ActivityId, String),
    /// Its sequence commands a gate that the mission has not got.
    Gate(ActivityId, String),
    /// Its sequence commands more gates than one request can have.
    Gates(ActivityId, usize),
    /// The devices that its sequence commands draw more than its peak, by so
    /// many milliwatts: the plan understates it.
    Peak(ActivityId, u64),
    /// There is no name for an engine that it needs.
    Engine(usize),
    /// The plan's numbers leave none for what the planner generates.
    Numbers,
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sequence(id, name) => {
                write!(f, "{id}: no sequence `{name}` is known: give the library one")
            }
            Self::Gate(id, gate) => write!(f, "{id}: the mission has no device `{gate}`"),
            Self::Gates(id, gates) => {
                let most = faregate_scheduler::tickets::MOST_GATES;
                write!(f, "{id}: its sequence commands {gates} gates, and {most} is the most")
            }
            Self::Peak(id, more) => {
                write!(f, "{id}: its devices draw {more} mW more than its peak: raise the peak")
            }
            Self::Engine(number) => {
                write!(f, "the mission has no category `{}`", engines::name(*number))
            }
            Self::Numbers => f.write_str("numbers of activities are so large that none are left"),
        }
    }
}

impl core::error::Error for Misfit {}
