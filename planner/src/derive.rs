//! What follows from what is placed: heating, awake time, charge.
//!
//! Nothing of it is ever edited. A set of timed activities, the parameters and
//! the state have one derived world, which is made anew whenever one of them
//! changes; a candidate is judged by the world that it would make.

mod awake;
mod heat;
mod own;
mod placed;
pub(crate) mod var;
mod world;

pub(crate) use awake::{Mark, Phase, Sweep};
pub(crate) use own::{Candidate, Frame, Late, NONE, Own, OwnStep};
pub(crate) use placed::{Placed, Placement};
pub(crate) use world::{Quiet, World};
