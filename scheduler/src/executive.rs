//! The executive: carries out what the manager says.

#[cfg(target_os = "linux")]
mod clock;
mod drive;
mod hooks;
#[cfg(target_os = "linux")]
mod host;
mod ports;
mod virtual_bodies;
mod virtual_tickets;
mod virtual_time;
mod waker;

#[cfg(target_os = "linux")]
pub use clock::{HostClock, Timers};
pub use drive::{Driver, JournalSink, LoadedFile, Outside, Ports};
pub use hooks::{
    CommandRefused, Commands, NoDevices, NoPorts, PortFactory, PortNotice, RefusedKind,
};
#[cfg(target_os = "linux")]
pub use host::{Correspondent, HostExecutive, Watched};
pub use ports::{Bodies, StartBody, TicketPort};
pub use virtual_bodies::{Conduct, VirtualBodies, expected};
pub use virtual_tickets::VirtualTickets;
pub use virtual_time::{Stuck, Unwritten, VirtualExecutive};
pub use waker::Waker;
