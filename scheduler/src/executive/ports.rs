//! What an executive needs: bodies and tickets. (The journal and the control
//! port are the real executive's own.)
//!
//! All calls are made by the manager's thread and return at once. What comes
//! of them is an event, collected by `poll` when the manager's thread was woken
//! by the port's own means, or when `next_due` has come.

use crate::manager::{Attempt, Event, Needs, Occurrence, Stop, StopWhy};
use crate::task::Task;
use crate::time::{Instant, Now};

/// A body to be started.
#[derive(Clone, Copy, Debug)]
pub struct StartBody<'a> {
    /// Which attempt.
    pub attempt: Attempt,
    /// Its task.
    pub task: &'a Task,
    /// The present.
    pub now: Now,
}

/// Runs the bodies of tasks: processes, functions, sequences, holds.
pub trait Bodies {
    /// Starts a body. One that cannot be started exits with
    /// [`Exit::NotStarted`](crate::manager::Exit::NotStarted).
    fn start(&mut self, body: StartBody<'_>);

    /// Stops a body; see [`Action::Stop`](crate::manager::Action::Stop).
    fn stop(&mut self, attempt: Attempt, how: Stop, why: &StopWhy, now: Now);

    /// Lets a paused body go on.
    fn resume(&mut self, attempt: Attempt, now: Now);

    /// What has happened since: exits, stops.
    fn poll(&mut self, now: Now, events: &mut Vec<Event>);

    /// When something happens by itself, if nothing happens before.
    fn next_due(&self) -> Option<Instant>;
}

/// Asks the agents for tickets, and hears what became of them.
pub trait TicketPort {
    /// Asks for tickets, all or nothing. A pre-empted occurrence keeps its
    /// request, and is granted again in its turn without asking.
    fn request(&mut self, occurrence: Occurrence, needs: &Needs, victims: &[Occurrence], now: Now);

    /// A body is about to run: it is started, or let go on. From now on the
    /// commands of this attempt count, and of no other one of the occurrence.
    fn started(&mut self, attempt: Attempt, now: Now) {
        let _ = (attempt, now);
    }

    /// The body of an occurrence whose tickets were taken stands still, or has
    /// exited: what it drew can be credited.
    fn stopped(&mut self, occurrence: Occurrence, now: Now);

    /// Gives the tickets back.
    fn relinquish(&mut self, occurrence: Occurrence, now: Now);

    /// Takes the gates of a mode from everybody.
    fn reserve(&mut self, mode: &str, gates: &[String], now: Now);

    /// Gives the gates of a mode back.
    fn unreserve(&mut self, mode: &str, now: Now);

    /// What has happened since: granted, taken, blocked, refused.
    fn poll(&mut self, now: Now, events: &mut Vec<Event>);

    /// When something happens by itself, if nothing happens before (a lease to
    /// be renewed).
    fn next_due(&self) -> Option<Instant>;
}
