//! The section on x86-64.

use core::arch::asm;
use core::sync::atomic::AtomicU32;

use super::super::super::{Outcome, Watch};

/// Compares and stores; see the module above.
///
/// On x86-64 loads are not reordered with loads, nor stores with stores, so
/// the store is a release of what its holder did before it.
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
    // what they point to is only ever accessed atomically; aligned moves are
    // atomic. The `rseq` area is this thread's own, by this function's contract.
    // The descriptor is static. At the abort address no register but those
    // named here is assumed to hold anything, and nothing was pushed.
    unsafe {
        asm!(
            ".pushsection __rseq_cs, \"aw\", @progbits",
            ".balign 32",
            "77:",
            ".long 0, 0",
            ".quad 22f, (44f - 22f), 66f",
            ".popsection",
            "lea {at}, [rip + 77b]",
            "mov qword ptr fs:[{area} + 8], {at}",
            "22:",
            "cmp qword ptr [{open}], {open_to}",
            "jne {refused}",
            "cmp qword ptr [{own}], {own_seen}",
            "jne {refused}",
            "cmp qword ptr [{agent}], {agent_seen}",
            "jne {refused}",
            "cmp qword ptr [{broker}], {broker_seen}",
            "jne {refused}",
            "mov dword ptr [{register}], {word:e}",
            "44:",
            ".pushsection .text.rseq_abort, \"ax\", @progbits",
            // An instruction that is none, with the signature as its operand.
            ".byte 0x0f, 0xb9, 0x3d",
            ".long 0x53053053",
            "66:",
            "jmp {restarted}",
            ".popsection",
            at = out(reg) _,
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
