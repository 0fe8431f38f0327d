//! What the slides say of scheduling, rule by rule, in one small rover.

mod activities;
mod energy;
mod limits;
mod relax;
mod rover;
mod wake_sleep;
