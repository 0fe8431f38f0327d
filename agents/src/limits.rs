//! Capacities, in one place. Those that differ from mission to mission are
//! const parameters of [`Books`](crate::Books): gates `G`, seats `T`, sets `S`.

/// The most gates of one broker: they are kept in the bits of one word.
pub const MAX_GATES: usize = 64;

/// The most agents of one broker.
pub const MAX_AGENTS: usize = 8;

/// The most gates of one all-or-nothing request.
pub const MAX_SET_GATES: usize = 8;

/// The most seats of one broker: seats are linked by 16-bit numbers, one of
/// which means "none".
pub const MAX_SEATS: usize = u16::MAX as usize;

/// The levels of a roster, one for each priority.
pub const LEVELS: usize = 256;
