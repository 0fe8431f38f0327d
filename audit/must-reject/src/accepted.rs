//! What must be accepted, so that the audit rejects for a reason.

use core::hint::black_box;
use core::sync::atomic::Ordering;

use crate::{INPUT, Port, input, output};

/// No loop, and both ways take the same instructions.
#[unsafe(no_mangle)]
pub extern "C" fn accept_straight() {
    output(input(0).wrapping_mul(input(1)) ^ input(2));
}

#[unsafe(no_mangle)]
pub extern "C" fn accept_straight_set_up(seed: u64) {
    INPUT[0].store(seed as u32, Ordering::Relaxed);
}

/// A loop of at most eight turns.
#[unsafe(no_mangle)]
pub extern "C" fn accept_loop() {
    output(count());
}

#[inline(never)]
fn count() -> u32 {
    let (mut at, mut found) = (0, 0);
    // How far each turn goes is in the data, or the loop would be taken apart.
    while let Some(input) = INPUT.get(at) {
        let value = input.load(Ordering::Relaxed);
        found += value & 1;
        at += 1 + (value as usize & 8);
    }
    found
}

/// A stack that is aligned at run time.
#[repr(align(64))]
struct Line([u32; 16]);

#[unsafe(no_mangle)]
pub extern "C" fn accept_aligned_stack() {
    let line = Line([input(0); 16]);
    output(black_box(&line).0[5]);
}

/// A call of what memory says, of which the row says why.
#[unsafe(no_mangle)]
pub extern "C" fn accept_port() {
    let ports: [&dyn Port; 2] = [&Plus(1), &Minus(1)];
    let port = black_box(ports[(input(0) & 1) as usize]);
    output(port.call() ^ 1);
}

struct Plus(u32);
struct Minus(u32);

impl Port for Plus {
    fn call(&self) -> u32 {
        input(2).wrapping_add(self.0)
    }
}

impl Port for Minus {
    fn call(&self) -> u32 {
        input(2).wrapping_sub(self.0)
    }
}
