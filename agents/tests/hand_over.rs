//! The hand-over, step by step, on a clock that the test moves.

mod bench;

use bench::{Bench, Switch};
use faregate_agents::{Policy, RequestRefused, Waiting};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Duration;
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;

const TICK: Duration = Duration::from_millis(1);

fn margin(watts: u32) -> Policy {
    Policy::power_margin(Milliwatts::from_watts(watts))
}

#[test]
fn a_ticket_is_valid_after_service_and_commands_its_device() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let ticket = bench.broker.request(Priority::SCIENCE, &bench.lamps[0]).unwrap();
    assert_eq!(ticket.check(), Err(Refusal::NotValid(Why::NotYetGranted)));
    bench.broker.service();
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
    assert!(bench.is_on(0));
    assert_eq!(bench.charged(), 8);
}

#[test]
fn the_emergency_takes_the_margin_and_gives_it_back() {
    let (bench, _) = Bench::new(margin(10), &[8, 7]);
    let (camera, cutoff) = (&bench.lamps[0], &bench.lamps[1]);
    let monitor = bench.broker.request(Priority::SCIENCE, camera).unwrap();
    bench.broker.service();
    monitor.invoke(Switch::On).unwrap();

    let emergency = bench.broker.request(Priority::EMERGENCY, cutoff).unwrap();
    let taken = Why::Preempted { by: emergency.id(), priority: Priority::EMERGENCY };
    assert_eq!(monitor.invoke(Switch::On).unwrap_err().refusal(), Some(Refusal::NotValid(taken)));
    assert!(emergency.check().is_err(), "nothing is credited before it is seen off");
    bench.broker.service();
    assert!(!bench.is_on(0), "the victim was made safe");
    assert!(emergency.check().is_err(), "making safe is not seeing off");
    assert_eq!(bench.charged(), 8);

    bench.pass(TICK);
    assert_eq!(emergency.invoke(Switch::On), Ok(()));
    assert_eq!(bench.charged(), 7);
    let waiting = bench.broker.waiting_for(monitor.id());
    assert_eq!(waiting, Some(Waiting::Margin { short_by: Milliwatts::from_watts(5) }));

    emergency.invoke(Switch::Off).unwrap();
    drop(emergency);
    bench.pass(TICK);
    bench.pass(TICK);
    assert_eq!(monitor.invoke(Switch::On), Ok(()), "restored without asking");
}

#[test]
fn a_device_that_does_not_go_off_is_stuck_and_the_next_victim_is_taken() {
    let (bench, _) = Bench::new(margin(16), &[8, 7, 8]);
    let first = bench.broker.request(Priority::new(1), &bench.lamps[0]).unwrap();
    let second = bench.broker.request(Priority::new(2), &bench.lamps[1]).unwrap();
    bench.broker.service();
    first.invoke(Switch::On).unwrap();
    second.invoke(Switch::On).unwrap();
    bench.truths[0].deaf_to_safing.store(99, std::sync::atomic::Ordering::SeqCst);

    let rescuer = bench.broker.request(Priority::EMERGENCY, &bench.lamps[2]).unwrap();
    for _ in 0..3 {
        assert!(second.check().is_ok(), "one victim suffices, so far");
        bench.pass(TICK);
    }
    assert!(second.check().is_err());
    bench.pass(TICK);
    assert_eq!(rescuer.invoke(Switch::On), Ok(()));
    assert_eq!(bench.charged(), 16, "the stuck one stays charged");
}

#[test]
fn what_can_never_be_is_refused_at_once_and_nothing_is_lost() {
    let (bench, _) = Bench::new(margin(10), &[8, 7, 11]);
    let before = bench.broker.books();
    let refused = bench.broker.request(Priority::EMERGENCY, &bench.lamps[2]).unwrap_err();
    let (draw, supply) = (Milliwatts::from_watts(11), Milliwatts::from_watts(10));
    assert_eq!(refused, RequestRefused::OverSupply { draw, supply });
    let both = (
        bench.lamps[0].limited(faregate_tickets::validity::Validity::always()),
        bench.lamps[1].limited(faregate_tickets::validity::Validity::always()),
    );
    let refused = bench.broker.request(Priority::EMERGENCY, &both).unwrap_err();
    let draw = Milliwatts::from_watts(15);
    assert_eq!(refused, RequestRefused::OverSupply { draw, supply });
    assert_eq!(bench.broker.books(), before);
}

#[test]
fn service_at_some_gates_does_nothing_at_others() {
    let (bench, _) = Bench::new(margin(20), &[8, 8]);
    let tickets = [0, 1].map(|lamp| {
        bench.broker.request(faregate_tickets::id::Priority::SCIENCE, &bench.lamps[lamp]).unwrap()
    });
    let valid = || tickets.each_ref().map(|ticket| ticket.check().is_ok());
    bench.broker.service_at([]);
    assert_eq!(valid(), [false, false]);
    bench.broker.service_at([bench.lamps[1].gate()]);
    assert_eq!(valid(), [false, true]);
    bench.broker.service();
    assert_eq!(valid(), [true, true]);
}

#[test]
fn a_revocation_is_counted_though_the_ticket_is_valid_again() {
    let (bench, _) = Bench::new(margin(20), &[8, 8]);
    let ticket = bench.ticket(5, 0);
    let before = ticket.revocations();
    let other = bench.ticket(9, 1);
    assert_eq!(ticket.revocations(), before, "nobody took it");
    drop(bench.ticket(9, 0));
    bench.broker.service();
    assert!(ticket.check().is_ok() && other.check().is_ok());
    assert_ne!(ticket.revocations(), before);
}
