//! The cell behind loom's, which hands out pointers.
#![expect(unsafe_code, reason = "loom's cell hands out pointers")]

pub(super) fn read(of: *const u32) -> u32 {
    // SAFETY: of loom's cell, which checks that nobody writes meanwhile.
    unsafe { *of }
}

pub(super) fn write(of: *mut u32, attempt: u32) {
    // SAFETY: of loom's cell, which checks that nobody else looks meanwhile.
    unsafe { *of = attempt }
}
