//! Gates, tickets and validity functions.
#![no_std]

pub mod amount;
pub mod clock;
pub mod device;
pub mod id;
pub mod lock;
pub mod platform;
pub mod recorder;
mod sync;

pub use device::Device;
pub use platform::{Containment, Platform};
