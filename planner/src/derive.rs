//! What follows from what is placed: heating, awake time, charge.
//!
//! Nothing of it is ever edited. A set of timed activities, the parameters and
//! the state have one derived world, which is made anew whenever one of them
//! changes; a candidate is judged by the world that it would make.

mod awake;
mod heat;
mod mark;
mod open;
mod own;
mod placed;
mod renewal;
pub(crate) mod var;
mod world;

pub(crate) use awake::Sweep;
pub(crate) use mark::{After, Mark, Open, Phase};
pub(crate) use own::{Blocked, Candidate, Frame, Late, NONE, Own, OwnStep};
pub(crate) use placed::{Placed, Placement};
pub(crate) use renewal::Change;
pub(crate) use world::{Leap, Piece, World, late_heats};
