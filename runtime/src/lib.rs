//! What threads need of the operating system.

pub mod broker;
pub mod clock;
pub mod contain;
pub mod host;
pub mod lanes;
#[cfg(target_os = "linux")]
pub mod realtime;
#[cfg(target_os = "linux")]
mod sys;
mod waiters;
pub mod wake;

pub use broker::{Broker, Builder, GateOptions, Handle, NotValid, Ticket};
pub use waiters::Waiters;
