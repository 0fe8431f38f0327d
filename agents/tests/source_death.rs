//! **Source Death**: a holder that dies, however it dies, loses its authority,
//! and what it had is free again.

mod bench;

use std::mem::ManuallyDrop;
use std::sync::atomic::Ordering::SeqCst;

use bench::{Bench, Switch, TICK, drawing, margin};
use faregate_agents::Policy;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Profile, WhenOrphaned};
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;

/// What a holder leaves behind that neither runs nor unwinds.
fn leak(ticket: bench::Ticket) {
    let _ = ManuallyDrop::new(ticket);
}

fn nothing_is_leaked(bench: &Bench) {
    for _ in 0..3 {
        bench.pass(TICK);
    }
    assert_eq!((bench.free_seats(), bench.charged()), (8, 0));
}

#[test]
fn a_holder_that_panics_gives_its_ticket_back() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(5, 0);
    let waiting = bench.ticket(1, 0);
    let holder = std::thread::spawn(move || {
        ticket.invoke(Switch::On).unwrap();
        ticket.invoke(Switch::Fault).unwrap();
    });
    assert!(holder.join().is_err());
    assert_eq!(bench.free_seats(), 7);
    drop(waiting);
    nothing_is_leaked(&bench);
}

#[test]
fn a_leaked_ticket_ends_with_its_lease_and_its_device_goes_off() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(5, 0);
    let waiting = bench.ticket(1, 0);
    ticket.invoke(Switch::On).unwrap();
    leak(ticket);
    bench.clock.advance(Duration::from_millis(999));
    assert_eq!(bench.broker.service(), Some(after(&bench, 1)));
    assert!(bench.is_on(0));
    bench.clock.advance(TICK);
    bench.broker.service();
    assert!(!bench.is_on(0));
    assert_eq!(bench.free_seats(), 7);
    bench.pass(TICK);
    assert_eq!(waiting.check(), Ok(()));
    drop(waiting);
    nothing_is_leaked(&bench);
}

fn after(bench: &Bench, ms: u64) -> faregate_tickets::clock::Instant {
    use faregate_tickets::clock::Clock as _;
    bench.clock.now().after(Duration::from_millis(ms))
}

#[test]
fn a_leaked_ticket_ends_with_its_lease_under_a_policy_without_margin_too() {
    let (bench, _) = Bench::new(Policy::exclusive(), &[8]);
    let ticket = bench.ticket(5, 0);
    ticket.invoke(Switch::On).unwrap();
    leak(ticket);
    bench.clock.advance(Duration::from_secs(1));
    bench.broker.service();
    assert!(!bench.is_on(0));
    assert_eq!(bench.free_seats(), 8);
}

#[test]
fn a_ticket_leaked_while_it_waits_is_gone_one_lease_after_its_turn_came() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let valid = bench.ticket(5, 0);
    leak(bench.ticket(3, 0));
    let last = bench.ticket(1, 0);
    drop(valid);
    bench.broker.service();
    assert!(last.check().is_err(), "the dead one's turn");
    bench.clock.advance(Duration::from_secs(1));
    bench.broker.service();
    bench.pass(TICK);
    assert_eq!(last.check(), Ok(()));
    drop(last);
    nothing_is_leaked(&bench);
}

#[test]
fn a_holder_that_leaks_its_ticket_as_a_victim_of_a_hand_over_does_not_hold_it_up() {
    let (bench, _) = Bench::new(margin(10), &[8, 8]);
    let victim = bench.ticket(1, 0);
    victim.invoke(Switch::On).unwrap();
    let rescuer = bench.broker.request(Priority::EMERGENCY, &bench.lamps[1]).unwrap();
    leak(victim);
    bench.pass(TICK);
    assert_eq!(rescuer.check(), Ok(()));
    drop(rescuer);
    bench.pass(TICK);
    bench.clock.advance(Duration::from_secs(1));
    bench.broker.service();
    nothing_is_leaked(&bench);
}

#[test]
fn a_victim_that_dies_at_any_step_of_its_hand_over_is_safed_all_the_same() {
    for steps in 0..3 {
        let (bench, _) = Bench::new(margin(10), &[8, 8]);
        let victim = bench.ticket(1, 0);
        victim.invoke(Switch::On).unwrap();
        let rescuer = bench.broker.request(Priority::EMERGENCY, &bench.lamps[1]).unwrap();
        match steps {
            0 => drop(victim),
            1 => {
                bench.broker.service();
                drop(victim);
            }
            _ => {
                bench.pass(TICK);
                drop(victim);
            }
        }
        bench.pass(TICK);
        assert!(!bench.is_on(0));
        assert_eq!((rescuer.check(), bench.charged()), (Ok(()), 8), "after {steps} steps");
        drop(rescuer);
        nothing_is_leaked(&bench);
    }
}

