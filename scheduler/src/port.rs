//! The command ports of processes: how a program that a task started reaches
//! the gates that the task has tickets for.
//!
//! # Authority is the socket
//!
//! Each attempt has a socket of its own, which its process inherits. Whoever
//! holds the other end while the attempt lasts commands under its tickets: the
//! processes of the attempt, and whoever they passed it to. Nothing is claimed
//! about *which* process speaks: its credentials are not asked for, since a
//! process of the same user could take them on. What is claimed is when it
//! ends: [`CommandServer::close`](crate::executive::PortFactory::close) shuts
//! our end, and from then on no command begins, whoever has the socket. A
//! process that left its session, was forked twice or outlives its parent has
//! gained nothing.
//!
//! # Who waits for whom
//!
//! The manager waits for nobody. One thread (`faregate-port`) reads all
//! sockets, and never blocks: a message has a limit, an answer that finds the
//! socket full ends the connection. The commands of an attempt are issued by a
//! thread of the attempt's own, in their order, since a device may be slow. So
//! a slow device, a flood or a reader that sleeps costs nobody but its own
//! attempt; heartbeats are heard even while a command is in progress.
//!
//! Between the threads lie one atomic word per attempt ([`Entrance`]), one flag
//! for heartbeats ([`Beat`]), and channels. The first two have models of their
//! own in `scheduler/models`.
//!
//! # Limits
//!
//! [`MAX_CONNECTIONS`], [`MAX_QUEUED`], and
//! [`MAX_MESSAGE`](faregate_client::wire::command::MAX_MESSAGE). A message with
//! a file descriptor in it is read, and the descriptor dropped by the one
//! reading thread: a process that passes a TCP socket which lingers at its
//! close can delay the other attempts' ports by it, though not the manager.

mod beat;
mod connection;
mod counts;
mod entrance;
mod server;
mod thread;
mod worker;

pub use beat::Beat;
pub use connection::WhyClosed;
pub use counts::PortCounts;
pub use entrance::{Entrance, Inside, Quiet};
pub use server::CommandServer;

/// The most connections of one attempt, the inherited one among them.
pub const MAX_CONNECTIONS: usize = 16;

/// The most commands of one attempt that wait for their turn. More are refused.
pub const MAX_QUEUED: usize = 64;
