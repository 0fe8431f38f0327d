//! **Highest First**, **Margin Kept** and **Every Refusal Explains Itself**:
//! who gets what under each policy, and what the others are told.

mod bench;

use bench::{Bench, Kit, Switch, TICK, drawing, margin, watts};
use faregate_agents::{Categories, Policy, RequestRefused, Waiting};
use faregate_tickets::amount::{Microjoules, Milligrams, Milliwatts};
use faregate_tickets::clock::Clock;
use faregate_tickets::device::Power;
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use faregate_tickets::validity::{Function, Validity};

fn preempted_by(ticket: &bench::Ticket, level: u8) -> Result<(), Refusal> {
    let priority = Priority::new(level);
    Err(Refusal::NotValid(Why::Preempted { by: ticket.id(), priority }))
}

#[test]
fn under_exclusion_the_most_important_of_the_group_is_valid_and_the_next_restored() {
    let (bench, _) = Bench::new(Policy::exclusive(), &[8, 8, 8]);
    let low = bench.ticket(1, 0);
    let high = bench.ticket(3, 1);
    let middle = bench.ticket(2, 2);
    assert_eq!(high.check(), Ok(()));
    assert_eq!(low.check(), preempted_by(&high, 3));
    assert_eq!(middle.check(), Err(Refusal::NotValid(Why::NotYetGranted)));
    assert_eq!(bench.waits(low.id()), Some(Waiting::Exclusive { by: high.id() }));
    assert_eq!(bench.waits(middle.id()), Some(Waiting::Exclusive { by: high.id() }));

    drop(high);
    bench.broker.service();
    assert_eq!(middle.check(), Ok(()));
    assert!(low.check().is_err());
    drop(middle);
    bench.broker.service();
    assert_eq!(low.invoke(Switch::On), Ok(()));
}

#[test]
fn among_equals_the_first_to_come_stays() {
    for policy in [Policy::exclusive(), margin(10)] {
        let (bench, _) = Bench::new(policy, &[8, 8]);
        let first = bench.ticket(7, 0);
        let second = bench.ticket(7, 1);
        let third = bench.ticket(7, 0);
        assert_eq!(first.check(), Ok(()));
        drop(first);
        bench.pass(TICK);
        assert_eq!((second.check().is_ok(), third.check().is_ok()), (true, false));
        drop(second);
        bench.pass(TICK);
        assert_eq!(third.check(), Ok(()));
    }
}

#[test]
fn one_gate_admits_its_most_important_and_hands_the_charge_on() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let low = bench.ticket(1, 0);
    low.invoke(Switch::On).unwrap();
    let high = bench.ticket(2, 0);
    assert_eq!(high.check(), Ok(()), "the same device needs no safing");
    assert!(bench.is_on(0));
    assert_eq!(bench.charged(), 8);
    assert_eq!(low.check(), preempted_by(&high, 2));
    let taken = Waiting::Gate { gate: bench.lamps[0].gate(), by: high.id() };
    assert_eq!(bench.waits(low.id()), Some(taken));
}

#[test]
fn only_as_many_victims_are_taken_as_needed_and_from_the_least_important() {
    let (bench, _) = Bench::new(margin(20), &[8, 6, 6, 8]);
    let (a, b, c) = (bench.ticket(3, 0), bench.ticket(2, 1), bench.ticket(1, 2));
    let rescuer = bench.ticket(9, 3);
    assert_eq!(a.check(), Ok(()), "the most important one is spared");
    assert!(b.check().is_err() && c.check().is_err());
    bench.pass(TICK);
    assert_eq!(rescuer.check(), Ok(()));
    assert_eq!(bench.charged(), 16);
    let short_by = watts(2);
    assert_eq!(bench.waits(b.id()), Some(Waiting::Margin { short_by }));
    assert_eq!(bench.waits(c.id()), Some(Waiting::Margin { short_by }));
}

