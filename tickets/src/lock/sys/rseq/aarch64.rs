//! The section on aarch64.

use core::arch::asm;
use core::sync::atomic::AtomicU32;

use super::super::super::{Outcome, Watch};

/// Compares and stores; see the module above.
///
/// The store is a release of what its holder did before it. The loads need no
/// order: a section that `end_all` does not find in progress compares after it.
///
/// # Safety
/// The calling thread's `rseq` area is at `offset` from its thread pointer.
#[inline(always)]
pub(super) unsafe fn section(
    watch: &Watch<'_>,
    register: &AtomicU32,
    word: u32,
    offset: isize,
) -> Outcome {
    let [open, own, agent, broker] = watch.words;
    let [open_to, own_seen, agent_seen, broker_seen] = watch.values;
    // SAFETY: all pointers come from references that outlive the section, and
    // what they point to is only ever accessed atomically; aligned loads and
    // stores are atomic. The `rseq` area is this thread's own, by this function's
    // contract. The descriptor is static. At the abort address no register but
    // those named here is assumed to hold anything, and nothing was pushed.
    unsafe {
        asm!(
            ".pushsection __rseq_cs, \"aw\", %progbits",
            ".balign 32",
            "77:",
            ".long 0, 0",
            ".quad 22f, (44f - 22f), 66f",
            ".popsection",
            "adrp {at}, 77b",
            "add {at}, {at}, :lo12:77b",
            "mrs {seen}, tpidr_el0",
            "add {seen}, {seen}, {area}",
            "str {at}, [{seen}, #8]",
            "22:",
            "ldr {seen}, [{open}]",
            "cmp {seen}, {open_to}",
            "b.ne {refused}",
            "ldr {seen}, [{own}]",
            "cmp {seen}, {own_seen}",
            "b.ne {refused}",
            "ldr {seen}, [{agent}]",
            "cmp {seen}, {agent_seen}",
            "b.ne {refused}",
            "ldr {seen}, [{broker}]",
            "cmp {seen}, {broker_seen}",
            "b.ne {refused}",
            "stlr {word:w}, [{register}]",
            "44:",
            "b 88f",
            // The signature is a `brk` that nobody meets.
            ".inst 0xd428bc00",
            "66:",
            "b {restarted}",
            "88:",
            at = out(reg) _,
            seen = out(reg) _,
            area = in(reg) offset,
            open = in(reg) open.as_ptr(),
            own = in(reg) own.as_ptr(),
            agent = in(reg) agent.as_ptr(),
            broker = in(reg) broker.as_ptr(),
            register = in(reg) register.as_ptr(),
            open_to = in(reg) open_to,
            own_seen = in(reg) own_seen,
            agent_seen = in(reg) agent_seen,
            broker_seen = in(reg) broker_seen,
            word = in(reg) word,
            refused = label { return Outcome::Refused },
            restarted = label { return Outcome::Restarted },
            options(nostack),
        );
    }
    Outcome::Stored
}
