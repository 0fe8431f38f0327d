//! Interlocks: two sides of which at most one may be on.
//!
//! The thruster valves and the heaters of their catalyst beds share a supply
//! that cannot bear both. Each gate on one side holds a [`Member`]; tickets
//! whose [validity](crate::validity::Function::interlock) asks for it turn a
//! device on only while every member of the other side is certain to be off.
//!
//! # Announce, then look
//!
//! Each side announces that its device may be on *before* it looks at the other
//! side, and a `SeqCst` fence stands between the two. The fences of two gates
//! have an order; the gate whose fence is second sees the announcement of the
//! first. So both may refuse, when they try at the same time, and never do
//! both agree.
//!
//! What was announced stays until the agent has seen the device off.

use core::fmt;

use crate::sync::{AtomicUsize, Ordering, array_of, const_unless_loom, fence};
use crate::validity::{Denial, Rule};

/// Two sides that may not both be on. Only tickets with the function are held
/// back: who commands without it announces, and is not asked.
#[derive(Debug)]
pub struct Interlock {
    /// Which places of each side are taken.
    taken: [AtomicUsize; 2],
    /// Which members of each side may be on: bit *i* is changed by member *i*
    /// alone, inside its gate's lock.
    may_be_on: [AtomicUsize; 2],
}

/// A side of an interlock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The one.
    A,
    /// The other.
    B,
}

impl Interlock {
    const_unless_loom! {
        /// An interlock without members.
        #[must_use]
        pub fn new() -> Self {
            Self {
                taken: array_of!(AtomicUsize::new(0), 2),
                may_be_on: array_of!(AtomicUsize::new(0), 2),
            }
        }
    }

    /// Takes a place for one gate. It stays taken.
    ///
    /// # Errors
    /// [`NoPlace`] when there is no such place, or another gate has it: two
    /// gates with one bit would withdraw each other's announcements.
    pub fn member(&self, side: Side, place: u8) -> Result<Member<'_>, NoPlace> {
        let bit = 1_usize.checked_shl(u32::from(place)).ok_or(NoPlace::Unknown { place })?;
        // Relaxed: only the value is asked for; nothing is published by it.
        let before = side.of(&self.taken).fetch_or(bit, Ordering::Relaxed);
        if before & bit != 0 {
            return Err(NoPlace::Taken { place });
        }
        let own = side.of(&self.may_be_on);
        Ok(Member { own, other: side.opposite().of(&self.may_be_on), bit })
    }
}

impl Default for Interlock {
    fn default() -> Self {
        Self::new()
    }
}

impl Side {
    const fn opposite(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    const fn of(self, [a, b]: &[AtomicUsize; 2]) -> &AtomicUsize {
        match self {
            Self::A => a,
            Self::B => b,
        }
    }
}

/// One gate's place in an interlock. A new member is certain to be off as far
/// as the interlock knows; its gate announces it where that is not so.
#[derive(Debug)]
pub struct Member<'a> {
    own: &'a AtomicUsize,
    other: &'a AtomicUsize,
    bit: usize,
}

