//! Safe mode: everything is revoked, devices go off, nothing below the floor
//! becomes valid until it is left, and then tickets are restored in order.

mod bench;

use bench::{Bench, Kit, Switch, TICK, drawing, margin};
use faregate_agents::{NotYours, Waiting};
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;

const FLOOR: Priority = Priority::new(100);

#[test]
fn entering_revokes_everything_at_once_and_makes_the_devices_safe() {
    let (bench, supervisor) = Bench::new(margin(30), &[8, 8]);
    let (low, high) = (bench.ticket(1, 0), bench.ticket(255, 1));
    low.invoke(Switch::On).unwrap();
    high.invoke(Switch::On).unwrap();
    let revoked = bench.broker.enter_safe_mode(&supervisor, FLOOR).unwrap();
    let refused = Err(Refusal::RevokedAll { floor: Some(FLOOR) });
    assert_eq!((low.check(), high.check()), (refused, refused));
    assert!(revoked.quiesce().is_ok());
    bench.broker.service();
    assert!(!bench.is_on(0) && !bench.is_on(1));
    assert_eq!(low.check(), Err(Refusal::NotValid(Why::RevokedAll)));
}

#[test]
fn nothing_below_the_floor_becomes_valid_until_safe_mode_is_left() {
    let (bench, supervisor) = Bench::new(margin(30), &[8, 8, 8]);
    let low = bench.ticket(99, 0);
    let at_floor = bench.ticket(100, 1);
    bench.broker.enter_safe_mode(&supervisor, FLOOR).unwrap().without_waiting();
    let new = bench.ticket(99, 2);
    for _ in 0..3 {
        bench.pass(TICK);
        assert_eq!(at_floor.check(), Ok(()), "the floor itself is above");
        assert!(low.check().is_err() && new.check().is_err());
    }
    let waits = Some(Waiting::SafeMode { floor: FLOOR });
    assert_eq!((bench.waits(low.id()), bench.waits(new.id())), (waits, waits));
    bench.broker.leave_safe_mode(&supervisor).unwrap();
    bench.pass(TICK);
    assert_eq!((low.check(), new.check()), (Ok(()), Ok(())));
}

#[test]
fn leaving_restores_in_order_as_far_as_the_margin_goes() {
    let (bench, supervisor) = Bench::new(margin(16), &[8, 8, 8]);
    let last = bench.ticket(1, 0);
    let first = bench.ticket(9, 1);
    let second = bench.ticket(5, 2);
    bench.broker.enter_safe_mode(&supervisor, FLOOR).unwrap().without_waiting();
    bench.pass(TICK);
    bench.broker.leave_safe_mode(&supervisor).unwrap();
    bench.pass(TICK);
    assert_eq!((first.check(), second.check()), (Ok(()), Ok(())));
    assert!(last.check().is_err());
}

#[test]
fn a_request_made_in_safe_mode_before_anybody_noticed_it_is_not_valid() {
    let (bench, supervisor) = Bench::new(margin(30), &[8]);
    bench.broker.enter_safe_mode(&supervisor, FLOOR).unwrap().without_waiting();
    let ticket = bench.broker.request(Priority::new(1), &bench.lamps[0]).unwrap();
    assert!(ticket.invoke(Switch::On).is_err());
    bench.pass(TICK);
    assert!(ticket.invoke(Switch::On).is_err());
    assert_eq!(bench.commands(0), 0);
}

#[test]
fn an_orphaned_device_is_made_safe_too() {
    let (bench, supervisor) = Bench::new(margin(30), &[8]);
    let ticket = bench.ticket(1, 0);
    ticket.invoke(Switch::On).unwrap();
    drop(ticket);
    bench.pass(TICK);
    assert!(bench.is_on(0));
    bench.broker.enter_safe_mode(&supervisor, FLOOR).unwrap().without_waiting();
    bench.pass(TICK);
    assert!(!bench.is_on(0));
    assert_eq!(bench.charged(), 0);
}

#[test]
fn safe_mode_of_one_agent_leaves_the_others_alone() {
    let mut kit = Kit::new();
    let (one, other) = (kit.agent(margin(10)), kit.agent(margin(10)));
    kit.lamp(one, drawing(8));
    kit.lamp(other, drawing(8));
    let of_one = kit.broker.supervisor_of(one).unwrap();
    let (bench, _) = kit.finish(one);
    let (inside, outside) = (bench.ticket(1, 0), bench.ticket(1, 1));
    inside.invoke(Switch::On).unwrap();
    outside.invoke(Switch::On).unwrap();
    bench.broker.enter_safe_mode(&of_one, FLOOR).unwrap().without_waiting();
    assert_eq!(inside.check(), Err(Refusal::RevokedAll { floor: Some(FLOOR) }));
    bench.pass(TICK);
    assert_eq!((bench.is_on(0), bench.is_on(1)), (false, true));
    assert_eq!(outside.check(), Ok(()));
    assert_eq!(bench.waits(inside.id()), Some(Waiting::SafeMode { floor: FLOOR }));
    bench.broker.leave_safe_mode(&of_one).unwrap();
    bench.pass(TICK);
    assert_eq!(inside.check(), Ok(()));
}

