//! **Bounded Validity**, end to end: each validity function through the gate of
//! a ticket, and what becomes of the device when a limit runs out.

mod bench;

use std::sync::atomic::Ordering::SeqCst;
use std::sync::mpsc::channel;

use bench::{Bench, Hands, Kit, Switch, TICK, drawing, leak, margin};
use faregate_agents::{Categories, Policy, Waiting};
use faregate_tickets::amount::{Microjoules, Milligrams, MilligramsPerSecond};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Power, Profile};
use faregate_tickets::id::Priority;
use faregate_tickets::interlock::{Interlock, Side};
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use faregate_tickets::telemetry::{Channel, Mode, Modes, Telemetry};
use faregate_tickets::validity::{Denial, Function, Rule};

fn bench() -> Bench {
    Bench::new(margin(10), &[8, 8]).0
}

fn limited(bench: &Bench, function: Function) -> bench::Ticket {
    let want = bench.lamps[0].limited(function);
    let ticket = bench.broker.request(Priority::SCIENCE, &want).unwrap();
    bench.broker.service();
    ticket
}

fn denied(ticket: &bench::Ticket, command: Switch) -> Denial {
    match ticket.invoke(command).unwrap_err().refusal() {
        Some(Refusal::Denied(denial)) => denial,
        other => unreachable!("not a denial: {other:?}"),
    }
}

const EXPIRED: Result<(), Refusal> = Err(Refusal::NotValid(Why::Expired));

fn at(clock: &Hands, ms: u64) -> Instant {
    clock.now().after(Duration::from_millis(ms))
}

/// Only time passes and service comes: nobody invokes, nobody measures.
fn serve(bench: &Bench, ms: u64) {
    bench.clock.advance(Duration::from_millis(ms));
    bench.broker.service();
}

#[test]
fn outside_its_window_a_ticket_commands_nothing_and_at_its_end_the_device_goes_off() {
    let bench = bench();
    let (from, until) = (at(bench.clock, 10), at(bench.clock, 20));
    let ticket = limited(&bench, Function::window(from, until));
    let early = Denial { rule: Rule::Window, short_by: 10_000, until: Some(from) };
    assert_eq!(denied(&ticket, Switch::On), early);
    serve(&bench, 10);
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
    serve(&bench, 10);
    assert_eq!(ticket.check(), EXPIRED);
    assert!(!bench.is_on(0));
}

#[test]
fn a_time_limit_ends_with_the_device_off_without_any_further_invocation() {
    let bench = bench();
    let ticket = limited(&bench, Function::time_limit(Duration::from_millis(20)));
    serve(&bench, 500);
    assert_eq!(ticket.invoke(Switch::On), Ok(()), "it runs from the first On");
    serve(&bench, 19);
    assert!(bench.is_on(0));
    assert_eq!(bench.broker.service(), Some(at(bench.clock, 1)), "service knows when to come");
    serve(&bench, 1);
    assert!(!bench.is_on(0));
    assert_eq!(ticket.check(), EXPIRED);
    bench.pass(TICK);
    assert_eq!(bench.charged(), 0);
}

#[test]
fn a_time_limit_runs_on_while_its_ticket_waits() {
    let bench = bench();
    let ticket = limited(&bench, Function::time_limit(Duration::from_millis(20)));
    ticket.invoke(Switch::On).unwrap();
    let high = bench.ticket(255, 1);
    for _ in 0..20 {
        bench.pass(TICK);
    }
    drop(high);
    bench.pass(TICK);
    assert_eq!(ticket.check(), EXPIRED);
}

#[test]
fn so_many_commands_and_off_is_free() {
    let bench = bench();
    let ticket = limited(&bench, Function::invocations(2));
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
    assert_eq!(ticket.invoke(Switch::Off), Ok(()));
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
    let used = Denial { rule: Rule::Invocations, short_by: 1, until: None };
    assert_eq!(denied(&ticket, Switch::On), used);
    assert_eq!(ticket.invoke(Switch::Off), Ok(()));
    assert_eq!(bench.commands(0), 4);
}

#[test]
fn the_count_survives_pre_emption() {
    let bench = bench();
    let ticket = limited(&bench, Function::invocations(2));
    ticket.invoke(Switch::On).unwrap();
    for lamp in [0, 1] {
        let high = bench.ticket(255, lamp);
        bench.pass(TICK);
        assert!(ticket.check().is_err());
        drop(high);
        bench.pass(TICK);
    }
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
    assert_eq!(denied(&ticket, Switch::On).rule, Rule::Invocations);
}

