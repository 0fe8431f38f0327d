//! Supervisors bar and reinstate single tickets, and reset faulted gates, in
//! their own scope; what is stale is detected.

mod bench;

use bench::{Bench, Kit, Switch, TICK, drawing, margin};
use faregate_agents::{AgentId, NotYours, Supervisor, Waiting};
use faregate_tickets::fault::GateFault;
use faregate_tickets::id::{HolderId, Priority};
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use faregate_tickets::validity::Validity;

#[test]
fn a_barred_ticket_is_refused_at_once_and_its_device_made_safe() {
    let (bench, supervisor) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(5, 0);
    ticket.invoke(Switch::On).unwrap();
    let revoked = bench.broker.bar(&supervisor, ticket.id()).unwrap();
    let barred = Err(Refusal::NotValid(Why::Barred));
    assert_eq!(ticket.check(), barred);
    assert!(revoked.quiesce().is_ok());
    bench.pass(TICK);
    assert!(!bench.is_on(0));
    assert_eq!((ticket.check(), bench.waits(ticket.id())), (barred, Some(Waiting::Barred)));
    assert_eq!(bench.charged(), 0);
}

#[test]
fn a_reinstated_ticket_stands_behind_those_who_came_meanwhile() {
    for lamp in [0, 1] {
        let (bench, supervisor) = Bench::new(margin(10), &[8, 8]);
        let barred = bench.ticket(5, 0);
        bench.broker.bar(&supervisor, barred.id()).unwrap().without_waiting();
        let later = bench.ticket(5, lamp);
        bench.pass(TICK);
        assert_eq!(later.check(), Ok(()));
        bench.broker.reinstate(&supervisor, barred.id()).unwrap();
        bench.pass(TICK);
        assert_eq!(later.check(), Ok(()), "the other came first, now");
        drop(later);
        bench.pass(TICK);
        assert_eq!(barred.invoke(Switch::On), Ok(()));
    }
}

#[test]
fn a_ticket_barred_while_it_waits_is_not_restored() {
    let (bench, supervisor) = Bench::new(margin(10), &[8, 8]);
    let waiting = bench.ticket(1, 0);
    let valid = bench.ticket(9, 1);
    bench.broker.bar(&supervisor, waiting.id()).unwrap().without_waiting();
    drop(valid);
    bench.pass(TICK);
    bench.pass(TICK);
    assert_eq!(waiting.check(), Err(Refusal::NotValid(Why::Barred)));
    bench.broker.reinstate(&supervisor, waiting.id()).unwrap();
    bench.pass(TICK);
    assert_eq!(waiting.check(), Ok(()));
}

#[test]
fn barring_one_of_a_set_bars_all_of_it() {
    let (bench, supervisor) = Bench::new(margin(20), &[8, 8]);
    let [a, b] = [0, 1].map(|lamp| bench.lamps[lamp].limited(Validity::always()));
    let set = bench.broker.request(Priority::SCIENCE, &(a, b)).unwrap();
    bench.broker.service();
    set.1.invoke(Switch::On).unwrap();
    bench.broker.bar(&supervisor, set.0.id()).unwrap().without_waiting();
    let barred = Err(Refusal::NotValid(Why::Barred));
    assert_eq!((set.0.check(), set.1.check()), (barred, barred));
    bench.pass(TICK);
    assert!(!bench.is_on(1));
    bench.broker.reinstate(&supervisor, set.1.id()).unwrap();
    bench.pass(TICK);
    assert_eq!((set.0.check(), set.1.check()), (Ok(()), Ok(())));
}

#[test]
fn a_stale_id_is_detected_and_hits_nobody() {
    let (bench, supervisor) = Bench::new(margin(10), &[8]);
    let gone = bench.ticket(5, 0).id();
    let heir = bench.ticket(5, 0);
    assert_eq!(heir.id().seat, gone.seat, "it has the same seat");
    assert_eq!(bench.broker.bar(&supervisor, gone).err(), Some(NotYours::Stale));
    assert_eq!(bench.broker.reinstate(&supervisor, gone).err(), Some(NotYours::Stale));
    let nowhere = faregate_tickets::id::TicketId { seat: 999, serial: 1 };
    assert_eq!(bench.broker.bar(&supervisor, nowhere).err(), Some(NotYours::Stale));
    assert_eq!(bench.broker.reinstate(&supervisor, nowhere).err(), Some(NotYours::Stale));
    bench.pass(TICK);
    assert_eq!(heir.check(), Ok(()));
    assert_eq!(bench.waits(gone), None);
}

