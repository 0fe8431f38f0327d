//! What no Rust says: single instructions.

use core::arch::asm;

use crate::{input, output};

macro_rules! instructions {
    ($($(#[$meta:meta])* $name:ident: $x86:expr, $thumb:expr;)+) => {$(
        $(#[$meta])*
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() {
            let mut value = input(0) as usize;
            // SAFETY: never executed: the audit only reads it.
            #[cfg(target_arch = "x86_64")]
            unsafe { asm!($x86, inout("rax") value, out("rcx") _, out("rdx") _, out("rdi") _) };
            // SAFETY: never executed: the audit only reads it.
            #[cfg(target_arch = "arm")]
            unsafe { asm!($thumb, inout("r0") value, out("r1") _) };
            output(value as u32);
        }
    )+};
}

instructions! {
    reject_system_call: "mov eax, 39\nsyscall", "svc 0";
    reject_trap: "ud2", "udf #0";
    reject_dynamic_stack: "sub rsp, rax", "sub sp, sp, r0";
    reject_growing_stack: "test eax, eax\njz 2f\npush rax\n2:\nnop", "cbz r0, 2f\npush {{r0}}\n2:\nnop";
    reject_two_entries: "test eax, eax\njz 3f\n2: dec eax\n3: dec ecx\njnz 2b",
        "cbz r0, 3f\n2: subs r0, #1\n3: subs r1, #1\nbne 2b";
    reject_waiting: "cpuid", "wfi";
    /// Only x86-64 has it.
    reject_repeat: "mov rdi, rsp\nmov ecx, eax\nrep stosb", "nop";
    accept_system_call: "mov eax, 39\nsyscall", "nop";
}

#[cfg(not(target_os = "none"))]
unsafe extern "C" {
    fn getppid() -> i32;
}

/// What another object has.
#[cfg(not(target_os = "none"))]
#[unsafe(no_mangle)]
pub extern "C" fn reject_outside() {
    // SAFETY: asks for a number.
    output(unsafe { getppid() } as u32);
}