#[test]
fn a_victim_without_which_it_still_fits_is_spared() {
    // 2 W are missing: taking the least important alone suffices.
    let (bench, _) = Bench::new(margin(20), &[6, 6, 6, 4]);
    let tickets: Vec<_> = (0..3).map(|lamp| bench.ticket(9 - lamp, usize::from(lamp))).collect();
    let rescuer = bench.ticket(200, 3);
    bench.pass(TICK);
    let valid = |ticket: &bench::Ticket| ticket.check().is_ok();
    assert!(valid(&rescuer) && valid(&tickets[0]) && valid(&tickets[1]));
    assert_eq!(tickets[2].check(), preempted_by(&rescuer, 200));
}

#[test]
fn a_falling_supply_takes_victims_at_once_and_a_rising_one_restores_them() {
    let (bench, supervisor) = Bench::new(margin(20), &[8, 8]);
    let (high, low) = (bench.ticket(2, 0), bench.ticket(1, 1));
    low.invoke(Switch::On).unwrap();
    bench.broker.set_supply(&supervisor, bench.agent, watts(10)).unwrap();
    assert_eq!(low.check(), Err(Refusal::NotValid(Why::SupplyFell)));
    assert_eq!(high.check(), Ok(()));
    assert_eq!(bench.waits(low.id()), Some(Waiting::Margin { short_by: watts(6) }));
    bench.pass(TICK);
    assert!(!bench.is_on(1));
    assert_eq!(bench.charged(), 8);

    bench.broker.set_supply(&supervisor, bench.agent, watts(16)).unwrap();
    bench.broker.service();
    assert_eq!(low.invoke(Switch::On), Ok(()));
}

#[test]
fn a_supply_that_fell_is_not_blamed_on_one_who_takes_no_margin() {
    let (bench, supervisor) = Bench::new(margin(10), &[8, 0]);
    let victim = bench.ticket(1, 0);
    let tenant = bench.ticket(1, 1);
    let next = bench.broker.request(Priority::EMERGENCY, &bench.lamps[1]).unwrap();
    assert_eq!(tenant.check(), preempted_by(&next, 255));
    bench.broker.set_supply(&supervisor, bench.agent, watts(5)).unwrap();
    assert_eq!(victim.check(), Err(Refusal::NotValid(Why::SupplyFell)));
}

#[test]
fn an_orphan_goes_off_before_any_victim() {
    let (bench, _) = Bench::new(margin(20), &[8, 8, 8]);
    let orphan = bench.ticket(9, 0);
    orphan.invoke(Switch::On).unwrap();
    drop(orphan);
    bench.pass(TICK);
    assert!(bench.is_on(0), "nobody needs its margin yet");
    let least = bench.ticket(0, 1);
    let other = bench.ticket(1, 2);
    bench.pass(TICK);
    assert!(!bench.is_on(0));
    assert_eq!((least.check(), other.check()), (Ok(()), Ok(())));
}

#[test]
fn a_device_counts_as_on_until_it_is_seen_off() {
    let mut kit = Kit::new();
    let agent = kit.agent(margin(10));
    kit.lamp(agent, drawing(8));
    assert_eq!(kit.broker.margin(agent).unwrap(), (watts(10), watts(8)), "at construction");
    let lamp = kit.lamps[0].gate();
    let (bench, _) = kit.finish(agent);
    assert_eq!(bench.charged(), 0);
    let ticket = bench.ticket(1, 0);
    ticket.invoke(Switch::On).unwrap();
    drop(ticket);
    bench.broker.service();
    bench.clock.advance(TICK);
    bench.report(0, Power::Unknown, bench.clock.now());
    assert_eq!(bench.charged(), 8, "unknown counts as on");
    bench.clock.advance(TICK);
    bench.report(0, Power::Off, bench.clock.now());
    assert_eq!(bench.charged(), 0);
    assert_eq!(bench.broker.device(lamp).unwrap().charge, Milliwatts::ZERO);
}

