//! Bad input and faults: each has a typed error or a stated outcome, and
//! nothing is lost by it.

mod bench;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering::SeqCst;

use bench::{Bare, Bench, Caught, Hands, Kit, Lamp, Platform, Switch, TICK, Tape};
use bench::{drawing, leak, margin, watts};
use faregate_agents::{
    Broker, Capacity, DeviceState, Handle, NotQuiescent, NotYours, Policy, RegisterError,
    RequestRefused, Waiting,
};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::fault::GateFault;
use faregate_tickets::gate::Blocked;
use faregate_tickets::id::{GateId, Priority, PriorityOutOfRange};
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::RecordedEvent;
use faregate_tickets::refusal::{InvokeError, Refusal};
use faregate_tickets::standing::Why;
use faregate_tickets::validity::{Function, Validity};

// Bad input

#[test]
fn a_handle_of_another_broker_is_an_unknown_gate() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let (elsewhere, _) = Bench::new(margin(10), &[8]);
    let broker = bench.broker;
    let foreign = elsewhere.lamps[0];
    let refused = broker.request(Priority::EMERGENCY, &foreign).unwrap_err();
    assert_eq!(refused, RequestRefused::UnknownGate);
    let [own, foreign] = [bench.lamps[0], foreign].map(|lamp| lamp.limited(Validity::always()));
    let refused = broker.request(Priority::EMERGENCY, &(own, foreign)).unwrap_err();
    assert_eq!(refused, RequestRefused::UnknownGate);
    let ticket = bench.ticket(1, 0);
    let foreign = elsewhere.lamps[0].limited(Validity::always());
    assert_eq!(broker.extend(&ticket, &foreign).unwrap_err(), RequestRefused::UnknownGate);
    assert_eq!(ticket.check(), Ok(()));
    assert_eq!(bench.free_seats(), 7);
}

#[test]
fn another_brokers_agent_gets_no_gate_and_no_supply_here() {
    let mut kit = Kit::new();
    let agent = kit.agent(margin(10));
    let foreign = Kit::new().agent(margin(10));
    let (gate, ..) = kit.gate(drawing(8));
    let key = leak::<faregate_tickets::Gate<'static, Lamp, Platform>>(gate).key();
    assert_eq!(kit.broker.register(foreign, key).err(), Some(RegisterError::UnknownAgent));
    let supervisor = kit.broker.supervisor();
    let refused = kit.broker.set_supply(&supervisor, foreign, watts(99));
    assert_eq!(refused, Err(NotYours::OtherScope));
    assert_eq!(kit.broker.margin(agent).unwrap().0, watts(10));
}

#[test]
fn an_unknown_gate_is_reported_on_and_observed_in_vain() {
    let (bench, supervisor) = Bench::new(margin(10), &[8]);
    let before = bench.broker.books();
    let nowhere = GateId(9);
    let estimate = Estimate { state: Power::Off, measured_at: bench.clock.now() };
    bench.broker.observe(nowhere, estimate);
    bench.broker.observe(GateId(255), estimate);
    assert_eq!(bench.broker.books(), before);
    assert_eq!(bench.broker.device(nowhere), None);
    let refused = bench.broker.reset_gate(&supervisor, nowhere).err();
    assert_eq!(refused, Some(NotYours::OtherScope));
}

#[test]
fn a_priority_out_of_range_is_a_typed_error() {
    for level in [-1, 256, i64::MIN, i64::MAX] {
        assert_eq!(Priority::try_from(level), Err(PriorityOutOfRange { level }));
    }
    assert_eq!(Priority::try_from(255), Ok(Priority::EMERGENCY));
}

#[test]
fn full_seats_refuse_and_a_ticket_given_back_makes_room() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let mut tickets: Vec<_> = (0..8).map(|_| bench.ticket(1, 0)).collect();
    let before = bench.broker.books();
    let full = RequestRefused::NoCapacity(Capacity::Seats);
    let refused = bench.broker.request(Priority::EMERGENCY, &bench.lamps[0]).unwrap_err();
    assert_eq!(refused, full);
    assert_eq!(bench.broker.books(), before);
    tickets.pop();
    assert!(bench.broker.request(Priority::EMERGENCY, &bench.lamps[0]).is_ok());
}