impl Member<'_> {
    /// The device may be on from now, whatever the other side does: it was
    /// found so.
    ///
    /// # Timing
    /// Constant: one atomic operation.
    pub(crate) fn announce(&self) {
        // Relaxed: `enter` puts a fence behind it; the other callers do not look
        // at the other side. The old value is not used, because to get it x86
        // loops; without it this is a `lock or`.
        self.own.fetch_or(self.bit, Ordering::Relaxed);
    }

    /// Announces that the device may be on from now, if the other side is
    /// certain to be off.
    ///
    /// # Errors
    /// A denial by [`Rule::Interlock`]; then nothing is announced that was not before.
    ///
    /// # Timing
    /// Constant: at most two atomic operations, two loads and a fence.
    pub(crate) fn enter(&self) -> Result<(), Denial> {
        let announced_before = self.may_be_on();
        #[cfg(feature = "mutant-look-first")]
        let other = self.other.load(Ordering::Acquire);
        self.announce();
        // Between the announcement and the look: of two gates that enter, one
        // has its fence behind the other's and sees the other's announcement.
        #[cfg(not(feature = "mutant-no-fence"))]
        fence(Ordering::SeqCst);
        // Acquire: pairs with the withdrawals it sees. What the other side did
        // until it was seen off happened before what is commanded now.
        #[cfg(not(feature = "mutant-look-first"))]
        let other = self.other.load(Ordering::Acquire);
        if other == 0 {
            return Ok(());
        }
        if !announced_before {
            self.withdraw();
        }
        Err(Denial::by(Rule::Interlock))
    }

    /// The device was seen off, or was not commanded after all.
    ///
    /// # Timing
    /// Constant: one atomic operation.
    pub(crate) fn withdraw(&self) {
        // Release: pairs with the look of the other side in `enter`. Later
        // changes of the word by other members continue the release sequence.
        #[cfg(not(feature = "mutant-relaxed-withdrawal"))]
        self.own.fetch_and(!self.bit, Ordering::Release);
        #[cfg(feature = "mutant-relaxed-withdrawal")]
        self.own.fetch_and(!self.bit, Ordering::Relaxed);
    }

    /// Whether this member's device is announced as one that may be on. Another
    /// thread may change that at any time; `true` inside the gate's lock stays
    /// `true` until the gate withdraws.
    #[must_use]
    pub fn may_be_on(&self) -> bool {
        // Relaxed: inside the gate's lock the bit is the gate's own.
        self.own.load(Ordering::Relaxed) & self.bit != 0
    }
}

/// Why a gate did not get a place in an interlock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NoPlace {
    /// A side has as many places as a word has bits.
    Unknown {
        /// What was asked for.
        place: u8,
    },
    /// Another gate has it.
    Taken {
        /// What was asked for.
        place: u8,
    },
}

impl fmt::Display for NoPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { place } => write!(f, "a side has no place {place}"),
            Self::Taken { place } => write!(f, "place {place} belongs to another gate"),
        }
    }
}

impl core::error::Error for NoPlace {}

#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;

    const REFUSED: Result<(), Denial> = Err(Denial::by(Rule::Interlock));

    #[expect(clippy::expect_used, reason = "a test helper")]
    fn pair(interlock: &Interlock) -> [Member<'_>; 2] {
        [Side::A, Side::B].map(|side| interlock.member(side, 0).expect("a free place"))
    }

    #[test]
    fn one_side_on_keeps_the_other_off_until_it_is_seen_off() {
        let interlock = Interlock::new();
        let [valve, heater] = pair(&interlock);
        assert_eq!(valve.enter(), Ok(()));
        assert_eq!(heater.enter(), REFUSED);
        valve.withdraw();
        assert_eq!(heater.enter(), Ok(()));
        assert_eq!(valve.enter(), REFUSED);
    }

    #[test]
    fn members_of_one_side_do_not_hinder_each_other() {
        let interlock = Interlock::new();
        let [first, heater] = pair(&interlock);
        let last = interlock.member(Side::A, 31).expect("a free place");
        assert_eq!((first.enter(), last.enter()), (Ok(()), Ok(())));
        first.withdraw();
        assert_eq!(heater.enter(), REFUSED);
        last.withdraw();
        assert_eq!(heater.enter(), Ok(()));
    }

    #[test]
    fn a_refusal_withdraws_the_announcement_and_no_earlier_one() {
        let interlock = Interlock::new();
        let [valve, heater] = pair(&interlock);
        valve.announce();
        assert_eq!(heater.enter(), REFUSED);
        assert!(!heater.may_be_on());
        heater.announce();
        assert_eq!(heater.enter(), REFUSED);
        assert!(heater.may_be_on());
    }

    #[test]
    fn a_place_belongs_to_one_gate() {
        let interlock = Interlock::default();
        assert!(interlock.member(Side::A, 3).is_ok());
        assert!(interlock.member(Side::B, 3).is_ok());
        assert_eq!(interlock.member(Side::A, 3).err(), Some(NoPlace::Taken { place: 3 }));
        assert_eq!(interlock.member(Side::A, 255).err(), Some(NoPlace::Unknown { place: 255 }));
    }
}
