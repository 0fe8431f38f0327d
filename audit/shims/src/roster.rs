//! The lines before the gates.

use faregate_agents::measure::Lines;
use faregate_tickets::id::Priority;

use crate::entry;
use crate::random::Random;
use crate::sys::Slot;

/// Who stands in line, and who is to join or to leave.
#[derive(Clone, Copy, Debug)]
struct Seat {
    gate: usize,
    priority: Priority,
    number: u16,
}

/// A few seats at few levels, so that lines are empty, of one, and longer.
fn set_up<const G: usize, const T: usize>(
    lines: &'static Slot<Lines<G, T>>,
    joins: &'static Slot<Seat>,
    leaves: &'static Slot<Seat>,
    seed: u64,
) {
    let random = &mut Random::new(seed);
    let lines = lines.fill(Lines::new());
    let mut seat = |number| Seat {
        gate: usize::from(random.byte()) % G,
        priority: Priority::new(random.pick([0, 63, 64, 130, 255])),
        number,
    };
    let present = 1 + (seed % (T as u64 - 2)) as u16;
    for number in 0..present {
        let Seat { gate, priority, .. } = *leaves.fill(seat(number));
        lines.join(gate, priority, number);
    }
    joins.fill(seat(present));
}

macro_rules! lines {
    ($size:literal, $gates:literal, $seats:literal) => {
        pastey::paste! {
            static [<LINES_ $size>]: Slot<Lines<$gates, $seats>> = Slot::empty();
            static [<JOINS_ $size>]: Slot<Seat> = Slot::empty();
            static [<LEAVES_ $size>]: Slot<Seat> = Slot::empty();

            fn [<fill_ $size>](seed: u64) {
                set_up(&[<LINES_ $size>], &[<JOINS_ $size>], &[<LEAVES_ $size>], seed);
            }

            fn [<join_ $size>]() {
                let Seat { gate, priority, number } = *[<JOINS_ $size>].get();
                [<LINES_ $size>].get_mut().join(gate, priority, number);
            }

            fn [<leave_ $size>]() {
                let Seat { gate, priority, number } = *[<LEAVES_ $size>].get();
                [<LINES_ $size>].get_mut().leave(gate, priority, number);
            }

            entry!([<roster_join_ $size>], |seed| [<fill_ $size>](seed), [<join_ $size>]());
            entry!([<roster_leave_ $size>], |seed| [<fill_ $size>](seed), [<leave_ $size>]());
            entry!(
                [<roster_first_ $size>],
                |seed| [<fill_ $size>](seed),
                [<LINES_ $size>].get().first([<JOINS_ $size>].get().gate)
            );
        }
    };
}

lines!(1000, 8, 1_000);
lines!(60000, 8, 60_000);
