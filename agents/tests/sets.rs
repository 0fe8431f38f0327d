//! Sets: several gates, of one agent or of several, granted all or nothing.

mod bench;

use std::sync::atomic::Ordering::SeqCst;

use bench::{Bench, Kit, Switch, TICK, drawing, margin, watts};
use faregate_agents::{Capacity, Policy, RequestRefused, Waiting};
use faregate_tickets::clock::Duration;
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use faregate_tickets::validity::{Function, Rule, Validity};

type Two = (bench::Ticket, bench::Ticket);

fn pair(bench: &Bench, level: u8, lamps: [usize; 2]) -> Result<Two, RequestRefused> {
    let [a, b] = lamps.map(|lamp| bench.lamps[lamp].limited(Validity::always()));
    bench.broker.request(Priority::new(level), &(a, b))
}

fn granted(bench: &Bench, level: u8, lamps: [usize; 2]) -> Two {
    let tickets = pair(bench, level, lamps).unwrap();
    bench.broker.service();
    tickets
}

fn both(tickets: &Two) -> [bool; 2] {
    [tickets.0.check().is_ok(), tickets.1.check().is_ok()]
}

#[test]
fn a_set_takes_all_its_gates_or_none() {
    let (bench, _) = Bench::new(margin(14), &[6, 8, 6]);
    let holder = bench.ticket(9, 1);
    let set = granted(&bench, 5, [0, 1]);
    assert_eq!(both(&set), [false, false]);
    let gate = bench.lamps[1].gate();
    assert_eq!(bench.waits(set.0.id()), Some(Waiting::Gate { gate, by: holder.id() }));
    let less = bench.ticket(1, 0);
    assert_eq!(less.check(), Ok(()), "what the set cannot use is nobody's");

    drop(holder);
    bench.pass(TICK);
    assert_eq!(both(&set), [true, true]);
    let priority = Priority::new(5);
    let taken = Why::Preempted { by: set.0.id(), priority };
    assert_eq!(less.check(), Err(Refusal::NotValid(taken)));
}

#[test]
fn a_set_that_loses_one_gate_loses_all_with_one_revocation() {
    let (bench, _) = Bench::new(margin(30), &[8, 8]);
    let set = granted(&bench, 5, [0, 1]);
    let high = bench.ticket(9, 1);
    let taken = Why::Preempted { by: high.id(), priority: Priority::new(9) };
    assert_eq!(set.0.check(), Err(Refusal::NotValid(taken)));
    assert_eq!(set.1.check(), Err(Refusal::NotValid(taken)));
    drop(high);
    bench.pass(TICK);
    assert_eq!(both(&set), [true, true]);
}

fn two_agents() -> (Bench, faregate_agents::AgentId, faregate_agents::Supervisor) {
    let mut kit = Kit::new();
    let (power, heat) = (kit.agent(margin(10)), kit.agent(margin(10)));
    kit.lamp(power, drawing(8));
    kit.lamp(heat, drawing(8));
    kit.lamp(heat, drawing(8));
    let other = kit.broker.supervisor_of(power).unwrap();
    let (bench, _) = kit.finish(power);
    (bench, heat, other)
}

#[test]
fn a_set_over_two_agents_takes_from_neither_before_it_fits_at_both() {
    let (bench, ..) = two_agents();
    let first = bench.ticket(1, 0);
    let blocker = bench.ticket(9, 2);
    let set = granted(&bench, 5, [0, 1]);
    assert_eq!(bench.waits(set.0.id()), Some(Waiting::Margin { short_by: watts(6) }));
    assert_eq!(first.check(), Ok(()), "taking it would not suffice");
    drop(blocker);
    bench.pass(TICK);
    assert_eq!(both(&set), [true, true]);
    assert!(first.check().is_err());
}

#[test]
fn no_member_is_valid_before_all_are_after_one_agent_was_revoked() {
    let (bench, _, supervisor) = two_agents();
    let set = granted(&bench, 5, [0, 1]);
    bench.broker.enter_safe_mode(&supervisor, Priority::new(9)).unwrap().without_waiting();
    bench.pass(TICK);
    bench.tapes[0].hold_admission.store(true, SeqCst);
    bench.broker.leave_safe_mode(&supervisor).unwrap();
    std::thread::scope(|threads| {
        threads.spawn(|| bench.pass(TICK));
        while !bench.tapes[0].held.load(SeqCst) {
            std::thread::yield_now();
        }
        let valid = both(&set);
        bench.tapes[0].hold_admission.store(false, SeqCst);
        assert_eq!(valid, [false, false], "its first gate has admitted it, its second has not");
    });
    bench.broker.service();
    assert_eq!(both(&set), [true, true]);
}

#[test]
fn a_member_given_back_leaves_the_others_valid() {
    let (bench, _) = Bench::new(margin(20), &[8, 8]);
    let (first, second) = granted(&bench, 5, [0, 1]);
    second.invoke(Switch::On).unwrap();
    drop(second);
    assert_eq!(first.check(), Ok(()));
    bench.truths[1].on.store(false, SeqCst);
    bench.pass(TICK);
    assert_eq!(first.invoke(Switch::On), Ok(()));
    assert_eq!(bench.charged(), 8);
    drop(first);
    bench.pass(TICK);
    assert_eq!(bench.free_seats(), 8);
}