#[test]
fn a_barred_ticket_given_back_frees_its_seat_for_one_who_is_not_barred() {
    let (bench, supervisor) = Bench::new(margin(10), &[8]);
    let barred = bench.ticket(5, 0);
    // Nobody serves between the bar and the end.
    bench.broker.bar(&supervisor, barred.id()).unwrap().without_waiting();
    drop(barred);
    let heir = bench.ticket(5, 0);
    bench.pass(TICK);
    bench.pass(TICK);
    assert_eq!(heir.invoke(Switch::On), Ok(()));
    drop(heir);
    bench.pass(TICK);
    assert_eq!(bench.free_seats(), 8);
}

#[test]
fn a_faulted_gate_takes_tickets_again_when_a_supervisor_has_reset_it() {
    let (bench, supervisor) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(5, 0);
    ticket.invoke(Switch::On).unwrap();
    ticket.invoke(Switch::Fault).unwrap_err();
    bench.pass(TICK);
    let gate = bench.lamps[0].gate();
    let fault = GateFault::Driver;
    assert_eq!(ticket.check(), Err(Refusal::Faulted(fault)));
    assert_eq!(bench.waits(ticket.id()), Some(Waiting::Faulted { gate, fault }));
    bench.broker.reset_gate(&supervisor, gate).unwrap();
    bench.pass(TICK);
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
}

/// Two agents, and a supervisor of the first.
fn neighbours() -> (Bench, Supervisor, AgentId) {
    let mut kit = Kit::new();
    let (one, other) = (kit.agent(margin(10)), kit.agent(margin(10)));
    kit.lamp(one, drawing(8));
    kit.lamp(other, drawing(8));
    let of_one = kit.broker.supervisor_of(one).unwrap();
    let (bench, _) = kit.finish(one);
    (bench, of_one, other)
}

#[test]
fn an_agents_supervisor_has_no_authority_at_another_agent() {
    let (bench, of_one, _) = neighbours();
    let (own, foreign) = (bench.ticket(5, 0), bench.ticket(5, 1));
    let refused = Some(NotYours::OtherScope);
    assert_eq!(bench.broker.bar(&of_one, foreign.id()).err(), refused);
    assert_eq!(bench.broker.reinstate(&of_one, foreign.id()).err(), refused);
    foreign.invoke(Switch::Fault).unwrap_err();
    assert_eq!(bench.broker.reset_gate(&of_one, bench.lamps[1].gate()).err(), refused);
    assert_eq!(foreign.check(), Err(Refusal::Faulted(GateFault::Driver)));

    own.invoke(Switch::Fault).unwrap_err();
    bench.broker.reset_gate(&of_one, bench.lamps[0].gate()).unwrap();
    bench.pass(TICK);
    assert_eq!(own.check(), Ok(()));
    bench.broker.bar(&of_one, own.id()).unwrap().without_waiting();
    assert_eq!(own.check(), Err(Refusal::NotValid(Why::Barred)));
    bench.broker.reinstate(&of_one, own.id()).unwrap();
    bench.pass(TICK);
    assert_eq!(own.check(), Ok(()));
}

#[test]
fn a_supervisor_is_made_only_for_an_agent_of_the_same_broker() {
    let mut kit = Kit::new();
    let foreign = Kit::new().agent(margin(10));
    assert_eq!(kit.broker.supervisor_of(foreign).err(), Some(NotYours::OtherScope));
}

#[test]
fn barring_a_holder_bars_all_its_tickets_and_nobody_elses() {
    let (bench, supervisor) = Bench::new(margin(30), &[8, 8, 8, 0]);
    let (suspect, other) = (HolderId(7), HolderId(8));
    let held_by = |lamp: usize, holder| {
        let want = bench.lamps[lamp].limited(Validity::always()).held_by(holder);
        bench.broker.request(Priority::SCIENCE, &want).unwrap()
    };
    let theirs = [held_by(0, suspect), held_by(1, suspect)];
    let elses = [held_by(2, other), bench.ticket(9, 3)];
    bench.broker.service();
    theirs[0].invoke(Switch::On).unwrap();
    bench.broker.bar_holder(&supervisor, suspect).unwrap().quiesce().unwrap();
    let barred = Err(Refusal::NotValid(Why::Barred));
    assert!(theirs.iter().all(|ticket| ticket.check() == barred));
    bench.pass(TICK);
    assert!(elses.iter().all(|ticket| ticket.check().is_ok()));
    assert!(!bench.is_on(0), "its devices are made safe");
    for ticket in &theirs {
        bench.broker.reinstate(&supervisor, ticket.id()).unwrap();
    }
    bench.pass(TICK);
    bench.pass(TICK);
    assert!(theirs.iter().all(|ticket| ticket.check().is_ok()));
    drop(theirs);
    let heir = held_by(0, other);
    bench.broker.bar_holder(&supervisor, suspect).unwrap().without_waiting();
    bench.pass(TICK);
    assert_eq!(heir.check(), Ok(()), "the seat is not the suspect's any more");
}
