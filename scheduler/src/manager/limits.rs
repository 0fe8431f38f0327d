//! Capacities and allowances of the manager, in one place.

use crate::time::Duration;

/// The most occurrences that hold tickets, or wait for them at the agents, at
/// a time. Each of them has a gate of its own at the broker.
pub const SLOTS: usize = 40;

/// The most devices of a mission: they are kept in the bits of one word.
pub const MAX_DEVICES: usize = 128;

/// The most occurrences that are armed at a time: those that can start at one
/// instant, and some.
pub const MOST_ARMED: usize = 64;

/// Of how many tasks that are over it is remembered how they ended, in the
/// status and in the journal. The one that ended first is forgotten first.
pub const MOST_ENDED: usize = 1_000;

/// Of how many ids that no task has any more it is remembered how often they
/// were used: news of the last task must not pass for news of the next one.
/// News is never so late.
pub const MOST_GONE: usize = 10_000;

/// How far ahead an instant must lie to be prepared for. A sync takes less.
pub const ARMED_AHEAD: Duration = Duration::from_millis(50);

/// How far ahead an instant may lie to be prepared for. Who is armed when power
/// is lost is taken to have started: that doubt must not last for hours. Any
/// sync that a start can wait for takes less.
pub const ARMED_WITHIN: Duration = Duration::from_secs(10);

/// How late a host may be before it counts. A task whose window is one instant
/// starts although the manager was woken this late, and a process may run so
/// much longer than it was expected to before that is an overrun: to start and
/// to end one takes time.
pub const LATENESS: Duration = Duration::from_millis(100);

/// How often a routine task can come round at most. A host that does nothing
/// else could not keep up with much less.
pub const SHORTEST_INTERVAL: Duration = Duration::from_millis(1);

/// How long a body that declares no grace has between being told to end and
/// being killed: what a checkpoint or a kill may take where the schedule does
/// not say, and what a body has that is aborted and has no such policy.
pub const GRACE: Duration = Duration::from_secs(5);

const _: () = assert!(SLOTS <= MOST_ARMED, "everything that can start at an instant is armed");
