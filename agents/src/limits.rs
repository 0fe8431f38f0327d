//! Capacities, in one place. Those that differ from mission to mission are
//! const parameters of [`Books`](crate::Books): gates `G`, seats `T`, sets `S`.

use faregate_tickets::amount::Milliwatts;

/// The most gates of one broker: they are kept in the bits of one word.
pub const MAX_GATES: usize = 64;

/// The most agents of one broker.
pub const MAX_AGENTS: usize = 8;

/// The most gates of one all-or-nothing request.
pub const MAX_SET_GATES: usize = 8;

/// The most seats of one broker: seats are linked by 16-bit numbers, one of
/// which means "none".
pub const MAX_SEATS: usize = u16::MAX as usize - 1;

/// Of so many seats one is kept for fault responses: who is less important
/// cannot fill the table before them.
pub const SEATS_PER_KEPT: usize = 16;

/// The largest supply that is counted with: so many gates' draws that fit it
/// cannot saturate a sum.
pub const LARGEST_SUPPLY: Milliwatts = Milliwatts::new(1 << 57);

const _: () = assert!(MAX_GATES <= 1 << (63 - 57), "64 draws that fit the supply fit a sum");

/// The levels of a roster, one for each priority.
pub(crate) const LEVELS: usize = 256;