#[test]
fn devices_that_share_a_category_are_never_used_together() {
    let mut kit = Kit::new();
    let agent = kit.agent(Policy::categories());
    for mask in [0b011, 0b110, 0b100] {
        kit.fitted(agent, drawing(8), Categories::from_mask(mask), |gate| gate);
    }
    let (bench, _) = kit.finish(agent);
    let low = bench.ticket(1, 0);
    let apart = bench.ticket(1, 2);
    low.invoke(Switch::On).unwrap();
    apart.invoke(Switch::On).unwrap();
    let high = bench.ticket(2, 1);
    assert_eq!(low.check(), preempted_by(&high, 2));
    assert_eq!(apart.check(), preempted_by(&high, 2));
    assert!(high.check().is_err(), "the conflicting devices are not seen off yet");
    bench.pass(TICK);
    assert_eq!((bench.is_on(0), bench.is_on(2), high.check()), (false, false, Ok(())));
    let (shared, by) = (Categories::from_mask(0b010), Some(high.id()));
    assert_eq!(bench.waits(low.id()), Some(Waiting::Categories { shared, by }));
    drop(high);
    bench.pass(TICK);
    assert_eq!((low.check(), apart.check()), (Ok(()), Ok(())));
}

#[test]
fn rules_compose_each_must_agree() {
    let mut kit = Kit::new();
    let agent = kit.agent(margin(20).with_categories());
    for (draw, mask) in [(8, 0b01), (8, 0b01), (8, 0b10), (8, 0b100)] {
        kit.fitted(agent, drawing(draw), Categories::from_mask(mask), |gate| gate);
    }
    let (bench, _) = kit.finish(agent);
    let tickets: Vec<_> = (0..4).map(|lamp| bench.ticket(9 - lamp, usize::from(lamp))).collect();
    let valid: Vec<bool> = tickets.iter().map(|ticket| ticket.check().is_ok()).collect();
    assert_eq!(valid, [true, false, true, false]);
    let reasons = [bench.waits(tickets[1].id()), bench.waits(tickets[3].id())];
    let (shared, by) = (Categories::from_mask(1), Some(tickets[0].id()));
    let conflict = Waiting::Categories { shared, by };
    assert_eq!(reasons, [Some(conflict), Some(Waiting::Margin { short_by: watts(4) })]);
}

#[test]
fn exclusion_with_a_margin_waits_for_the_other_device_to_be_seen_off() {
    let (bench, _) = Bench::new(margin(10).with_exclusion(), &[8, 8]);
    let low = bench.ticket(1, 0);
    low.invoke(Switch::On).unwrap();
    let high = bench.ticket(2, 1);
    assert!(high.check().is_err());
    assert!(low.check().is_err());
    bench.pass(TICK);
    assert_eq!(high.check(), Ok(()));
}

#[test]
fn a_request_beyond_any_supply_is_refused_with_the_figures() {
    let (bench, supervisor) = Bench::new(margin(10), &[11]);
    let before = bench.broker.books();
    let refused = bench.broker.request(Priority::EMERGENCY, &bench.lamps[0]).unwrap_err();
    assert_eq!(refused, RequestRefused::OverSupply { draw: watts(11), supply: watts(10) });
    assert_eq!(bench.broker.books(), before);
    // A supply that was larger once can be so again: then it waits.
    bench.broker.set_supply(&supervisor, bench.agent, watts(11)).unwrap();
    bench.broker.set_supply(&supervisor, bench.agent, watts(10)).unwrap();
    let waits = bench.ticket(255, 0);
    assert_eq!(bench.waits(waits.id()), Some(Waiting::Margin { short_by: watts(1) }));
}

#[test]
fn a_budget_is_reserved_by_the_request_and_the_unused_comes_back_to_the_unit() {
    let policy = margin(10).with_energy(Microjoules::from_joules(100));
    let (bench, _) = Bench::new(policy, &[8]);
    let budget =
        |joules| bench.lamps[0].limited(Function::energy(Microjoules::from_joules(joules)));
    let left = || bench.broker.books().unwrap().budgets(0).unwrap().0;
    let ticket = bench.broker.request(Priority::SCIENCE, &budget(60)).unwrap();
    assert_eq!(left(), Microjoules::from_joules(40));
    let refused = bench.broker.request(Priority::EMERGENCY, &budget(41)).unwrap_err();
    let (asked, remains) = (Microjoules::from_joules(41), Microjoules::from_joules(40));
    assert_eq!(refused, RequestRefused::NoEnergy { asked, left: remains });

    bench.broker.service();
    ticket.invoke(Switch::On).unwrap();
    bench.clock.advance(TICK);
    ticket.invoke(Switch::Off).unwrap();
    drop(ticket);
    bench.broker.service();
    assert_eq!(left(), remains, "what it used is known when it is seen off");
    bench.pass(TICK);
    // 5 W for the 2 ms until it was seen off.
    assert_eq!(left(), Microjoules::new(100_000_000 - 10_000));
}