#[test]
fn a_broker_without_sets_refuses_sets() {
    let clock: &'static Hands = leak(Hands::default());
    let tape: &'static Tape = leak(Tape::default());
    let mut broker = Broker::<Platform, NoNotify, 2, 2, 0>::new(clock, tape, NoNotify);
    let agent = broker.agent(Policy::unlimited()).unwrap();
    let kit = Kit::new();
    let wants = [0, 1].map(|_| {
        let (gate, ..) = kit.gate(drawing(8));
        let gate: &'static mut faregate_tickets::Gate<'static, Lamp, Platform> = leak(gate);
        broker.register(agent, gate.key()).unwrap().limited(Validity::always())
    });
    let [a, b] = wants;
    let refused = broker.request(Priority::SCIENCE, &(a, b)).unwrap_err();
    assert_eq!(refused, RequestRefused::NoCapacity(Capacity::Sets));
}

#[test]
fn a_full_broker_registers_no_more() {
    let mut kit = Kit::new();
    let agent = kit.agent(margin(10));
    for _ in 0..4 {
        kit.lamp(agent, drawing(1));
    }
    let (gate, ..) = kit.gate(drawing(1));
    let key = leak::<faregate_tickets::Gate<'static, Lamp, Platform>>(gate).key();
    assert_eq!(kit.broker.register(agent, key).err(), Some(RegisterError::NoCapacity));
    for _ in 1..faregate_agents::limits::MAX_AGENTS {
        kit.agent(Policy::unlimited());
    }
    let refused = kit.broker.agent(Policy::unlimited());
    assert_eq!(refused, Err(RegisterError::NoCapacity));
}

#[test]
fn too_many_validity_functions_are_refused_the_lease_included() {
    let (bench, _) = Bench::new(margin(10), &[8, 0]);
    let four = [Function::separation(TICK); 4];
    let four = Validity::all_of(&four).unwrap();
    let refused =
        bench.broker.request(Priority::SCIENCE, &bench.lamps[0].limited(four)).unwrap_err();
    assert_eq!(refused, RequestRefused::NoCapacity(Capacity::ValidityFunctions));
    let without_draw = bench.lamps[1].limited(four);
    assert!(bench.broker.request(Priority::SCIENCE, &without_draw).is_ok(), "it needs no lease");
}

// Clocks and sensors

#[test]
fn a_clock_that_goes_backwards_gives_nothing_back_and_is_recorded() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    bench.clock.advance(Duration::from_secs(5));
    let limit = bench.lamps[0].limited(Function::time_limit(Duration::from_millis(20)));
    let ticket = bench.broker.request(Priority::SCIENCE, &limit).unwrap();
    bench.broker.service();
    ticket.invoke(Switch::On).unwrap();
    bench.clock.advance(Duration::from_millis(10));
    ticket.invoke(Switch::On).unwrap();
    bench.clock.go_back(Duration::from_secs(4));
    assert_eq!(ticket.invoke(Switch::Blink), Ok(()));
    assert!(bench.tapes[0].events().contains(&RecordedEvent::ClockWentBack));
    bench.broker.service();
    bench.clock.advance(Duration::from_secs(4));
    bench.clock.advance(Duration::from_millis(10));
    bench.broker.service();
    assert!(!bench.is_on(0));
    assert_eq!(ticket.check(), Err(Refusal::NotValid(Why::Expired)));
}

#[test]
fn a_stale_estimate_credits_nothing() {
    let (bench, _) = Bench::new(margin(10), &[8, 8]);
    let low = bench.ticket(1, 0);
    low.invoke(Switch::On).unwrap();
    bench.truths[0].deaf_to_safing.store(1, SeqCst);
    bench.clock.advance(TICK);
    let before_safing = bench.clock.now();
    let high = bench.ticket(9, 1);
    bench.clock.advance(TICK);
    for measured_at in [Instant::START, before_safing] {
        bench.report(0, Power::Off, measured_at);
        bench.broker.service();
        assert!(high.check().is_err(), "measured before the device was made safe");
        assert_eq!(bench.charged(), 8);
    }
    bench.pass(TICK);
    bench.pass(TICK);
    assert_eq!((high.check(), bench.truths[0].safed.load(SeqCst)), (Ok(()), 2));
}

