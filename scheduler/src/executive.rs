//! The executive: carries out what the manager says.

mod ports;

pub use ports::{Bodies, StartBody, TicketPort};
