//! Tickets, keys, standings, scopes, and what validity functions look at.

use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::Effect;
use faregate_tickets::gate::{Admission, Gate};
use faregate_tickets::id::{GateId, HolderId, Priority, TicketId};
use faregate_tickets::interlock::{Interlock, Side};
use faregate_tickets::recorder::Unrecorded;
use faregate_tickets::scope::{Scope, Seen};
use faregate_tickets::standing::{Stamp, Standing, Why};
use faregate_tickets::telemetry::{Channel, Mode, Modes, Telemetry};
use faregate_tickets::ticket::{Holder, Issuer, Seat};
use faregate_tickets::validity::{Ask, Function, Validity};

use crate::bench::{Hands, Lamp, Switch, Truth, drawing, leak};
use crate::meter::Meter;
use crate::{Bounded, Silent};

/// Takes tickets back, and keeps no books.
struct Nobody;

impl Issuer for Nobody {
    fn relinquish(&self, _: &Seat<'_>, _: Unrecorded, _: Holder) {}
}

const PATIENCE: Duration = Duration::from_secs(9);
const ID: TicketId = TicketId { seat: 0, serial: 7 };

/// Everything public of the mechanism, its making included.
pub(crate) fn measure() {
    let mut meter = Meter::default();
    tickets_and_keys(&mut meter);
    standings(&mut meter);
    scopes(&mut meter);
    state_variables(&mut meter);
    validity(&mut meter);
    meter.assert_complete(
        &[
            "tickets/src/ticket.rs",
            "tickets/src/gate/key.rs",
            "tickets/src/standing.rs",
            "tickets/src/scope.rs",
            "tickets/src/interlock.rs",
            "tickets/src/telemetry.rs",
            "tickets/src/validity.rs",
        ],
        &[],
    );
}

fn tickets_and_keys(meter: &mut Meter) {
    let clock: &'static Hands = leak(Hands::default());
    let truth: &'static Truth = leak(Truth::default());
    let (agent, broker, standing) = (Scope::new(), Scope::new(), Standing::new());
    let mut gate = meter
        .op(&[], || Gate::<_, Silent>::new(Lamp::new(truth, drawing(5)), clock, Bounded::new()));
    let key = meter.op(&[], || gate.key());
    let (key, handle) = meter.op(&["key::split"], || key.split());
    standing.seat(ID.serial, 1);
    let seat =
        Seat { id: ID, gate: GateId(0), standing: &standing, agent: &agent, broker: &broker };
    let ticket = meter.op(&["key::ticket"], || key.ticket(handle, seat, &Nobody).unwrap());
    meter.op(&["key::profile"], || *key.profile());
    let admission = |tenure| Admission {
        serial: ID.serial,
        tenure,
        agent: agent.read().epoch,
        validity: Validity::from(Function::lease(Duration::from_secs(1))),
        stamp: Some((&standing, Stamp { own: standing.epoch_seen(), broker: broker.read().epoch })),
    };
    meter.op(&["key::admit"], || key.admit(admission(0), PATIENCE).unwrap());
    let ticket = meter.op(&["ticket::invoke"], || {
        ticket.invoke(Switch::On).unwrap();
        ticket
    });
    let ticket = meter.op(&["ticket::try_invoke"], || {
        ticket.try_invoke(Switch::Blink).unwrap();
        ticket
    });
    let ticket = meter.op(&["ticket::renew", "ticket::check"], || {
        ticket.renew().unwrap();
        ticket.check().unwrap();
        ticket
    });
    let ticket = meter.op(&["ticket::id", "ticket::is_of", "ticket::revocations"], || {
        assert_eq!(ticket.revocations(), ticket.revocations());
        assert!(ticket.id() == ID && ticket.is_of(&Nobody));
        ticket
    });
    meter.op(&["key::look_again", "key::ran_out"], || {
        assert!(key.look_again(clock.now()).is_some());
        assert_eq!(key.ran_out(ID.serial, PATIENCE), None);
    });
    let ticket = meter.op(&["ticket::revoke_all_but_me"], || {
        assert!(ticket.revoke_all_but_me(&broker, Priority::EMERGENCY));
        ticket
    });
    // Its driver faults, and it is refused from then on.
    let ticket = meter.op(&[], || {
        ticket.invoke(Switch::Fault).unwrap_err();
        ticket.invoke(Switch::On).unwrap_err();
        ticket
    });
    meter.op(&["key::fault", "key::reopen"], || {
        assert!(key.fault().is_some());
        key.reopen();
        assert_eq!(key.fault(), None);
    });
    meter.op(&["key::pass"], || key.pass(PATIENCE).unwrap());
    let vacated = meter.op(&["key::vacate"], || key.vacate(1, PATIENCE).unwrap());
    meter.op(&["key::safe"], || key.safe(vacated.tenure, 1, PATIENCE).unwrap());
    meter.op(&["key::seen_off"], || {
        key.seen_off(vacated.tenure, Instant::FAR_FUTURE, PATIENCE).unwrap();
    });
    meter.op(&["ticket::relinquish"], || {
        ticket.invoke(Switch::On).unwrap_err();
        ticket.relinquish();
    });
}

fn standings(meter: &mut Meter) {
    let standing = meter.op(&["standing::new"], Standing::new);
    meter.op(&["standing::seat", "standing::set_holder", "standing::set_agents"], || {
        standing.set_holder(HolderId(3));
        standing.seat(ID.serial, 1);
        standing.set_agents(2);
    });
    meter.op(&["standing::agents", "standing::occupant_of", "standing::is_occupied_by"], || {
        assert_eq!((standing.agents(), standing.occupant_of(HolderId(3))), (2, Some(ID.serial)));
        assert!(standing.is_occupied_by(ID.serial));
    });
    meter.op(&["standing::revoke"], || standing.revoke(Why::SupplyFell));
    meter.op(&["standing::explain_now", "standing::epoch_seen"], || {
        standing.explain_now(standing.epoch_seen(), Why::Resting);
    });
    meter.op(&["standing::bar", "standing::barred_serial", "standing::forget_bar"], || {
        standing.bar(ID.serial);
        assert_eq!(standing.barred_serial(), ID.serial);
        standing.forget_bar();
    });
    meter.op(&["standing::survives", "standing::end"], || {
        assert!(!standing.survives(ID.serial, 9));
        standing.end();
    });
}

fn scopes(meter: &mut Meter) {
    let scope = meter.op(&["scope::new"], Scope::new);
    meter.op(&["scope::revoke_all", "scope::note_bar", "scope::has_bars"], || {
        scope.revoke_all();
        scope.note_bar(1);
        assert!(scope.has_bars());
    });
    meter.op(&["scope::take_bars", "scope::is_empty", "scope::seats"], || {
        assert_eq!(scope.take_bars().seats(4).count(), 1);
        assert!(scope.take_bars().is_empty());
    });
    meter.op(&["scope::enter_safe_mode", "scope::floor", "scope::read", "scope::admits"], || {
        scope.enter_safe_mode(Priority::EMERGENCY);
        assert_eq!(scope.floor(), Some(Priority::EMERGENCY));
        let seen: Seen = scope.read();
        assert!(!seen.admits(Priority::SCIENCE));
    });
    meter.op(&["scope::leave_safe_mode"], || scope.leave_safe_mode());
}

fn state_variables(meter: &mut Meter) {
    let interlock = meter.op(&["interlock::new"], Interlock::new);
    meter.op(&["interlock::member", "interlock::may_be_on"], || {
        let member = interlock.member(Side::A, 0).unwrap();
        assert!(!member.may_be_on());
        interlock.member(Side::A, 0).unwrap_err();
    });
    let table = meter.op(&["telemetry::new"], Telemetry::new);
    meter.op(&["telemetry::set_mode", "telemetry::mode"], || {
        table.set_mode(Mode::new(3).unwrap());
        assert_eq!(Some(table.mode()), Mode::new(3));
    });
    meter.op(&["telemetry::publish", "telemetry::read"], || {
        let channel = Channel::new(1).unwrap();
        table.publish(channel, 5, Instant::START);
        assert!(table.read(channel, Instant::START).is_some());
    });
    meter.op(&["telemetry::and", "telemetry::contains"], || {
        let mode = Mode::new(1).unwrap();
        assert!(Modes::NONE.and(mode).contains(mode));
    });
}

fn validity(meter: &mut Meter) {
    let at = Instant::START;
    let on = Effect::on(crate::bench::watts(5));
    let ask = Ask { now: at, effect: on, telemetry: None };
    for function in functions() {
        let mut validity = meter
            .op(&["validity::always", "validity::all_of", "validity::and"], || {
                Validity::all_of(&[function]).and_then(|validity| validity.and(function)).unwrap()
            });
        meter.op(&["validity::admitted", "validity::check", "validity::commit"], || {
            validity.admitted(at);
            // Some of them refuse: there is no telemetry here.
            let _ = validity.check(&ask);
            validity.commit(&ask);
        });
        meter.op(&["validity::renew", "validity::look_again_at", "validity::ran_out"], || {
            validity.renew(at);
            (validity.look_again_at(at), validity.ran_out(Instant::FAR_FUTURE))
        });
        meter.op(
            &["validity::has_ended", "validity::confirmed_off", "validity::rests_until"],
            || {
                validity.confirmed_off(Instant::FAR_FUTURE);
                (validity.has_ended(at), validity.rests_until())
            },
        );
        meter
            .op(&["validity::energy_left", "validity::propellant_left", "validity::lease"], || {
                (validity.energy_left(), validity.propellant_left(), validity.lease())
            });
        meter.op(&["validity::has_interlock", "validity::is_unlimited"], || {
            (validity.has_interlock(), validity.is_unlimited())
        });
    }
}

/// Every function of the closed library.
fn functions() -> [Function; 13] {
    let (short, long) = (Duration::from_millis(1), Duration::from_secs(1));
    [
        Function::always(),
        Function::window(Instant::START, Instant::from_micros(9)),
        Function::time_limit(short),
        Function::lease(short),
        Function::invocations(2),
        Function::rate(2, long),
        Function::separation(short),
        Function::duty_cycle(short, long).unwrap(),
        Function::energy(faregate_tickets::amount::Microjoules::from_joules(1)),
        Function::propellant(faregate_tickets::amount::Milligrams::new(1)),
        Function::interlock(),
        Function::telemetry(Channel::new(0).unwrap(), 0..=5, long),
        Function::modes(Modes::NONE),
    ]
}
