//! The schedule manager: what runs when, on tickets.
//!
//! A *task* is a program, a function, a sequence of commands or a mere claim on
//! resources, with times, a priority and conflict categories. The [`Manager`]
//! decides which tasks run. It is a pure step function, from its state, what
//! happened and the present instant to actions. An *executive* feeds it and
//! carries out what it says: on a virtual clock faster than real time, or with
//! processes, threads and the tickets of a broker.
//!
//! No task is dispatched without valid tickets for everything that it may
//! touch. Who loses its tickets is stopped, and goes on when they are valid
//! again.
//!
//! # The parts
//!
//! | part | what |
//! |---|---|
//! | [`task`] | what a task is |
//! | [`mission`] | devices, agents, margins, category names, modes |
//! | [`format`](mod@format) | schedule and mission files: read, judged, written |
//! | [`manager`] | decides: events in, actions out |
//! | [`analyze`](mod@analyze) | what will become of a schedule |
//! | [`executive`] | carries out: the loop, and the ports it needs |
//! | [`port`] | lets a task's processes command devices under its tickets |
//! | [`control`] | takes telecommands, over a socket and over any other link |
//! | [`journal`] | remembers, after a crash and after a loss of power |
//! | [`tickets`] | asks the agents of a broker, and commands devices by name |

pub mod analyze;
#[cfg(target_os = "linux")]
pub mod bodies;
#[cfg(target_os = "linux")]
pub mod control;
pub mod executive;
pub mod format;
pub mod journal;
pub mod manager;
pub mod mission;
#[cfg(target_os = "linux")]
pub mod onboard;
#[cfg(target_os = "linux")]
pub mod port;
#[cfg(target_os = "linux")]
mod sync;
pub mod task;
pub mod tickets;
pub mod time;

pub use manager::Manager;
pub use mission::Mission;
#[cfg(target_os = "linux")]
pub use onboard::Onboard;
pub use task::{Task, TaskId};
