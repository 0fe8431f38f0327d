//! The steps of a hand-over at a gate, and what its key can tell.

use faregate_tickets::Gate;
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::gate::{Admission, Key};
use faregate_tickets::interlock::{Interlock, Side};
use faregate_tickets::standing::{Stamp, Standing};
use faregate_tickets::validity::{Function, Validity};

use crate::entry;
use crate::ports::{Bare, Bench, NOW, Ring, Valve, Word};
use crate::random::Random;
use crate::sys::{Known, Slot};

type Ported = Gate<'static, Valve, Bare<Ring>>;

static GATE: Slot<Ported> = Slot::empty();
static INTERLOCK: Slot<Interlock> = Slot::empty();
/// Whose key it is, is known when the core is compiled: a key reaches its gate
/// through a table of functions, and the audit is to see which.
static KEY: Known<Key<'static>> = Known::empty();
static STANDING: Slot<Standing> = Slot::empty();
static STEP: Slot<Step> = Slot::empty();

/// What a step is named by.
#[derive(Debug)]
struct Step {
    tenure: usize,
    attempt: u8,
    at: Instant,
    serial: usize,
    validity: Validity,
    stamp: Stamp,
}

const PATIENCE: Duration = Duration::from_millis(4);

/// A gate somewhere in a hand-over, and a step that it is due for, or that
/// comes too late.
fn set_up(seed: u64) {
    let random = &mut Random::new(seed);
    NOW.write(1_000_000 + random.below(1 << 40));
    let interlock: &'static Interlock = INTERLOCK.fill(Interlock::new());
    let member = interlock.member(Side::A, 0).expect("a place");
    let gate = Gate::new(Valve::NEW, Word, Ring::default());
    let gate = GATE.fill(gate.interlocked(member));
    let (key, _) = gate.key().split();
    let standing: &'static Standing = STANDING.fill(Standing::new());
    let serial = 1 + usize::from(random.byte());
    let step = Step {
        tenure: 0,
        attempt: 1,
        at: Instant::from_micros(NOW.read()),
        serial,
        validity: Validity::from(Function::lease(Duration::from_millis(1 + random.below(2_000)))),
        stamp: Stamp { own: standing.epoch_seen(), broker: 1 },
    };
    let step = STEP.fill(step);
    if random.flip() {
        let stamp = Some((standing, step.stamp));
        let Step { tenure, serial, validity, .. } = *step;
        let admission = Admission { serial, tenure, agent: 1, validity, stamp };
        step.tenure = key.admit(admission, PATIENCE).expect("nobody is there");
    }
    if random.below(4) == 0 {
        step.tenure += usize::from(random.byte() & 1) + 1;
    }
    NOW.write(NOW.read() + random.below(1 << 21));
    KEY.fill(key);
}

fn admission(step: &Step) -> Admission<'static> {
    let &Step { tenure, serial, validity, stamp, .. } = step;
    Admission { serial, tenure, agent: 1, validity, stamp: Some((STANDING.get(), stamp)) }
}

entry!(key_vacate, |seed| set_up(seed), KEY.get().vacate(STEP.get().tenure, PATIENCE));
entry!(
    key_safe,
    |seed| set_up(seed),
    KEY.get().safe(STEP.get().tenure, STEP.get().attempt, PATIENCE)
);
entry!(key_admit, |seed| set_up(seed), KEY.get().admit(admission(STEP.get()), PATIENCE));
entry!(
    key_seen_off,
    |seed| set_up(seed),
    KEY.get().seen_off(STEP.get().tenure, STEP.get().at, PATIENCE)
);
entry!(key_ran_out, |seed| set_up(seed), KEY.get().ran_out(STEP.get().serial, PATIENCE));
entry!(key_pass, |seed| set_up(seed), KEY.get().pass(PATIENCE));
entry!(key_reopen, |seed| set_up(seed), KEY.get().reopen());
