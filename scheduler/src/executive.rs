//! The executive: carries out what the manager says.

mod drive;
mod ports;
mod virtual_bodies;
mod virtual_tickets;
mod virtual_time;

pub use drive::{Driver, JournalSink, LoadedFile, Outside, Ports};
pub use ports::{Bodies, StartBody, TicketPort};
pub use virtual_bodies::{Conduct, VirtualBodies, expected};
pub use virtual_tickets::VirtualTickets;
pub use virtual_time::{Stuck, Unwritten, VirtualExecutive};
mod hooks;
mod ports;
mod waker;

pub use hooks::{
    CommandRefused, Commands, NoDevices, NoPorts, PortFactory, PortNotice, RefusedKind,
};
pub use ports::{Bodies, StartBody, TicketPort};
pub use waker::Waker;
