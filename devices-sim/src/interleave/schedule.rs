//! Who runs next.

use crate::random::Dice;

/// How the interleaver picks among the bodies that could run.
///
/// All of them are deterministic: the same seed makes the same choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Schedule {
    /// Each body has its own processor: at a switch point the running body
    /// goes on with `stay` chances in 256, else anyone may run.
    Even {
        /// Chances in 256 to go on.
        stay: u8,
    },
    /// Bodies are ranked at random, the first that can run does, and at each
    /// switch point the running one drops to the last rank with `demote`
    /// chances in 256. Few demotions leave bodies behind for long stretches,
    /// which is what races of small depth need (after the probabilistic
    /// concurrency testing of Burckhardt et al., 2010).
    Ranked {
        /// Chances in 256 to drop to the last rank.
        demote: u8,
    },
    /// One processor: the most important body that can run does, and whoever
    /// stands in its way inherits its priority. Equals take turns at random.
    Priorities,
}

impl Schedule {
    /// A schedule for this seed: all kinds, from restless to sluggish.
    #[must_use]
    pub fn from_seed(seed: u64) -> Self {
        let mut dice = Dice::new(seed, 1);
        match dice.below(8) {
            0..=3 => Self::Even { stay: [0, 128, 192, 240][dice.index(4)] },
            4..=6 => Self::Ranked { demote: [2, 8, 32][dice.index(3)] },
            _ => Self::Priorities,
        }
    }
}
