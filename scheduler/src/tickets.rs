//! The tickets of tasks, at the agents of a broker.
//!
//! *A task is a device.* It has a place behind a gate, with its draw and its
//! categories. To start it takes a ticket for the place and for each device that
//! it commands, all or nothing, at the task's priority. Who is more important
//! takes them away by the same means by which it takes a camera: the commands
//! of the task refuse at once; its place is charged until the manager, as the
//! place's sensor, says that the body stands still; and the taker is granted
//! then.
//!
//! An [`Installation`] puts a mission's broker together: agents, places, and
//! [`Driver`]s by name. It becomes the [`Tickets`] that an executive asks, and
//! they have a [`Commander`] for everybody who commands devices for a task.
//!
//! ```
//! # use faregate_tickets::Device;
//! # use faregate_tickets::clock::Duration;
//! # use faregate_tickets::device::{Declaration, Effect, Profile};
//! # struct Lamp;
//! # impl Device for Lamp {
//! #     type Command = bool;
//! #     type Response = ();
//! #     type Fault = ();
//! #     fn profile(&self) -> Profile { Profile::new() }
//! #     fn declare(on: &bool) -> Declaration {
//! #         let wcet = Duration::from_millis(1);
//! #         Declaration { code: (*on).into(), wcet, effect: Effect::Unchanged }
//! #     }
//! #     fn issue(&mut self, _: bool) -> Result<(), ()> { Ok(()) }
//! #     fn safe(&mut self) -> Result<(), ()> { Ok(()) }
//! # }
//! use faregate_agents::Categories;
//! use faregate_scheduler::Mission;
//! use faregate_scheduler::executive::Waker;
//! use faregate_scheduler::mission::DeviceSpec;
//! use faregate_scheduler::tickets::{Installation, Named};
//!
//! let mission = Mission::default();
//! let waker = Waker::new()?;
//! let mut installation = Installation::new(&mission, &waker)?;
//! let spec = DeviceSpec {
//!     name: "lamp".into(),
//!     kind: "lamp".into(),
//!     agent: "tasks".into(),
//!     draw: None,
//!     categories: Categories::NONE,
//!     parameters: Default::default(),
//! };
//! let lamp = Named::new(Lamp).command("on", true, "light it").command("off", false, "darken it");
//! installation.device(&spec, Box::new(lamp))?;
//! let tickets = installation.start()?;
//! assert_eq!(tickets.commander().gates().names().collect::<Vec<_>>(), ["lamp"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Whose hands
//!
//! The manager decides which tasks run, and the agents decide whose tickets are
//! valid; both by the same order and the same walk. Where they differ, the
//! agents are right: they know of devices that are stuck, gates that are
//! faulted, supervisors, and whoever else asks the same broker. The manager
//! hears of that as of a request that is blocked.

mod ask;
mod authority;
mod driver;
mod entry;
mod gates;
mod install;
mod modes;
mod named;
mod names;
mod place;
mod port;
mod settle;
mod turn;

pub use authority::Commander;
pub use driver::{
    ANSWER, ARGUMENTS, Answer, Catalogue, CommandSpec, Driver, Fault, GateCommand, GateDevice,
    Reply,
};
pub use gates::Gates;
pub use install::{Installation, NotInstalled};
pub use named::Named;
pub use port::Tickets;

pub use crate::manager::limits::SLOTS;

use faregate_agents::limits::MAX_SET_GATES;
use faregate_runtime::broker::{GATES, SETS, TICKETS};

/// How many gates a task can command: with its place they are one request.
pub const MOST_GATES: usize = MAX_SET_GATES - 1;

const _: () = {
    assert!(SLOTS < GATES, "there is room for devices beside the places");
    assert!(SLOTS <= SETS, "each task can command devices");
    assert!(SLOTS + 2 * (GATES - SLOTS) < TICKETS / 2, "modes have seats, and others, too");
};
