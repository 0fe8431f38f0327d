//! What holders do with their tickets.

use faregate_tickets::validity::{Function, Validity};

use crate::entry;
use crate::ports::{
    Adapted, Answering, Bare, Latch, OneFence, OwnSections, Refusing, Ring, ShortWay, Valve,
};
use crate::random::Random;
use crate::stage::Stage;

static MASKED: Stage<Valve, Bare> = Stage::new();
static ADAPTED: Stage<Valve, Adapted> = Stage::new();
static RECORDED: Stage<Valve, Bare<Ring>> = Stage::new();
static ANSWERING: Stage<Answering, Bare<Ring>> = Stage::new();
static UNDISTURBED: Stage<Latch, OwnSections> = Stage::new();
static SHORT_WAY: Stage<Valve, ShortWay> = Stage::new();
static FENCED: Stage<Valve, OneFence> = Stage::new();

entry!(invoke_masked, |seed| MASKED.any(seed), MASKED.invoke());
entry!(try_invoke_masked, |seed| MASKED.any(seed), MASKED.try_invoke());
entry!(renew_masked, |seed| MASKED.any(seed), MASKED.ticket().renew());
entry!(check, |seed| MASKED.any(seed), MASKED.ticket().check());
entry!(invoke_locked, |seed| ADAPTED.any(seed), ADAPTED.invoke());
entry!(try_invoke_locked, |seed| ADAPTED.any(seed), ADAPTED.try_invoke());
entry!(renew_locked, |seed| ADAPTED.any(seed), ADAPTED.ticket().renew());
entry!(invoke_undisturbed, |seed| UNDISTURBED.at_home(seed), UNDISTURBED.invoke());
entry!(invoke_fenced_short, |seed| SHORT_WAY.at_home(seed), SHORT_WAY.invoke());
entry!(renew_fenced_short, |seed| SHORT_WAY.at_home(seed), SHORT_WAY.ticket().renew());
entry!(invoke_fenced, |seed| FENCED.any(seed), FENCED.invoke());
entry!(invoke_recorded, |seed| RECORDED.any(seed), RECORDED.invoke());
entry!(invoke_answering, |seed| ANSWERING.any(seed), ANSWERING.invoke());

#[cfg(target_os = "linux")]
mod pi {
    use super::*;
    use crate::ports::{OneStore, Pi, StoreOrLock};

    static PI: Stage<Valve, Pi> = Stage::new();
    static PI_RECORDED: Stage<Valve, Pi<Ring>> = Stage::new();

    static SECTION: Stage<Latch, OneStore> = Stage::new();
    static RESTARTABLE: Stage<Latch, StoreOrLock> = Stage::new();

    entry!(invoke_restartable_short, |seed| SECTION.at_home(seed), SECTION.invoke());
    entry!(invoke_restartable, |seed| RESTARTABLE.any(seed), RESTARTABLE.invoke());
    entry!(invoke_pi, |seed| PI.any(seed), PI.invoke());
    entry!(try_invoke_pi, |seed| PI.any(seed), PI.try_invoke());
    entry!(renew_pi, |seed| PI.any(seed), PI.ticket().renew());
    entry!(invoke_pi_recorded, |seed| PI_RECORDED.any(seed), PI_RECORDED.invoke());
}

// Refused before the lock, for each reason. No holder enters these gates, so
// the longest path is that of a refusal.
static REFUSING: Stage<Valve, Refusing> = Stage::new();
static FAULTED: Stage<Answering, Refusing> = Stage::new();

entry!(refused_waiting, |seed| REFUSING.waiting(&mut Random::new(seed)), REFUSING.invoke());
entry!(refused_barred, |seed| REFUSING.barred(&mut Random::new(seed)), REFUSING.invoke());
entry!(refused_agent, |seed| REFUSING.agent_revoked(&mut Random::new(seed)), REFUSING.invoke());
entry!(refused_all, |seed| REFUSING.all_revoked(&mut Random::new(seed)), REFUSING.invoke());
entry!(refused_faulted, |seed| FAULTED.faulted(&mut Random::new(seed)), FAULTED.invoke());

// Beside an interlock, which is the one condition that writes.
mod interlocked {
    use faregate_tickets::interlock::{Interlock, Side};

    use super::*;
    use crate::ports::Setting;
    use crate::sys::Slot;

    static INTERLOCK: Slot<Interlock> = Slot::empty();
    static STAGE: Stage<Valve, Bare> = Stage::new();

    fn set_up(seed: u64) {
        let random = &mut Random::new(seed);
        let interlock: &'static Interlock = INTERLOCK.fill(Interlock::new());
        let own = interlock.member(Side::A, 3).expect("a place");
        STAGE.interlocked(random, own, Validity::from(Function::interlock()));
        if random.flip() {
            // What a gate of the other side says of itself when it is made.
            STAGE.beside(interlock.member(Side::B, 3).expect("a place"));
        }
        STAGE.command.fill(random.pick([Setting::On, Setting::On, Setting::Off]));
    }

    entry!(invoke_interlocked, |seed| set_up(seed), STAGE.invoke());
}
