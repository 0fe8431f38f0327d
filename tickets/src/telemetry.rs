//! State variables that validity functions look at: the spacecraft's mode, and
//! numbered channels of measured values.
//!
//! State estimation writes, gates read inside their critical sections. Nobody
//! waits for anybody, and no 64-bit atomics are needed.
//!
//! # Each value with its time
//!
//! A channel is three words: the value, and the low and the high half of the
//! time of its measurement. They are written in this order and read in the
//! opposite one; the writes of the halves are `Release`, their reads `Acquire`.
//! Who sees the high half of one publication therefore sees the low half of the
//! same or of a later one, and the value of that or of a still later one. So:
//!
//! - where the halves belong to the same 71 minutes (2^32 us), they are the
//!   time of one publication, and the value is of that or of a later one;
//! - where they do not, the low half is of the later publication, and both
//!   together say less than its time.
//!
//! A reader in the midst of a publication can take a fresh value for an old
//! one; never an old one for fresh.

use crate::clock::{Duration, Instant};
use crate::sync::{AtomicUsize, Ordering, array_of, const_unless_loom};

/// How many channels there are.
pub const CHANNELS: usize = 16;

/// How many modes there are.
pub const MODES: u8 = 32;

/// The table of state variables.
#[derive(Debug)]
pub struct Telemetry {
    mode: AtomicUsize,
    channels: [Slot; CHANNELS],
}

impl Telemetry {
    const_unless_loom! {
        /// A table in which nothing was measured, in mode 0.
        #[must_use]
        pub fn new() -> Self {
            Self { mode: AtomicUsize::new(0), channels: array_of!(Slot::new(), CHANNELS) }
        }
    }

    /// The spacecraft is in this mode from now.
    ///
    /// # Timing
    /// Constant: one atomic store.
    pub fn set_mode(&self, mode: Mode) {
        // Release, so that what was written before the mode was changed is seen
        // by whoever acts in that mode. Pairs with `mode`.
        self.mode.store(usize::from(mode.0), Ordering::Release);
    }

    /// The mode that was set last.
    ///
    /// # Timing
    /// Constant: one atomic load.
    #[must_use]
    pub fn mode(&self) -> Mode {
        // Acquire: pairs with `set_mode`. Only modes are ever stored.
        let number = self.mode.load(Ordering::Acquire);
        Mode(u8::try_from(number).unwrap_or(0))
    }

    /// Publishes what was measured, and when by the broker's clock (not when it
    /// arrived). A measurement that is older than the published one is left
    /// out.
    ///
    /// A channel has one writer at a time: two at once could pair the value of
    /// one with the time of the other.
    ///
    /// # Timing
    /// Constant: two atomic loads and three stores.
    pub fn publish(&self, channel: Channel, value: i32, measured_at: Instant) {
        self.slot(channel).publish(value, measured_at);
    }

    /// The latest value and how old it is; `None` if nothing was measured.
    ///
    /// # Timing
    /// Constant: three atomic loads.
    #[must_use]
    pub fn read(&self, channel: Channel, now: Instant) -> Option<Reading> {
        self.slot(channel).read(now)
    }

    #[expect(clippy::indexing_slicing, reason = "masked to the number of channels")]
    fn slot(&self, channel: Channel) -> &Slot {
        // The mask changes nothing: it spares the check of the bounds.
        &self.channels[usize::from(channel.0) & (CHANNELS - 1)]
    }
}

impl Default for Telemetry {
    fn default() -> Self {
        Self::new()
    }
}

const _: () = assert!(CHANNELS.is_power_of_two(), "channels are selected by a mask");
const _: () = assert!(usize::BITS >= 32, "a word holds a value, or half of a time");

/// What a channel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reading {
    /// The latest value, in the channel's own unit.
    pub value: i32,
    /// How long ago it was measured, or a little more.
    pub age: Duration,
}

/// A channel of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Channel(u8);

impl Channel {
    /// The channel with this number, if there is one below [`CHANNELS`].
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if (number as usize) < CHANNELS { Some(Self(number)) } else { None }
    }
}

/// A mode of the spacecraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Mode(u8);

impl Mode {
    /// The mode with this number, if there is one below [`MODES`].
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number < MODES { Some(Self(number)) } else { None }
    }
}

/// A set of modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Modes(u32);

impl Modes {
    /// No mode.
    pub const NONE: Self = Self(0);

    /// These modes and `mode`.
    #[must_use]
    pub const fn and(self, mode: Mode) -> Self {
        Self(self.0 | bit(mode))
    }

    /// Whether `mode` is one of them.
    #[must_use]
    pub const fn contains(self, mode: Mode) -> bool {
        self.0 & bit(mode) != 0
    }
}

impl From<Mode> for Modes {
    fn from(mode: Mode) -> Self {
        Self::NONE.and(mode)
    }
}

const fn bit(mode: Mode) -> u32 {
    // Wrapping, because a mode is less than 32, and a check could panic.
    1_u32.wrapping_shl(mode.0 as u32)
}

