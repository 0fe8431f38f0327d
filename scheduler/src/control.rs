//! The control port: how a running schedule is commanded from outside.
//!
//! Everything that commands the manager is a [`Link`]: the Unix socket of
//! [`SocketLink`], a radio, a test. [`Links`] gathers what all of them ask,
//! gives each answer to the one who asked, and tells all of them every change.
//!
//! A link does its waiting, reading and parsing elsewhere. What it does on the
//! manager's thread is take from a queue and put into one: so nothing that
//! comes over a link, however long, malformed or slow, disturbs the schedule.
//!
//! # The socket
//!
//! Lines of JSON; the messages are
//! [`faregate_client::wire::control`]. The socket can be
//! opened by its owner alone, and is so from the first instant at which it has
//! its name: it is made in a directory that nobody else can enter. Who
//! connects is looked at again, and must be the manager's user or root. A
//! socket that nobody listens at any more is replaced; one that somebody
//! listens at, or a file that is no socket, is left as it is, and that is an
//! error. A lock beside the socket decides between two managers.
//!
//! Limits: [`MAX_CLIENTS`], one ask of each at a time, lines of
//! [`MAX_LINE`](faregate_client::wire::control::MAX_LINE). Who watches and does
//! not read is told how many changes it has missed.

mod client;
mod convert;
mod door;
mod files;
mod lines;
mod link;
mod listen;
mod reading;
mod socket;
mod status;
mod thread;

pub use files::schedule_text;
pub use link::{AskId, Asked, Link, Links, What};
pub use socket::{ControlCounts, ReadSchedule, SocketLink};
pub use status::StatusSource;

/// The most connections at a time. More are refused.
pub const MAX_CLIENTS: usize = 16;

/// The longest schedule file that a task may load, in bytes.
pub const MAX_FILE: u64 = 64 << 20;

/// How many changes wait for who watches. More are counted.
pub const MAX_NOTES: usize = 4096;

/// What an answer says of the mistakes in a schedule, in bytes.
const MISTAKES: usize = 1 << 20;

/// The same of a file that a task loads: it is the task's end, which is kept.
const MISTAKES_OF_FILE: usize = 4 << 10;
