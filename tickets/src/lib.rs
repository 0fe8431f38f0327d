//! Gates, tickets and validity functions.
#![no_std]
// No panic path: what cannot be is a typed error or a masked index.
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

pub mod amount;
pub mod clock;
pub mod device;
pub mod fault;
pub mod gate;
pub mod id;
pub mod interlock;
pub mod lock;
pub mod notify;
pub mod platform;
pub mod recorder;
pub mod refusal;
pub mod scope;
pub mod standing;
mod sync;
pub mod telemetry;
pub mod ticket;
pub mod validity;

pub use device::Device;
pub use gate::Gate;
pub use platform::{Containment, Platform};
pub use ticket::Ticket;