#[test]
fn a_rate_and_a_separation_say_when_the_next_command_may_come() {
    let bench = bench();
    let period = Duration::from_millis(10);
    for (function, rule) in
        [(Function::rate(1, period), Rule::Rate), (Function::separation(period), Rule::Separation)]
    {
        let ticket = limited(&bench, function);
        ticket.invoke(Switch::Blink).unwrap();
        bench.clock.advance(Duration::from_millis(4));
        let until = Some(at(bench.clock, 6));
        assert_eq!(denied(&ticket, Switch::Blink), Denial { rule, short_by: 6_000, until });
        bench.clock.advance(Duration::from_millis(6));
        assert_eq!(ticket.invoke(Switch::Blink), Ok(()));
    }
}

#[test]
fn a_duty_cycle_turns_the_device_off_lets_it_rest_and_restores_the_ticket() {
    let bench = bench();
    let (on, period) = (Duration::from_millis(10), Duration::from_millis(30));
    let ticket = limited(&bench, Function::duty_cycle(on, period).unwrap());
    ticket.invoke(Switch::On).unwrap();
    serve(&bench, 10);
    assert!(!bench.is_on(0));
    assert_eq!(ticket.check(), Err(Refusal::NotValid(Why::Resting)));
    assert_eq!(bench.waits(ticket.id()), Some(Waiting::Resting));
    bench.pass(TICK);
    assert_eq!(ticket.check(), Ok(()));
    let rests = denied(&ticket, Switch::On);
    assert_eq!((rests.rule, rests.until), (Rule::DutyCycle, Some(at(bench.clock, 20))));
    bench.pass(Duration::from_millis(20));
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
}

#[test]
fn a_ticket_taken_and_restored_before_its_device_went_off_has_used_it_all_the_time() {
    for policy in [margin(10), Policy::exclusive()] {
        let (bench, _) = Bench::new(policy, &[8, 8]);
        let (on, period) = (Duration::from_millis(10), Duration::from_millis(30));
        let ticket = limited(&bench, Function::duty_cycle(on, period).unwrap());
        ticket.invoke(Switch::On).unwrap();
        bench.clock.advance(Duration::from_millis(6));
        // The thief is gone again before anybody has made the device safe.
        drop(bench.broker.request(Priority::EMERGENCY, &bench.lamps[1]).unwrap());
        bench.broker.service();
        assert!(ticket.check().is_ok() && bench.is_on(0));
        serve(&bench, 4);
        assert!(!bench.is_on(0), "on for 10 ms without a break");
    }
}

#[test]
fn an_energy_budget_ends_with_the_device_off() {
    let bench = bench();
    // 5 W for 20 ms.
    let ticket = limited(&bench, Function::energy(Microjoules::new(100_000)));
    ticket.invoke(Switch::On).unwrap();
    serve(&bench, 19);
    assert!(bench.is_on(0));
    serve(&bench, 1);
    assert!(!bench.is_on(0));
    assert_eq!(ticket.check(), EXPIRED);
}

#[test]
fn a_budget_stands_still_once_the_device_was_seen_off() {
    let bench = bench();
    let ticket = limited(&bench, Function::energy(Microjoules::new(100_000)));
    // On and off between two measurements: the sensors never see it on.
    ticket.invoke(Switch::On).unwrap();
    bench.clock.advance(TICK);
    ticket.invoke(Switch::Off).unwrap();
    bench.pass(TICK);
    for _ in 0..50 {
        ticket.renew().unwrap();
        bench.pass(TICK);
    }
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
}

#[test]
fn a_propellant_budget_counts_the_flow() {
    let profile = Profile { flow: MilligramsPerSecond::new(10), ..drawing(8) };
    let (bench, _) = Bench::with(margin(10), &[profile]);
    // 10 mg/s for 100 ms.
    let ticket = limited(&bench, Function::propellant(Milligrams::new(1)));
    ticket.invoke(Switch::Burn).unwrap();
    serve(&bench, 99);
    assert!(bench.is_on(0));
    serve(&bench, 1);
    assert!(!bench.is_on(0));
    assert_eq!(ticket.check(), EXPIRED);
}

#[test]
fn a_command_beyond_the_profile_is_refused() {
    let (bench, _) = Bench::new(margin(10), &[4]);
    let ticket = bench.ticket(1, 0);
    let undeclared = Some(Refusal::Undeclared);
    assert_eq!(ticket.invoke(Switch::On).unwrap_err().refusal(), undeclared);
    assert_eq!(ticket.invoke(Switch::Glow), Ok(()));
    assert_eq!(ticket.invoke(Switch::Burn).unwrap_err().refusal(), undeclared);
}