#[test]
fn an_estimate_from_the_future_is_not_believed_and_blinds_nobody() {
    let (bench, _) = Bench::new(margin(10), &[8, 8]);
    let low = bench.ticket(1, 0);
    low.invoke(Switch::On).unwrap();
    bench.truths[0].deaf_to_safing.store(1, SeqCst);
    let high = bench.ticket(9, 1);
    bench.report(0, Power::Off, Instant::FAR_FUTURE);
    bench.broker.service();
    assert!(high.check().is_err());
    assert_eq!(bench.charged(), 8);
    bench.pass(TICK);
    bench.pass(TICK);
    assert_eq!(high.check(), Ok(()), "true measurements count as before");
}

#[test]
fn a_device_that_no_sensor_sees_off_stays_charged_and_is_reported_stuck() {
    let (bench, _) = Bench::new(margin(10), &[8, 8]);
    let low = bench.ticket(1, 0);
    low.invoke(Switch::On).unwrap();
    let high = bench.ticket(9, 1);
    for _ in 0..3 {
        bench.clock.advance(drawing(8).estimate_lag);
        bench.clock.advance(TICK);
        bench.broker.service();
    }
    let gate = bench.lamps[0].gate();
    assert!(bench.tape.events().contains(&RecordedEvent::Stuck { gate }));
    assert_eq!((bench.charged(), bench.truths[0].safed.load(SeqCst)), (8, 3));
    assert_eq!(bench.waits(high.id()), Some(Waiting::Margin { short_by: watts(6) }));
    assert_eq!(low.check(), Ok(()), "what was taken in vain is restored");
    // The sensors come back.
    bench.clock.advance(TICK);
    bench.measure(0);
    bench.broker.service();
    bench.pass(TICK);
    bench.pass(TICK);
    assert_eq!(high.check(), Ok(()));
}

// Drivers

#[test]
fn a_driver_that_faults_closes_its_gate_and_its_device_is_made_safe() {
    let (bench, _) = Bench::new(margin(10), &[8, 8]);
    let ticket = bench.ticket(5, 0);
    ticket.invoke(Switch::On).unwrap();
    assert_eq!(ticket.invoke(Switch::Fault), Err(InvokeError::Fault("blown")));
    let faulted = Some(Refusal::Faulted(GateFault::Driver));
    assert_eq!(ticket.invoke(Switch::On).unwrap_err().refusal(), faulted);
    bench.pass(TICK);
    assert!(!bench.is_on(0));
    assert_eq!(bench.charged(), 0);
    let other = bench.ticket(1, 1);
    assert_eq!(other.check(), Ok(()), "the rest goes on");
}

#[test]
fn a_contained_panic_in_a_command_is_an_answer_and_closes_the_gate() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(5, 0);
    ticket.invoke(Switch::On).unwrap();
    assert_eq!(ticket.invoke(Switch::Panic), Err(InvokeError::Panicked));
    assert_eq!(ticket.check(), Err(Refusal::Faulted(GateFault::Panicked)));
    bench.pass(TICK);
    assert!(!bench.is_on(0));
    assert_eq!(bench.charged(), 0);
}

#[test]
fn a_contained_panic_in_a_victims_safing_does_not_reach_the_rescuer() {
    let (bench, _) = Bench::new(margin(16), &[8, 8, 8]);
    let (first, second) = (bench.ticket(1, 0), bench.ticket(2, 1));
    first.invoke(Switch::On).unwrap();
    second.invoke(Switch::On).unwrap();
    bench.truths[0].panics_in_safing.store(true, SeqCst);
    let rescuer = bench.ticket(255, 2);
    for _ in 0..5 {
        bench.pass(TICK);
    }
    assert_eq!(rescuer.check(), Ok(()));
    assert_eq!(first.check(), Err(Refusal::Faulted(GateFault::Panicked)));
    assert!(second.check().is_err(), "the next victim was taken");
    assert_eq!(bench.charged(), 16);
    assert!(bench.is_on(0) && !bench.is_on(1));
}

