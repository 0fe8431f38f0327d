//! What the slides say of scheduling, rule by rule, in one small rover.

mod activities;
mod data;
mod drained;
mod energy;
mod limits;
mod order;
mod preheat;
mod relax;
mod replan;
mod rover;
mod wake_sleep;