#[test]
fn a_member_given_back_while_the_set_is_being_admitted_leaves_the_others_their_turn() {
    let (bench, _) = Bench::new(margin(20), &[8, 8]);
    bench.tapes[0].hold_admission.store(true, SeqCst);
    let (first, second) = pair(&bench, 5, [0, 1]).unwrap();
    std::thread::scope(|threads| {
        let service = threads.spawn(|| bench.broker.service());
        while !bench.tapes[0].held.load(SeqCst) {
            std::thread::yield_now();
        }
        drop(second);
        bench.tapes[0].hold_admission.store(false, SeqCst);
        service.join().unwrap();
    });
    bench.pass(TICK);
    assert_eq!(first.invoke(Switch::On), Ok(()));
}

#[test]
fn extending_asks_for_the_union_at_the_old_arrival() {
    let (bench, _) = Bench::new(margin(16), &[8, 8]);
    let first = bench.ticket(5, 0);
    let waiting = bench.ticket(5, 0);
    let rival = bench.ticket(5, 1);
    let more = bench.lamps[1].limited(Validity::always());
    let second = bench.broker.extend(&first, &more).unwrap();
    assert_eq!(first.id(), second.id());
    assert_eq!(first.check(), Err(Refusal::NotValid(Why::Extended)));
    bench.broker.service();
    assert_eq!((first.check(), second.check()), (Ok(()), Ok(())), "it came before the rival");
    assert!(rival.check().is_err() && waiting.check().is_err());
    drop((first, second));
    bench.pass(TICK);
    assert_eq!((waiting.check(), rival.check()), (Ok(()), Ok(())));
}

#[test]
fn an_extension_keeps_the_state_of_the_limits() {
    let (bench, _) = Bench::new(margin(16), &[8, 8]);
    let twice = bench.lamps[0].limited(Function::invocations(2));
    let first = bench.broker.request(Priority::SCIENCE, &twice).unwrap();
    bench.broker.service();
    first.invoke(Switch::Blink).unwrap();
    let second = bench.broker.extend(&first, &bench.lamps[1].limited(Validity::always())).unwrap();
    bench.broker.service();
    assert_eq!(second.invoke(Switch::Blink), Ok(()));
    assert_eq!(first.invoke(Switch::Blink), Ok(()));
    let refused = first.invoke(Switch::Blink).unwrap_err().refusal();
    assert!(matches!(refused, Some(Refusal::Denied(denial)) if denial.rule == Rule::Invocations));
}

#[test]
fn an_extension_refused_leaves_everything_as_it_was() {
    let (bench, _) = Bench::new(margin(16), &[8, 8, 9]);
    let ticket = bench.ticket(5, 0);
    let before = bench.broker.books();
    let mut full = Validity::always();
    for _ in 0..4 {
        full = full.and(Function::separation(TICK)).unwrap();
    }
    let lamp = |lamp: usize| bench.lamps[lamp].limited(Validity::always());
    let refused = |want| bench.broker.extend(&ticket, &want).unwrap_err();
    let gate = bench.lamps[0].gate();
    assert_eq!(refused(lamp(0)), RequestRefused::GateTwice(gate));
    let over = RequestRefused::OverSupply { draw: watts(17), supply: watts(16) };
    assert_eq!(refused(lamp(2)), over);
    let functions = RequestRefused::NoCapacity(Capacity::ValidityFunctions);
    assert_eq!(refused(bench.lamps[1].limited(full)), functions);
    assert_eq!(bench.broker.books(), before);
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
}

#[test]
fn a_ticket_that_has_expired_cannot_be_extended() {
    let (bench, _) = Bench::new(margin(16), &[8, 8]);
    let ticket = bench.ticket(5, 0);
    bench.pass(Duration::from_secs(1));
    assert_eq!(ticket.check(), Err(Refusal::NotValid(Why::Expired)));
    let more = bench.lamps[1].limited(Validity::always());
    assert_eq!(bench.broker.extend(&ticket, &more).unwrap_err(), RequestRefused::Stale);
}

#[test]
fn another_brokers_ticket_cannot_be_extended_here() {
    let (bench, _) = Bench::new(margin(16), &[8, 8]);
    let (elsewhere, _) = Bench::new(margin(16), &[8, 8]);
    let here = bench.ticket(5, 0);
    let foreign = elsewhere.ticket(5, 0);
    assert_eq!(here.id(), foreign.id(), "an id says nothing about its broker");
    let more = bench.lamps[1].limited(Validity::always());
    let refused = bench.broker.extend(&foreign, &more).unwrap_err();
    assert_eq!(refused, RequestRefused::UnknownGate);
    assert_eq!(here.check(), Ok(()));
}

#[test]
fn a_full_table_of_sets_refuses_and_a_set_given_back_makes_room() {
    let (bench, _) = Bench::new(margin(40), &[8, 8, 8]);
    let first = granted(&bench, 5, [0, 1]);
    let second = granted(&bench, 5, [1, 2]);
    let before = bench.broker.books();
    let refused = pair(&bench, 255, [0, 2]).unwrap_err();
    assert_eq!(refused, RequestRefused::NoCapacity(Capacity::Sets));
    let single = bench.ticket(5, 0);
    let more = bench.lamps[1].limited(Validity::always());
    let refused = bench.broker.extend(&single, &more).unwrap_err();
    assert_eq!(refused, RequestRefused::NoCapacity(Capacity::Sets));
    drop(single);
    assert_eq!(
        bench.broker.books().map(|books| books.free_seats()),
        before.map(|b| b.free_seats())
    );
    drop(first);
    assert!(pair(&bench, 255, [0, 2]).is_ok());
    drop(second);
}

#[test]
fn a_request_that_names_a_gate_twice_is_refused() {
    let (bench, _) = Bench::new(Policy::unlimited(), &[8]);
    let refused = pair(&bench, 5, [0, 0]).unwrap_err();
    assert_eq!(refused, RequestRefused::GateTwice(bench.lamps[0].gate()));
    assert_eq!(bench.free_seats(), 8);
}
