//! A simulated world around the books: real gates, tickets, standings and
//! scopes, devices with a truth of their own, and a shell that may do its work
//! late, twice, or report it out of order. Alone on one thread, so that a
//! history is a value: it can be shrunk, and run again.

pub mod checks;
pub mod lamp;
pub mod oracle;
pub mod shell;
pub mod step;
pub mod world;