#[test]
fn modes_and_telemetry_are_looked_at_when_the_command_comes() {
    let telemetry: &Telemetry = leak(Telemetry::new());
    let (channel, safe) = (Channel::new(3).unwrap(), Mode::new(1).unwrap());
    let mut kit = Kit::new();
    let agent = kit.agent(margin(10));
    kit.fitted(agent, drawing(8), Categories::NONE, |gate| gate.watching(telemetry));
    let (bench, _) = kit.finish(agent);

    let ticket = limited(&bench, Function::modes(Modes::from(safe)));
    assert_eq!(denied(&ticket, Switch::On).rule, Rule::Mode);
    telemetry.set_mode(safe);
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
    drop(ticket);

    let ticket = limited(&bench, Function::telemetry(channel, -10..=40, Duration::from_millis(5)));
    assert_eq!(denied(&ticket, Switch::On).rule, Rule::TelemetryAge);
    telemetry.publish(channel, 43, bench.clock.now());
    let hot = denied(&ticket, Switch::On);
    assert_eq!((hot.rule, hot.short_by), (Rule::Telemetry, 3));
    bench.clock.advance(TICK);
    telemetry.publish(channel, 40, bench.clock.now());
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
    bench.clock.advance(Duration::from_millis(6));
    let old = denied(&ticket, Switch::On);
    assert_eq!((old.rule, old.short_by), (Rule::TelemetryAge, 1_000));
}

/// Two lamps, one on each side of an interlock.
fn interlocked(policy: Policy) -> Bench {
    let interlock: &Interlock = leak(Interlock::new());
    let mut kit = Kit::new();
    let agent = kit.agent(policy);
    for side in [Side::A, Side::B] {
        let member = interlock.member(side, 0).unwrap();
        kit.fitted(agent, drawing(8), Categories::NONE, |gate| gate.interlocked(member));
    }
    kit.finish(agent).0
}

fn sides(bench: &Bench) -> [bench::Ticket; 2] {
    let sides = [0, 1].map(|lamp| {
        let want = bench.lamps[lamp].limited(Function::interlock());
        bench.broker.request(Priority::SCIENCE, &want).unwrap()
    });
    bench.broker.service();
    sides
}

#[test]
fn interlocked_devices_are_never_both_on_and_the_other_may_when_one_was_seen_off() {
    for policy in [margin(20), Policy::unlimited()] {
        let bench = interlocked(policy);
        let [a, b] = sides(&bench);
        for (first, second) in [(&a, &b), (&b, &a)] {
            assert_eq!(first.invoke(Switch::On), Ok(()));
            assert_eq!(denied(second, Switch::On).rule, Rule::Interlock);
            first.invoke(Switch::Off).unwrap();
            assert_eq!(denied(second, Switch::On).rule, Rule::Interlock, "off is not seen off");
            bench.pass(TICK);
            assert_eq!(second.invoke(Switch::On), Ok(()));
            second.invoke(Switch::Off).unwrap();
            bench.pass(TICK);
        }
    }
}

#[test]
fn an_interlock_opens_when_the_holder_is_gone_and_the_device_seen_off() {
    for policy in [margin(20), Policy::unlimited()] {
        let bench = interlocked(policy);
        let [a, b] = sides(&bench);
        a.invoke(Switch::On).unwrap();
        drop(a);
        bench.broker.service();
        assert_eq!(denied(&b, Switch::On).rule, Rule::Interlock);
        bench.truths[0].on.store(false, std::sync::atomic::Ordering::SeqCst);
        bench.pass(TICK);
        assert_eq!(b.invoke(Switch::On), Ok(()));
    }
}

#[test]
fn a_device_that_nobody_has_seen_off_yet_keeps_the_other_side_off() {
    let interlock: &Interlock = leak(Interlock::new());
    let mut kit = Kit::new();
    let agent = kit.agent(margin(20));
    for side in [Side::A, Side::B] {
        let member = interlock.member(side, 0).unwrap();
        kit.fitted(agent, drawing(8), Categories::NONE, |gate| gate.interlocked(member));
    }
    let (bench, clock) = (kit.broker, kit.clock);
    clock.advance(TICK);
    let off = |lamp: usize| {
        let estimate =
            faregate_tickets::device::Estimate { state: Power::Off, measured_at: clock.now() };
        bench.observe(kit.lamps[lamp].gate(), estimate);
        bench.service();
    };
    off(0);
    let want = kit.lamps[0].limited(Function::interlock());
    let ticket = bench.request(Priority::SCIENCE, &want).unwrap();
    bench.service();
    let refused = ticket.invoke(Switch::On).unwrap_err().refusal();
    assert!(
        matches!(refused, Some(Refusal::Denied(denial)) if denial.rule == Rule::Interlock),
        "what it is at the start is not known: {refused:?}"
    );
    off(1);
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
}