/// One channel. Why these orderings: see the top of this file.
#[derive(Debug)]
struct Slot {
    value: AtomicUsize,
    low: AtomicUsize,
    /// `NEVER` until the first publication.
    high: AtomicUsize,
}

/// No high half of a time that a mission lives to see.
const NEVER: usize = usize::MAX;

impl Slot {
    const_unless_loom! {
        fn new() -> Self {
            Self {
                value: AtomicUsize::new(0),
                low: AtomicUsize::new(0),
                high: AtomicUsize::new(NEVER),
            }
        }
    }

    fn publish(&self, value: i32, measured_at: Instant) {
        let latest = self.measured_at();
        if latest.is_none_or(|latest| measured_at >= latest) {
            self.put(value, measured_at);
        }
    }

    fn put(&self, value: i32, measured_at: Instant) {
        let micros = measured_at.as_micros();
        // Relaxed: the next store publishes it, and seeing it early does no harm.
        self.value.store(word(u64::from(value.cast_unsigned())), Ordering::Relaxed);
        // Publishes the value; pairs with the load in `measured_at`.
        #[cfg(not(feature = "mutant-relaxed-publish"))]
        self.low.store(word(micros & LOW), Ordering::Release);
        #[cfg(feature = "mutant-relaxed-publish")]
        self.low.store(word(micros & LOW), Ordering::Relaxed);
        // Publishes the low half; pairs with the load in `measured_at`.
        self.high.store(word(micros >> 32), Ordering::Release);
    }

    fn read(&self, now: Instant) -> Option<Reading> {
        let measured_at = self.measured_at()?;
        // Relaxed: after the Acquire of the low half, which is what it goes with.
        let value = low_half(self.value.load(Ordering::Relaxed)).cast_signed();
        Some(Reading { value, age: now.since(measured_at) })
    }

    fn measured_at(&self) -> Option<Instant> {
        // Pairs with the store in `publish`: the low half is not older.
        let high = self.high.load(Ordering::Acquire);
        if high == NEVER {
            return None;
        }
        // Pairs with the store in `publish`: the value is not older.
        let low = self.low.load(Ordering::Acquire);
        let micros = u64::from(low_half(high)) << 32 | u64::from(low_half(low));
        Some(Instant::from_micros(micros))
    }
}

const LOW: u64 = 0xFFFF_FFFF;

/// At most 32 bits, which every word has.
fn word(half: u64) -> usize {
    usize::try_from(half).unwrap_or(NEVER)
}

fn low_half(word: usize) -> u32 {
    u32::try_from(word).unwrap_or(u32::MAX)
}

#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;

    const HALF: u64 = 1 << 32;

    fn at(us: u64) -> Instant {
        Instant::from_micros(us)
    }

    #[expect(clippy::expect_used, reason = "a test helper")]
    fn channel(number: u8) -> Channel {
        Channel::new(number).expect("a channel")
    }

    #[test]
    fn what_was_published_is_read_with_its_age() {
        let table = Telemetry::new();
        for (number, value, measured) in [
            (0, 0, 0),
            (1, -1, 1),
            (2, i32::MIN, HALF - 1),
            (3, i32::MAX, HALF),
            (15, 7, 3 * HALF + 5),
        ] {
            assert_eq!(table.read(channel(number), at(measured)), None);
            table.publish(channel(number), value, at(measured));
            let age = Duration::from_micros(9);
            let read = table.read(channel(number), at(measured + 9));
            assert_eq!(read, Some(Reading { value, age }));
        }
    }

    #[test]
    fn a_channel_that_fell_silent_never_looks_fresh_again() {
        let table = Telemetry::new();
        table.publish(channel(0), 1, at(5));
        for wraps in 1..5 {
            let age = Duration::from_micros(wraps * HALF);
            let read = table.read(channel(0), at(5 + wraps * HALF));
            assert_eq!(read.map(|reading| reading.age), Some(age));
        }
    }

    #[test]
    fn an_older_measurement_does_not_replace_a_newer_one() {
        let table = Telemetry::new();
        table.publish(channel(0), 1, at(HALF));
        table.publish(channel(0), 2, at(HALF - 1));
        let read = table.read(channel(0), at(HALF));
        assert_eq!(read, Some(Reading { value: 1, age: Duration::ZERO }));
    }

    #[test]
    fn there_are_only_so_many_channels_and_modes() {
        assert_eq!((Channel::new(15).is_some(), Channel::new(16)), (true, None));
        assert_eq!((Mode::new(31).is_some(), Mode::new(32)), (true, None));
    }

    #[test]
    fn the_mode_is_the_one_that_was_set_last() {
        let table = Telemetry::default();
        for number in [0, 31, 4] {
            let mode = Mode::new(number).expect("a mode");
            table.set_mode(mode);
            assert_eq!(table.mode(), mode);
            assert!(Modes::from(mode).contains(mode));
            assert!(!Modes::NONE.contains(mode));
        }
    }
}
