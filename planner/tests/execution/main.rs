//! The control thread, slide by slide: what it checks before a start, what it
//! aborts, and what it starts early.

mod aborts;
mod attacks;
mod bench;
mod computer;
mod dispatch;
mod early;
mod handover;
mod named;
mod pauses;
mod replans;
mod silence;