#[test]
fn an_unused_budget_comes_back_whole_and_not_that_of_an_earlier_ticket() {
    let policy = margin(10).with_energy(Microjoules::from_joules(100));
    let (bench, _) = Bench::new(policy, &[8]);
    let budget =
        |joules| bench.lamps[0].limited(Function::energy(Microjoules::from_joules(joules)));
    let left = || bench.broker.books().unwrap().budgets(0).unwrap().0;
    let earlier = bench.broker.request(Priority::SCIENCE, &budget(60)).unwrap();
    bench.broker.service();
    drop(earlier);
    bench.pass(TICK);
    assert_eq!(left(), Microjoules::from_joules(100));
    // Granted in the books, and dropped before its gate has admitted it.
    drop(bench.broker.request(Priority::SCIENCE, &budget(50)).unwrap());
    bench.pass(TICK);
    assert_eq!(left(), Microjoules::from_joules(100));
}

#[test]
fn propellant_is_reserved_and_refused_as_energy_is() {
    let policy = Policy::unlimited().with_propellant(Milligrams::new(100));
    let (bench, _) = Bench::with(policy, &[drawing(8)]);
    let budget = |mg| bench.lamps[0].limited(Function::propellant(Milligrams::new(mg)));
    let ticket = bench.broker.request(Priority::SCIENCE, &budget(70)).unwrap();
    let refused = bench.broker.request(Priority::SCIENCE, &budget(31)).unwrap_err();
    let (asked, left) = (Milligrams::new(31), Milligrams::new(30));
    assert_eq!(refused, RequestRefused::NoPropellant { asked, left });
    drop(ticket);
    bench.pass(TICK);
    assert!(bench.broker.request(Priority::SCIENCE, &budget(100)).is_ok());
}

#[test]
fn a_request_that_comes_when_a_device_proves_stuck_revokes_whom_the_books_revoke() {
    let (bench, _) = Bench::new(margin(16), &[8, 8, 8, 0]);
    let (first, second) = (bench.ticket(1, 0), bench.ticket(2, 1));
    first.invoke(Switch::On).unwrap();
    bench.truths[0].deaf_to_safing.store(99, std::sync::atomic::Ordering::SeqCst);
    let rescuer = bench.ticket(255, 2);
    // No sensor says anything; the last confirmation runs out unnoticed.
    let lag = drawing(8).estimate_lag;
    for _ in 0..2 {
        bench.clock.advance(lag);
        bench.clock.advance(TICK);
        bench.broker.service();
    }
    bench.clock.advance(lag);
    bench.clock.advance(TICK);
    assert_eq!(second.check(), Ok(()));
    let bystander = bench.broker.request(Priority::LEAST, &bench.lamps[3]).unwrap();
    assert_eq!(second.check(), preempted_by(&rescuer, 255));
    bench.pass(TICK);
    assert_eq!((rescuer.check(), bystander.check()), (Ok(()), Ok(())));

    drop(rescuer);
    bench.pass(TICK);
    bench.pass(TICK);
    assert_eq!(second.invoke(Switch::On), Ok(()), "valid for the books and for its gate");
}

#[test]
fn a_limited_ticket_taken_before_its_gate_admitted_it_keeps_its_limits() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let once = Validity::from(Function::invocations(1));
    let limited = bench.broker.request(Priority::SCIENCE, &bench.lamps[0].limited(once)).unwrap();
    let emergency = bench.broker.request(Priority::EMERGENCY, &bench.lamps[0]).unwrap();
    bench.broker.service();
    drop(emergency);
    bench.pass(TICK);
    assert_eq!(limited.invoke(Switch::On), Ok(()));
    assert!(limited.invoke(Switch::On).is_err(), "once is once");
}
