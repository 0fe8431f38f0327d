//! What tasks do, for real: processes, functions, sequences and holds.
//!
//! [`RealBodies`] belongs to the manager's thread, and keeps nothing waiting
//! there: what takes time is done by processes, by worker threads, and by the
//! kernel, which wake the thread when there is something to tell.
//!
//! **A process** is started with everything that it will start in mind. It dies
//! with the manager's thread. It has a session of its own, so that nobody's
//! terminal interrupts it; nothing to read; no descriptor beyond its three and
//! its command port; and the default action for every signal. Whatever it
//! forks, however often, and whoever of it outlives its parents, is paused, let
//! go on, measured and killed with it. Its end is its main process's end, told
//! when nothing of it lives any more.
//!
//! It is told who it is by `FAREGATE_TASK` (its id), `FAREGATE_OCCURRENCE`
//! (from 0), `FAREGATE_ATTEMPT` (from 1) and, where it has a command port,
//! `FAREGATE_PORT` (the descriptor).
//!
//! **A function** runs on a worker. It cannot be stopped from outside, only
//! asked; see [`Invocation::asked_to_stop`]. **A sequence** has its commands
//! issued by workers, one at a time. **A hold** is a time of its own.
//!
//! # Rights
//!
//! Control groups make the pause and the end of a process tree one write each.
//! They take the right to make groups below the manager's own (root's, or a
//! service manager's delegation) and Linux 5.14. Without them, trees are found
//! by looking at all processes of the host; [`RealBodies::control_group`] says
//! which it is. Linux 5.11 is needed in either case.
//!
//! A set-user-ID program does not die with the manager: the kernel forgets that
//! it should. The [`sweep`] of the next one ends it.
//!
//! Without control groups this is not claimed:
//! - Of a chain of processes that each leave their session, start the next one
//!   and end, sooner than the host's processes can be looked at, the last one
//!   may be missed.
//! - A process that at the violent end of the manager has left its session *and*
//!   cleaned its environment outlives the [`sweep`].
//! - One that hides like that from a living manager is not told apart by task: it
//!   is killed as soon as any task is paused or ends.
//! - One that has left its session *and* bears the mark of another manager in its
//!   environment is taken for that one's.
//!
//! # The parts
//!
//! | part | what |
//! |---|---|
//! | `run` | all bodies, behind one descriptor |
//! | `processes`, `process` | programs, each with everything that it starts |
//! | `family`, `cgroup`, `procfs` | which process belongs to whom |
//! | `launch`, `children`, `sys` | fork, exec, reap |
//! | `output` | what programs print |
//! | `sweep` | what a killed manager has left |
//! | `functions`, `sequences`, `workers` | what threads do |
//! | `holds` | what only takes its time |
//! | `gauge` | how much memory and storage there is, and is used |
//! | `settings` | what can be set |

mod cgroup;
mod children;
mod family;
mod functions;
mod gauge;
mod holds;
mod launch;
mod output;
mod process;
mod processes;
mod procfs;
mod run;
mod sequences;
mod settings;
mod sweep;
mod sys;
mod workers;

pub use functions::{Function, Functions, Invocation, NotRegistered};
pub(crate) use gauge::Gauge;
pub use output::{Output, Printed};
pub use run::RealBodies;
pub use settings::{Moment, Probe, Settings, Surroundings};
pub(crate) use sweep::end_left;
pub use sweep::{Swept, sweep};