#[test]
fn revoke_all_but_me_exempts_a_valid_ticket_below_the_floor_and_nobody_else() {
    let (bench, supervisor) = Bench::new(margin(30), &[8, 8, 8]);
    let (me, other) = (bench.ticket(1, 0), bench.ticket(1, 1));
    me.invoke(Switch::On).unwrap();
    other.invoke(Switch::On).unwrap();
    let (exempt, revoked) = bench.broker.revoke_all_but_me(&supervisor, &me, FLOOR).unwrap();
    revoked.without_waiting();
    assert!(exempt);
    assert_eq!(other.check(), Err(Refusal::RevokedAll { floor: Some(FLOOR) }));
    for _ in 0..3 {
        assert_eq!(me.invoke(Switch::Blink), Ok(()));
        bench.pass(TICK);
    }
    assert_eq!((bench.is_on(0), bench.is_on(1)), (true, false));
    assert!(bench.ticket(99, 2).check().is_err(), "the floor holds for the rest");

    // The exemption is from that one revocation.
    bench.broker.enter_safe_mode(&supervisor, FLOOR).unwrap().without_waiting();
    assert!(me.check().is_err());
    bench.pass(TICK);
    assert!(me.check().is_err());
}

#[test]
fn a_ticket_that_was_not_valid_is_not_exempt() {
    let (bench, supervisor) = Bench::new(margin(10), &[8, 8]);
    let valid = bench.ticket(9, 0);
    let waiting = bench.ticket(1, 1);
    let (exempt, revoked) = bench.broker.revoke_all_but_me(&supervisor, &waiting, FLOOR).unwrap();
    revoked.without_waiting();
    assert!(!exempt);
    assert!(valid.check().is_err(), "the rest is revoked all the same");
    bench.pass(TICK);
    assert!(waiting.check().is_err());
}

#[test]
fn an_exempt_ticket_gives_way_to_one_above_the_floor() {
    let (bench, supervisor) = Bench::new(margin(10), &[8, 8]);
    let me = bench.ticket(1, 0);
    bench.broker.revoke_all_but_me(&supervisor, &me, FLOOR).unwrap().1.without_waiting();
    bench.broker.service();
    let high = bench.ticket(200, 1);
    bench.pass(TICK);
    assert_eq!(high.check(), Ok(()));
    assert!(me.check().is_err());
    drop(high);
    bench.pass(TICK);
    assert!(me.check().is_err(), "once taken it is below the floor like any other");
}

#[test]
fn a_supervisor_of_another_broker_revokes_nothing_here() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let (elsewhere, foreign) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(1, 0);
    let broker = bench.broker;
    let refused = Some(NotYours::OtherScope);
    assert_eq!(broker.enter_safe_mode(&foreign, FLOOR).err(), refused);
    assert_eq!(broker.leave_safe_mode(&foreign).err(), refused);
    assert_eq!(broker.bar(&foreign, ticket.id()).err(), refused);
    assert_eq!(broker.reinstate(&foreign, ticket.id()).err(), refused);
    assert_eq!(broker.reset_gate(&foreign, bench.lamps[0].gate()).err(), refused);
    assert_eq!(broker.revoke_all_but_me(&foreign, &ticket, FLOOR).err(), refused);
    assert_eq!(ticket.check(), Ok(()));
    assert_eq!(elsewhere.broker.revoke_all_but_me(&foreign, &ticket, FLOOR).err(), refused);
    assert_eq!(ticket.check(), Ok(()));
}

#[test]
fn an_agents_supervisor_cannot_revoke_all_of_the_broker() {
    let mut kit = Kit::new();
    let agent = kit.agent(margin(10));
    kit.lamp(agent, drawing(8));
    let of_agent = kit.broker.supervisor_of(agent).unwrap();
    let (bench, _) = kit.finish(agent);
    let ticket = bench.ticket(1, 0);
    let refused = bench.broker.revoke_all_but_me(&of_agent, &ticket, FLOOR).err();
    assert_eq!(refused, Some(NotYours::OtherScope));
    assert_eq!(ticket.check(), Ok(()));
}