#[test]
fn a_holder_that_dies_inside_a_command_is_noticed_at_the_end_of_its_lease() {
    let (bench, supervisor) = Bench::new(margin(10), &[8, 8]);
    let ticket = bench.ticket(5, 0);
    ticket.invoke(Switch::On).unwrap();
    let truth = bench.truths[0];
    truth.hold.store(true, SeqCst);
    let holder = std::thread::spawn(move || {
        let _ = ticket.invoke(Switch::Blink);
        leak(ticket);
    });
    truth.wait_until_held();
    bench.clock.advance(Duration::from_secs(1));
    bench.broker.service();
    bench.pass(TICK);
    assert_eq!(bench.charged(), 8, "inside its driver nobody can make it safe");
    truth.hold.store(false, SeqCst);
    holder.join().unwrap();
    bench.clock.advance(Duration::from_millis(5));
    bench.pass(TICK);
    assert!(!bench.is_on(0));
    // In line still, for a gate that is faulted: its turn comes once more.
    bench.broker.reset_gate(&supervisor, bench.lamps[0].gate()).unwrap();
    bench.pass(TICK);
    bench.clock.advance(Duration::from_secs(1));
    nothing_is_leaked(&bench);
}

#[test]
fn a_requester_that_dies_before_its_ticket_is_valid_takes_nothing_with_it() {
    let (bench, _) = Bench::new(margin(10), &[8, 8]);
    let victim = bench.ticket(1, 0);
    victim.invoke(Switch::On).unwrap();
    for services in 0..2 {
        let rescuer = bench.broker.request(Priority::EMERGENCY, &bench.lamps[1]).unwrap();
        if services == 1 {
            bench.broker.service();
        }
        drop(rescuer);
        bench.pass(TICK);
        bench.pass(TICK);
        assert_eq!(victim.invoke(Switch::On), Ok(()), "restored");
    }
    drop(victim);
    bench.truths[0].on.store(false, SeqCst);
    nothing_is_leaked(&bench);
}

#[test]
fn an_orphan_is_made_safe_at_once_if_its_gate_says_so_and_kept_if_not() {
    let at_once = Profile { when_orphaned: WhenOrphaned::SafeAtOnce, ..drawing(4) };
    let (bench, _) = Bench::with(margin(10), &[at_once, drawing(4)]);
    bench.pass(TICK);
    for lamp in [0, 1] {
        let ticket = bench.ticket(1, lamp);
        assert_eq!(ticket.invoke(Switch::Glow), Ok(()));
    }
    bench.broker.service();
    assert_eq!((bench.is_on(0), bench.is_on(1)), (false, true));
}

#[test]
fn a_dead_holders_ticket_says_expired_if_it_wakes_up_again() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let sleeper = bench.ticket(5, 0);
    sleeper.invoke(Switch::On).unwrap();
    bench.clock.advance(Duration::from_secs(1));
    bench.broker.service();
    bench.pass(TICK);
    let heir = bench.ticket(5, 0);
    assert_eq!(heir.id().seat, sleeper.id().seat);
    let expired = Some(Refusal::NotValid(Why::Expired));
    assert_eq!(sleeper.invoke(Switch::On).unwrap_err().refusal(), expired);
    drop(sleeper);
    assert_eq!(heir.invoke(Switch::On), Ok(()), "and takes nothing from who has its seat");
}

fn unless_held() -> Profile {
    Profile { when_orphaned: WhenOrphaned::SafeUnlessHeld, ..drawing(4) }
}

#[test]
fn a_device_that_is_safe_unless_held_goes_off_with_its_ticket_though_nobody_charges_it() {
    let (bench, _) = Bench::with(Policy::unlimited(), &[unless_held(), drawing(4)]);
    let tickets = [bench.ticket(1, 0), bench.ticket(1, 1)];
    for ticket in &tickets {
        ticket.invoke(Switch::Glow).unwrap();
    }
    drop(tickets);
    bench.broker.service();
    assert_eq!([bench.is_on(0), bench.is_on(1)], [false, true]);
}

#[test]
fn a_device_that_is_safe_unless_held_goes_off_when_its_ticket_is_revoked_and_passes_on_as_it_is() {
    let (bench, _) = Bench::with(Policy::exclusive(), &[unless_held(), drawing(4)]);
    let [first, other] = [bench.ticket(1, 0), bench.ticket(2, 1)];
    assert!(first.check().is_err() && other.check().is_ok());
    other.invoke(Switch::Glow).unwrap();
    let taker = bench.ticket(3, 0);
    taker.invoke(Switch::Glow).unwrap();
    assert!(bench.is_on(1), "the other one is kept until it is needed");
    let same = bench.ticket(4, 0);
    assert!(same.check().is_ok() && bench.is_on(0), "it passes on as it is");
    let last = bench.ticket(5, 1);
    assert!(last.check().is_ok() && same.check().is_err() && !bench.is_on(0));
}
