//! Ticket agents: who may command what, decided by policy.
#![no_std]
// No panic path: what cannot be is a typed error or a masked index.
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![forbid(unsafe_code)]

mod books;
mod broker;
pub mod limits;
mod policy;
mod refusal;
mod roster;

pub use books::{Actions, Ask, Books, DeviceReport, DeviceState, Done, Event, Noted, Work};
pub use broker::{
    AgentId, Broker, Handle, NotYours, Quiescent, RegisterError, Revoked, Supervisor, Want, Wants,
};
pub use policy::{Categories, Policy};
pub use refusal::{Capacity, RequestRefused, Waiting};