#[test]
fn a_fault_in_a_victims_safing_takes_the_next_victim() {
    let (bench, _) = Bench::new(margin(16), &[8, 8, 8]);
    let (first, second) = (bench.ticket(1, 0), bench.ticket(2, 1));
    first.invoke(Switch::On).unwrap();
    second.invoke(Switch::On).unwrap();
    bench.truths[0].faults_in_safing.store(true, SeqCst);
    let rescuer = bench.ticket(255, 2);
    for _ in 0..5 {
        bench.pass(TICK);
    }
    assert_eq!((rescuer.check(), bench.charged()), (Ok(()), 16));
    assert!(first.check().is_err() && second.check().is_err());
}

/// A bench whose first lamp has nothing that contains its panics.
fn with_a_bare_lamp() -> (Bench, Handle<'static, Lamp, Bare>, &'static bench::Truth) {
    let mut kit = Kit::new();
    let agent = kit.agent(margin(10));
    let (gate, truth, tape) = kit.gate(drawing(8));
    let gate: &'static mut faregate_tickets::Gate<'static, Lamp, Bare> = leak(gate);
    let bare = kit.broker.register(agent, gate.key()).unwrap();
    kit.lamp(agent, drawing(8));
    kit.tapes.push(tape);
    let (bench, _) = kit.finish(agent);
    see_off(&bench, &bare);
    (bench, bare, truth)
}

fn see_off(bench: &Bench, bare: &Handle<'static, Lamp, Bare>) {
    bench.clock.advance(TICK);
    let measured_at = bench.clock.now();
    bench.broker.observe(bare.gate(), Estimate { state: Power::Off, measured_at });
    bench.broker.service();
}

#[test]
fn an_uncontained_panic_in_a_command_goes_on_and_leaves_a_faulted_gate() {
    let (bench, bare, truth) = with_a_bare_lamp();
    let ticket = bench.broker.request(Priority::SCIENCE, &bare).unwrap();
    bench.broker.service();
    ticket.invoke(Switch::On).unwrap();
    ticket.invoke(Switch::Burn).unwrap_err();
    let serial = ticket.id().serial;
    let thread = std::thread::spawn(move || ticket.invoke(Switch::Panic));
    assert!(thread.join().is_err(), "the panic went on");
    assert_eq!(bench.free_seats(), 8, "unwinding gave the ticket back");
    bench.broker.service();
    assert!(!truth.on.load(SeqCst), "its safing still passes");
    see_off(&bench, &bare);
    assert_eq!(bench.charged(), 0);
    let again = bench.broker.request(Priority::SCIENCE, &bare).unwrap();
    assert_eq!(again.check(), Err(Refusal::Faulted(GateFault::Panicked)));
    let code = Switch::Panic as u16;
    let issued = bench.tapes[1].events_of(serial);
    assert!(issued.contains(&RecordedEvent::Issued { code }), "the fatal command is on the tape");
    let refused = RecordedEvent::Refused { count: 1 };
    let tapes = [bench.tapes[1].events_of(serial), bench.tape.events_of(serial)];
    assert_eq!(tapes.concat().iter().filter(|event| **event == refused).count(), 1, "once");
}

#[test]
fn an_uncontained_panic_in_safing_is_tried_as_often_as_declared_and_no_more() {
    let (bench, bare, truth) = with_a_bare_lamp();
    let victim = bench.broker.request(Priority::SCIENCE, &bare).unwrap();
    bench.broker.service();
    victim.invoke(Switch::On).unwrap();
    truth.panics_in_safing.store(true, SeqCst);
    let rescuer = bench.broker.request(Priority::EMERGENCY, &bench.lamps[0]).unwrap();
    let mut panics = 0;
    for _ in 0..20 {
        let served = catch_unwind(AssertUnwindSafe(|| bench.broker.service()));
        panics += usize::from(served.is_err());
        bench.clock.advance(Duration::from_millis(101));
    }
    assert_eq!((panics, truth.safed.load(SeqCst)), (3, 3));
    let stuck = bench.broker.device(bare.gate()).unwrap();
    assert_eq!((stuck.state, stuck.fault), (DeviceState::Stuck, Some(GateFault::Panicked)));
    assert_eq!(bench.waits(rescuer.id()), Some(Waiting::Margin { short_by: watts(6) }));
}

