//! What talks to a running schedule manager: the command port of a task's
//! process, and the control port of an operator.
//!
//! A *task's process* inherits a socket, its command port. What it asks there is
//! done under the task's tickets, or refused with the reason:
//!
//! ```no_run
//! use faregate_client::{CommandPort, Error};
//!
//! # fn main() -> Result<(), Error> {
//! let mut port = CommandPort::from_env()?;
//! match port.command("camera", "on", &[]) {
//!     Ok(reply) => println!("the camera says: {}", reply.text),
//!     Err(Error::Refused(why)) => eprintln!("the camera stays off: {why}"),
//!     Err(error) => return Err(error),
//! }
//! # Ok(())
//! # }
//! ```
//!
//! An *operator's program* connects to the manager's socket:
//!
//! ```no_run
//! # fn main() -> Result<(), faregate_client::Error> {
//! use faregate_client::Control;
//!
//! let mut control = Control::connect("/run/faregate.sock")?;
//! control.set_priority(31, 200)?;
//! for task in control.status()?.tasks {
//!     println!("{} {:?}", task.task, task.state);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Everything blocks and nothing runs in the background: there are no threads,
//! and no async runtime is wanted. Linux alone has the sockets of packets that
//! the command port stands on.
//!
//! | module | what |
//! |---|---|
//! | [`wire`] | the messages, for clients in other languages too |
//! | [`exit`] | the exit codes of programs that use this |

mod command;
mod control;
mod error;
pub mod exit;
mod refused;
mod sys;
mod watch;
pub mod wire;

pub use command::{CommandPort, Notices, Reply};
pub use control::Control;
pub use error::Error;
pub use refused::{Problem, RefusalKind, Refused};
pub use watch::{Change, Watch};

/// The version of both protocols. It changes when a message of an older one
/// would be misunderstood; what only adds to it does not change it.
pub const PROTOCOL: u32 = 1;
