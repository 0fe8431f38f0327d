//! The closed library of validity functions.
//!
//! What the functions of a ticket are is known at run time alone, so the
//! longest path of each operation is that of the four most expensive ones,
//! whichever a ticket has. The compositions differ in what a step finds.

use faregate_tickets::amount::{Microjoules, Milligrams, MilligramsPerSecond};
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::Effect;
use faregate_tickets::telemetry::{Channel, Mode, Modes, Telemetry};
use faregate_tickets::validity::{Ask, Function, Validity};

use crate::entry;
use crate::ports::DRAW;
use crate::random::Random;
use crate::sys::Slot;

static VALIDITY: Slot<Validity> = Slot::empty();
static TELEMETRY: Slot<Telemetry> = Slot::empty();
static ASK: Slot<Ask<'static>> = Slot::empty();
static NOW: Slot<Instant> = Slot::empty();

/// One of each.
const KINDS: [fn(&mut Random) -> Function; 12] = [
    |random| {
        let from = Instant::from_micros(random.below(2_000));
        Function::window(from, from.after(within(random)))
    },
    |random| Function::time_limit(within(random)),
    |random| Function::lease(within(random)),
    |random| Function::invocations(u32::from(random.byte() & 3)),
    |random| Function::rate(u32::from(random.byte() & 3), within(random)),
    |random| Function::separation(within(random)),
    |random| {
        let on = Duration::from_micros(1 + random.below(500));
        Function::duty_cycle(on, on.saturating_mul(3)).expect("on for a part of the time")
    },
    |random| Function::energy(Microjoules::new(random.below(20_000))),
    |random| Function::propellant(Milligrams::new(random.below(20))),
    |_| Function::interlock(),
    |random| {
        let channel = Channel::new(random.byte() & 1).expect("a channel");
        Function::telemetry(channel, 0..=i32::from(random.byte()), within(random))
    },
    |random| Function::modes(Modes::from(mode(random))),
];

fn within(random: &mut Random) -> Duration {
    Duration::from_micros(random.below(4_000))
}

fn mode(random: &mut Random) -> Mode {
    Mode::new(random.byte() & 1).expect("a mode")
}

fn effect(random: &mut Random) -> Effect {
    let on = Effect::On { draw: DRAW, flow: MilligramsPerSecond::new(random.below(9_000)) };
    random.pick([on, on, Effect::Unchanged, Effect::Off])
}

/// These functions, after a few commands.
fn used(random: &mut Random, functions: &[Function]) {
    let validity = VALIDITY.fill(Validity::all_of(functions).expect("at most four"));
    let telemetry: &'static Telemetry = TELEMETRY.fill(Telemetry::new());
    telemetry.set_mode(mode(random));
    let mut now = Instant::from_micros(random.below(1_000));
    if random.flip() {
        telemetry.publish(Channel::new(0).expect("a channel"), i32::from(random.byte()), now);
    }
    validity.admitted(now);
    for _ in 0..random.below(5) {
        now = now.after(Duration::from_micros(random.below(1_000)));
        let ask = Ask { now, effect: effect(random), telemetry: Some(telemetry) };
        match random.below(4) {
            0 => validity.confirmed_off(now),
            _ => validity.commit(&ask),
        }
    }
    now = now.after(Duration::from_micros(random.below(2_000)));
    NOW.fill(now);
    ASK.fill(Ask { now, effect: effect(random), telemetry: Some(telemetry) });
}

/// Up to four, whichever.
fn any(seed: u64) {
    let random = &mut Random::new(seed);
    let mut one = || random.pick(KINDS)(random);
    let functions = [one(), one(), one(), one()];
    let most = usize::try_from(1 + random.below(4)).unwrap_or(1);
    used(random, &functions[..most]);
}

entry!(validity_check, |seed| any(seed), VALIDITY.get().check(ASK.get()));
entry!(validity_commit, |seed| any(seed), VALIDITY.get_mut().commit(ASK.get()));
entry!(validity_ran_out, |seed| any(seed), VALIDITY.get().ran_out(*NOW.get()));
entry!(validity_has_ended, |seed| any(seed), VALIDITY.get().has_ended(*NOW.get()));
entry!(validity_look_again_at, |seed| any(seed), VALIDITY.get().look_again_at(*NOW.get()));
entry!(validity_renew, |seed| any(seed), VALIDITY.get_mut().renew(*NOW.get()));
entry!(validity_admitted, |seed| any(seed), VALIDITY.get_mut().admitted(*NOW.get()));
entry!(validity_confirmed_off, |seed| any(seed), VALIDITY.get_mut().confirmed_off(*NOW.get()));

/// What an invocation asks of a validity function: to agree, to count, and to
/// say when to look again.
fn whole() -> bool {
    let (validity, ask) = (VALIDITY.get_mut(), ASK.get());
    let agreed = validity.check(ask).is_ok();
    if agreed {
        validity.commit(ask);
    }
    agreed && validity.look_again_at(ask.now).is_some()
}

macro_rules! composition {
    ($name:ident, $($kind:literal),+) => {
        entry!(
            $name,
            |seed| {
                let random = &mut Random::new(seed);
                let functions = [$(KINDS[$kind](random)),+];
                used(random, &functions);
            },
            whole()
        );
    };
}

composition!(all_of_window, 0);
composition!(all_of_time_limit, 1);
composition!(all_of_lease, 2);
composition!(all_of_invocations, 3);
composition!(all_of_rate, 4);
composition!(all_of_separation, 5);
composition!(all_of_duty_cycle, 6);
composition!(all_of_energy, 7);
composition!(all_of_propellant, 8);
composition!(all_of_telemetry, 10);
composition!(all_of_modes, 11);
composition!(all_of_window_lease, 0, 2);
composition!(all_of_energy_duty_cycle_lease, 7, 6, 2);
composition!(all_of_the_most_expensive, 6, 6, 8, 8);