#[test]
fn a_requester_that_dies_in_service_leaves_nothing_behind() {
    let (bench, bare, truth) = with_a_bare_lamp();
    let victim = bench.broker.request(Priority::SCIENCE, &bare).unwrap();
    bench.broker.service();
    victim.invoke(Switch::On).unwrap();
    truth.panics_in_safing.store(true, SeqCst);
    let (broker, lamp) = (bench.broker, bench.lamps[0]);
    let requester = std::thread::spawn(move || {
        let _ticket = broker.request(Priority::EMERGENCY, &lamp).unwrap();
        broker.service();
    });
    assert!(requester.join().is_err());
    assert_eq!(bench.free_seats(), 7);
    truth.panics_in_safing.store(false, SeqCst);
    bench.clock.advance(Duration::from_millis(101));
    bench.broker.service();
    // The attempt that panicked was one; the next one is due now.
    bench.broker.service();
    assert!(!truth.on.load(SeqCst));
    see_off(&bench, &bare);
    assert_eq!(bench.charged(), 0);
    let next = bench.ticket(1, 0);
    assert_eq!(next.check(), Ok(()));
}

#[test]
fn a_command_that_overruns_closes_its_gate() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(5, 0);
    bench.truths[0].hold.store(true, SeqCst);
    std::thread::scope(|threads| {
        threads.spawn(|| {
            bench.truths[0].wait_until_held();
            bench.clock.advance(Duration::from_micros(4_001));
            bench.truths[0].hold.store(false, SeqCst);
        });
        assert_eq!(ticket.invoke(Switch::On), Ok(()), "it was done all the same");
    });
    assert_eq!(ticket.check(), Err(Refusal::Faulted(GateFault::Overran)));
    bench.pass(TICK);
    assert!(!bench.is_on(0));
}

#[test]
fn a_command_that_does_not_come_back_keeps_its_charge_and_the_next_victim_is_taken() {
    let (bench, _) = Bench::new(margin(16), &[8, 8, 8]);
    let (hung, second) = (bench.ticket(1, 0), bench.ticket(2, 1));
    second.invoke(Switch::On).unwrap();
    let truth = bench.truths[0];
    truth.hold.store(true, SeqCst);
    let holder = std::thread::spawn(move || {
        let result = hung.invoke(Switch::On);
        (hung, result)
    });
    truth.wait_until_held();
    let rescuer = bench.ticket(255, 2);
    bench.pass(TICK);
    bench.pass(TICK);
    let gate = bench.lamps[0].gate();
    let report = bench.broker.device(gate).unwrap();
    assert_eq!((report.state, report.fault), (DeviceState::Stuck, Some(GateFault::Hung)));
    assert_eq!((rescuer.check(), bench.charged()), (Ok(()), 16));
    assert!(second.check().is_err());

    truth.hold.store(false, SeqCst);
    let (hung, result) = holder.join().unwrap();
    assert_eq!(result, Ok(()), "it had been admitted before");
    assert_eq!(hung.check(), Err(Refusal::Faulted(GateFault::Hung)));
    bench.clock.advance(Duration::from_millis(5));
    bench.pass(TICK);
    bench.pass(TICK);
    assert!(!bench.is_on(0), "when it came back it was made safe");
    assert_eq!(second.check(), Ok(()), "and the room it leaves goes to who waits");
}

#[test]
fn a_victims_safing_that_hangs_holds_up_who_performs_it_and_nobody_else() {
    let (bench, _) = Bench::new(margin(16), &[8, 8, 8]);
    let (first, second) = (bench.ticket(1, 0), bench.ticket(2, 1));
    first.invoke(Switch::On).unwrap();
    second.invoke(Switch::On).unwrap();
    let truth = bench.truths[0];
    truth.hangs_in_safing.store(true, SeqCst);
    truth.hold.store(true, SeqCst);
    let rescuer = bench.broker.request(Priority::EMERGENCY, &bench.lamps[2]).unwrap();
    let broker = bench.broker;
    let service = std::thread::spawn(move || broker.service());
    truth.wait_until_held();
    for _ in 0..3 {
        bench.pass(TICK);
    }
    let report = broker.device(bench.lamps[0].gate()).unwrap();
    assert_eq!((report.state, report.fault), (DeviceState::Stuck, Some(GateFault::Hung)));
    assert_eq!((rescuer.check(), bench.charged()), (Ok(()), 16), "the next victim was taken");
    assert!(second.check().is_err());
    truth.hold.store(false, SeqCst);
    service.join().unwrap();
}