#[test]
fn a_lease_is_renewed_by_commands_and_by_renew_and_ends_in_silence() {
    let bench = bench();
    let ticket = bench.ticket(1, 0);
    for _ in 0..3 {
        serve(&bench, 900);
        assert_eq!(ticket.invoke(Switch::On), Ok(()));
        serve(&bench, 900);
        assert_eq!(ticket.renew(), Ok(()));
    }
    serve(&bench, 1_000);
    assert_eq!(ticket.check(), EXPIRED);
    assert_eq!(ticket.renew(), EXPIRED);
    assert!(!bench.is_on(0));
}

#[test]
fn a_lease_that_is_over_cannot_be_renewed_before_service_notices() {
    let bench = bench();
    let ticket = bench.ticket(1, 0);
    bench.clock.advance(Duration::from_micros(1_000_007));
    let over = Denial { rule: Rule::Lease, short_by: 7, until: None };
    assert_eq!(denied(&ticket, Switch::On), over);
    assert_eq!(ticket.renew(), Err(Refusal::Denied(over)));
}

#[test]
fn a_lease_can_be_renewed_before_the_window_opens() {
    let bench = bench();
    let ticket = limited(&bench, Function::window(at(bench.clock, 1_500), at(bench.clock, 9_000)));
    serve(&bench, 800);
    assert_eq!(ticket.renew(), Ok(()));
    serve(&bench, 800);
    assert_eq!(ticket.invoke(Switch::On), Ok(()));
}

#[test]
fn a_waiting_tickets_lease_does_not_run() {
    let bench = bench();
    let valid = bench.ticket(9, 1);
    let waiting = bench.ticket(1, 0);
    for _ in 0..3 {
        serve(&bench, 900);
        valid.renew().unwrap();
    }
    drop(valid);
    bench.pass(TICK);
    assert_eq!(waiting.invoke(Switch::On), Ok(()));
}

#[test]
fn a_slow_command_within_its_factor_is_waited_for_when_a_limit_runs_out() {
    let slow = Duration::from_millis(100);
    let profile = Profile { longest_command: slow, overrun_factor: 100, ..drawing(8) };
    let bench = Bench::with(margin(10), &[profile]).0;
    let ticket = limited(&bench, Function::lease(Duration::from_millis(20)));
    let truth = bench.truths[0];
    truth.hold.store(true, SeqCst);
    std::thread::scope(|threads| {
        let holder = threads.spawn(move || ticket.invoke(Switch::On));
        truth.wait_until_held();
        bench.clock.advance(Duration::from_millis(50));
        let (tell, told) = channel();
        let broker = bench.broker;
        threads.spawn(move || tell.send(broker.service()));
        let six_times = slow.saturating_mul(6).into();
        assert!(told.recv_timeout(six_times).is_err(), "service waits for the command");
        truth.hold.store(false, SeqCst);
        assert_eq!(holder.join().unwrap(), Ok(()));
    });
    bench.pass(TICK);
    let report = bench.broker.device(bench.lamps[0].gate()).unwrap();
    assert_eq!(report.fault, None);
    assert!(!bench.is_on(0), "{report:?}");
}

#[test]
fn a_waiting_ticket_whose_window_has_closed_takes_no_victim() {
    let (bench, _) = Bench::new(margin(13), &[8, 10, 5]);
    let emergency = bench.ticket(9, 0);
    let humble = bench.ticket(1, 2);
    humble.invoke(Switch::On).unwrap();
    let until = bench.clock.now().after(TICK);
    let window = bench.lamps[1].limited(Function::window(Instant::START, until));
    let late = bench.broker.request(Priority::new(5), &window).unwrap();
    bench.pass(TICK.saturating_mul(3));
    drop(emergency);
    bench.broker.service();
    assert_eq!(humble.check(), Ok(()), "it is not taken in vain");
    assert_eq!(late.check(), Err(Refusal::NotValid(Why::Expired)));
    assert_eq!(bench.free_seats(), 7);
}
