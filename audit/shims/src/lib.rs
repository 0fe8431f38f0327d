//! Entries into the compiled core, one for each row of `audit/rows.toml`.
//!
//! An entry takes no argument and calls one operation of the core on state that
//! lies in statics. The optimiser sees the operation, and nothing of the state:
//! what it cannot know it cannot fold away, so that what is audited is the code
//! that a flight program would run. Beside each entry stands one that sets its
//! state up from a seed; those are run, and not audited.
//!
//! | module | the entries of |
//! |---|---|
//! | [`invoke`] | tickets: invocation, refusal, renewal, under each strategy |
//! | [`revoke`] | whoever revokes: agents, supervisors, holders |
//! | [`validity`] | the closed library of validity functions |
//! | [`roster`] | the lines before the gates |
//! | [`key`] | the steps of a hand-over at a gate |
//! | [`books`] | requests, and one step of a decision |
//! | [`state`] | state variables, and the recorder's lane |
// Without an operating system there is no std either. With one, std is there for
// the lanes of the runtime; no other entry reaches it.
#![cfg_attr(target_os = "none", no_std)]

pub mod books;
pub mod invoke;
pub mod key;
mod ports;
mod random;
pub mod revoke;
pub mod roster;
mod stage;
pub mod state;
mod sys;
pub mod validity;

/// An entry, and the one that sets its state up.
///
/// What the operation answers is kept from being thrown away: a caller would
/// look at it.
macro_rules! entry {
    ($name:ident, |$seed:ident| $set_up:expr, $operation:expr) => {
        pastey::paste! {
            #[expect(unsafe_code, reason = "the audit finds its entries by their names")]
            const _: () = {
                // SAFETY: no other symbol begins with `audit_`.
                #[unsafe(no_mangle)]
                #[inline(never)]
                extern "C" fn [<audit_ $name>]() {
                    let _ = core::hint::black_box($operation);
                }

                // SAFETY: no other symbol begins with `audit_`.
                #[unsafe(no_mangle)]
                #[inline(never)]
                extern "C" fn [<audit_ $name _set_up>]($seed: u64) {
                    $set_up;
                }
            };
        }
    };
}
use entry;