#[test]
fn quiescence_has_a_deadline() {
    let (bench, supervisor) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(5, 0);
    let id = ticket.id();
    let truth = bench.truths[0];
    truth.hold.store(true, SeqCst);
    let holder = std::thread::spawn(move || ticket.invoke(Switch::On));
    truth.wait_until_held();
    let revoked = bench.broker.bar(&supervisor, id).unwrap();
    let hung = NotQuiescent { gate: bench.lamps[0].gate(), blocked: Blocked::Hung };
    assert_eq!(revoked.quiesce(), Err(hung));
    truth.hold.store(false, SeqCst);
    holder.join().unwrap().unwrap();
    bench.pass(TICK);
    assert!(!bench.is_on(0));
}

// The recorder

#[test]
fn a_full_lane_stops_nobody_and_counts_what_it_lost() {
    let (bench, _) = Bench::new(margin(10), &[8, 8]);
    bench.tape.room.store(0, SeqCst);
    bench.tapes[0].room.store(0, SeqCst);
    let low = bench.ticket(1, 0);
    low.invoke(Switch::On).unwrap();
    let high = bench.ticket(9, 1);
    bench.pass(TICK);
    assert_eq!(high.invoke(Switch::On), Ok(()));
    // Requested, granted; requested, revoked, seen off, granted.
    assert_eq!(bench.tape.lost.load(SeqCst), 6);
    // Admitted, issued, vacated, safed.
    assert_eq!(bench.tapes[0].lost.load(SeqCst), 4);
}

#[test]
fn the_last_seats_are_kept_for_fault_responses() {
    type Small = Broker<'static, Platform, NoNotify, 1, 32, 0>;
    let clock: &'static Hands = leak(Hands::default());
    let mut broker = Small::new(clock, leak(Tape::default()), NoNotify);
    let agent = broker.agent(margin(10)).unwrap();
    let (gate, ..) = Kit::new().gate::<Caught>(drawing(8));
    let lamp = broker.register(agent, leak(gate).key()).unwrap();
    let full = RequestRefused::NoCapacity(Capacity::Seats);
    let mut held: Vec<_> =
        (0..30).map(|_| broker.request(Priority::LEAST, &lamp).unwrap()).collect();
    assert_eq!(broker.request(Priority::new(239), &lamp).err(), Some(full));
    held.push(broker.request(Priority::FAULT_RESPONSE, &lamp).unwrap());
    held.push(broker.request(Priority::EMERGENCY, &lamp).unwrap());
    assert_eq!(broker.request(Priority::EMERGENCY, &lamp).err(), Some(full));
}

#[test]
fn a_gate_that_goes_to_another_broker_begins_anew() {
    let clock: &'static Hands = leak(Hands::default());
    let (mut gate, truth, _) = Kit::new().gate::<Caught>(drawing(8));
    {
        let mut first = Broker::<Platform, _, 1, 4, 0>::new(clock, leak(Tape::default()), NoNotify);
        let agent = first.agent(Policy::unlimited()).unwrap();
        let lamp = first.register(agent, gate.key()).unwrap();
        let ticket = first.request(Priority::SCIENCE, &lamp).unwrap();
        first.service();
        ticket.invoke(Switch::On).unwrap();
    }
    let mut second = Broker::<Platform, _, 1, 4, 0>::new(clock, leak(Tape::default()), NoNotify);
    let agent = second.agent(margin(10)).unwrap();
    let lamp = second.register(agent, gate.key()).unwrap();
    let report = second.device(lamp.gate()).unwrap();
    assert_eq!(report.charge, watts(8), "it was left on");
    let none = lamp.limited(Function::invocations(0));
    let ticket = second.request(Priority::SCIENCE, &none).unwrap();
    second.service();
    let refusal = ticket.invoke(Switch::On).unwrap_err().refusal();
    assert!(matches!(refusal, Some(Refusal::Denied(_))), "its own limits hold: {refusal:?}");
    assert!(truth.on.load(SeqCst));
}
