//! Revoking, whoever does it, and what it takes back.

use faregate_tickets::id::{Priority, TicketId};
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::{Standing, Why};

use crate::entry;
use crate::ports::{Bare, Valve};
use crate::random::Random;
use crate::stage::Stage;
use crate::sys::Slot;

static SCOPE: Slot<Scope> = Slot::empty();
static STANDING: Slot<Standing> = Slot::empty();
static SEAT: Slot<u16> = Slot::empty();
static SERIAL: Slot<usize> = Slot::empty();
static WHY: Slot<Why> = Slot::empty();
static FLOOR: Slot<Priority> = Slot::empty();

fn alone(seed: u64) {
    let random = &mut Random::new(seed);
    SCOPE.fill(Scope::new());
    STANDING.fill(Standing::new());
    let serial = usize::try_from(random.next() >> 33).unwrap_or(1);
    SERIAL.fill(serial);
    SEAT.fill(u16::from_le_bytes([random.byte(), random.byte()]));
    let floor = Priority::new(random.byte());
    FLOOR.fill(floor);
    let by = TicketId { seat: u16::from(random.byte()), serial };
    let preempted = Why::Preempted { by, priority: floor };
    WHY.fill(random.pick([preempted, preempted, Why::SupplyFell, Why::Barred, Why::Unknown]));
}

fn barred(seed: u64) {
    alone(seed);
    if seed.is_multiple_of(2) {
        SCOPE.get().note_bar(*SEAT.get());
    }
}

entry!(standing_revoke, |seed| alone(seed), STANDING.get().revoke(*WHY.get()));
entry!(standing_bar, |seed| alone(seed), STANDING.get().bar(*SERIAL.get()));
entry!(scope_revoke_all, |seed| alone(seed), SCOPE.get().revoke_all());
entry!(scope_take_bars, |seed| barred(seed), SCOPE.get().take_bars());
entry!(scope_note_bar, |seed| alone(seed), SCOPE.get().note_bar(*SEAT.get()));
entry!(scope_enter_safe_mode, |seed| alone(seed), SCOPE.get().enter_safe_mode(*FLOOR.get()));
entry!(scope_leave_safe_mode, |seed| alone(seed), SCOPE.get().leave_safe_mode());

/// The same operations at brokers of different sizes.
macro_rules! at_broker {
    ($stage:ident, $set_up:ident, $size:literal, $gates:literal, $seats:literal, $sets:literal) => {
        static $stage: Stage<Valve, Bare, Bare, $gates, $seats, $sets> = Stage::new();

        pastey::paste! {
            entry!(
                [<bar_ $size>],
                |seed| $stage.$set_up(&mut Random::new(seed)),
                $stage.bar()
            );
            entry!(
                [<revoke_agent_ $size>],
                |seed| $stage.$set_up(&mut Random::new(seed)),
                $stage.enter_safe_mode($stage.of_agent.get())
            );
            entry!(
                [<revoke_all_ $size>],
                |seed| $stage.$set_up(&mut Random::new(seed)),
                $stage.enter_safe_mode($stage.supervisor.get())
            );
            entry!(
                [<revoke_all_but_me_ $size>],
                |seed| $stage.$set_up(&mut Random::new(seed)),
                $stage.revoke_all_but_me()
            );
        }
    };
}

at_broker!(FEW, valid, 4, 8, 4, 8);
at_broker!(MANY, requested, 256, 8, 256, 8);
at_broker!(MOST, requested, 60000, 8, 60_000, 8);

// Two gates granted together have one standing.
static SET: Stage<Valve, Bare, Bare, 2, 4, 1> = Stage::new();

entry!(bar_set, |seed| SET.set(&mut Random::new(seed)), SET.bar());
