//! A simulated world around the books: real gates, tickets, standings and
//! scopes, devices with a truth of their own, and a shell that may do its work
//! late, twice, or report it out of order. Alone on one thread, so that a
//! history is a value: it can be shrunk, and run again.
#![allow(dead_code, reason = "each file uses its own part of the world")]

pub(crate) mod checks;
pub(crate) mod lamp;
pub(crate) mod oracle;
pub(crate) mod shell;
pub(crate) mod step;
pub(crate) mod world;
