//! **Nothing Lost**: what happened is on the tapes, with its time and ticket.

mod bench;

use bench::{Bench, Kit, Switch, TICK, drawing, margin, watts};
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::fault::GateFault;
use faregate_tickets::id::Priority;
use faregate_tickets::recorder::RecordedEvent as Event;
use faregate_tickets::standing::Why;
use faregate_tickets::validity::{Function, Validity};

#[test]
fn the_story_of_a_hand_over_is_on_the_tapes() {
    let (bench, _) = Bench::new(margin(10), &[8, 8]);
    let (camera, gate) = (&bench.tapes[0], bench.lamps[0].gate());
    camera.rewind();
    bench.tape.rewind();
    let low = bench.ticket(1, 0);
    low.invoke(Switch::On).unwrap();
    let high = bench.ticket(9, 1);
    low.invoke(Switch::On).unwrap_err();
    low.invoke(Switch::On).unwrap_err();
    bench.pass(TICK);
    let (low_serial, high_serial) = (low.id().serial, high.id().serial);
    let taken = Why::Preempted { by: high.id(), priority: Priority::new(9) };
    drop(low);
    drop(high);

    assert_eq!(
        bench.tape.events_of(low_serial),
        [
            Event::Requested { priority: Priority::new(1) },
            Event::Granted,
            Event::Revoked(taken),
            Event::Refused { count: 2 },
            Event::Relinquished,
            Event::Ended,
        ]
    );
    assert_eq!(
        bench.tape.events_of(high_serial),
        [
            Event::Requested { priority: Priority::new(9) },
            Event::Granted,
            Event::Relinquished,
            Event::Ended,
        ]
    );
    assert_eq!(bench.tape.events_of(0), [Event::SeenOff { gate }]);
    let issued = Event::Issued { code: Switch::On as u16 };
    assert_eq!(camera.events_of(low_serial), [Event::Admitted { tenure: 1 }, issued]);
    assert_eq!(camera.events_of(0), [Event::Vacated { tenure: 2 }, Event::Safed { attempt: 1 }]);
}

#[test]
fn each_record_has_the_time_of_what_it_records() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(1, 0);
    let mut times = Vec::new();
    for _ in 0..3 {
        bench.clock.advance(Duration::from_millis(7));
        times.push(bench.clock.now());
        ticket.invoke(Switch::Blink).unwrap();
    }
    let records = bench.tapes[0].records();
    let issued = records.iter().filter(|record| matches!(record.event, Event::Issued { .. }));
    assert_eq!(issued.map(|record| record.at).collect::<Vec<_>>(), times);
}

#[test]
fn every_command_that_reached_a_driver_is_on_its_tape() {
    let (bench, supervisor) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(1, 0);
    let commands = [Switch::On, Switch::Off, Switch::Fault, Switch::Blink, Switch::Panic];
    for command in commands {
        let _ = ticket.invoke(command);
        bench.broker.reset_gate(&supervisor, bench.lamps[0].gate()).unwrap();
        bench.pass(TICK);
        bench.pass(TICK);
    }
    assert_eq!(bench.commands(0), commands.len());
    let codes: Vec<Event> =
        commands.iter().map(|command| Event::Issued { code: *command as u16 }).collect();
    let issued = bench.tapes[0].events();
    let issued: Vec<Event> =
        issued.into_iter().filter(|event| matches!(event, Event::Issued { .. })).collect();
    assert_eq!(issued, codes);
    let closed = bench.tapes[0].events();
    assert!(closed.contains(&Event::Closed(GateFault::Driver)));
    assert!(closed.contains(&Event::Closed(GateFault::Panicked)));
}

#[test]
fn refused_commands_are_counted_and_recorded_once_at_the_next_locked_step() {
    let (bench, _) = Bench::new(margin(10), &[8]);
    let twice = bench.lamps[0].limited(Function::invocations(2));
    let ticket = bench.broker.request(Priority::SCIENCE, &twice).unwrap();
    for _ in 0..3 {
        ticket.invoke(Switch::Blink).unwrap_err();
    }
    bench.broker.service();
    ticket.invoke(Switch::Blink).unwrap();
    ticket.invoke(Switch::Blink).unwrap();
    ticket.invoke(Switch::Blink).unwrap_err();
    ticket.try_invoke(Switch::Blink).unwrap_err();
    let serial = ticket.id().serial;
    drop(ticket);
    let refused = |events: Vec<Event>| {
        events
            .into_iter()
            .filter(|event| matches!(event, Event::Refused { .. }))
            .collect::<Vec<_>>()
    };
    assert_eq!(refused(bench.tapes[0].events_of(serial)), [Event::Refused { count: 3 }]);
    assert_eq!(refused(bench.tape.events_of(serial)), [Event::Refused { count: 2 }]);
}

#[test]
fn refused_requests_and_extensions_are_recorded() {
    let (bench, _) = Bench::new(margin(10), &[8, 11]);
    let ticket = bench.ticket(1, 0);
    bench.tape.rewind();
    bench.broker.request(Priority::SCIENCE, &bench.lamps[1]).unwrap_err();
    let more = bench.lamps[1].limited(Validity::always());
    bench.broker.extend(&ticket, &more).unwrap_err();
    assert_eq!(bench.tape.events(), [Event::RequestRefused; 2]);
}

#[test]
fn what_a_supervisor_does_is_recorded_and_whom_it_hits() {
    let (bench, supervisor) = Bench::new(margin(20), &[8, 8]);
    let (ticket, other) = (bench.ticket(1, 0), bench.ticket(1, 1));
    bench.tape.rewind();
    let floor = Priority::new(100);
    bench.broker.enter_safe_mode(&supervisor, floor).unwrap().without_waiting();
    bench.broker.service();
    bench.broker.leave_safe_mode(&supervisor).unwrap();
    assert_eq!(
        bench.tape.events_of(0),
        [Event::SafeMode { floor }, Event::SafeModeLeft],
        "and whom it hit:"
    );
    assert_eq!(bench.tape.events_of(ticket.id().serial), [Event::Revoked(Why::RevokedAll)]);
    assert_eq!(bench.tape.events_of(other.id().serial), [Event::Revoked(Why::RevokedAll)]);
    bench.pass(TICK);
    bench.tape.rewind();
    bench.broker.bar(&supervisor, ticket.id()).unwrap().without_waiting();
    bench.broker.service();
    bench.broker.reinstate(&supervisor, ticket.id()).unwrap();
    bench.broker.service();
    let events = bench.tape.events_of(ticket.id().serial);
    assert_eq!(events, [Event::Revoked(Why::Barred), Event::Reinstated, Event::Granted]);
}

#[test]
fn limits_that_run_out_and_supplies_that_change_are_recorded() {
    let (bench, supervisor) = Bench::new(margin(10), &[8]);
    let ticket = bench.ticket(1, 0);
    bench.tape.rewind();
    bench.broker.set_supply(&supervisor, bench.agent, watts(9)).unwrap();
    bench.clock.advance(Duration::from_secs(1));
    bench.broker.service();
    assert_eq!(bench.tape.events_of(0), [Event::Supply { supply: watts(9) }]);
    assert_eq!(bench.tape.events_of(ticket.id().serial), [Event::Ended]);
}

#[test]
fn each_gate_has_a_tape_of_its_own() {
    let mut kit = Kit::new();
    let agent = kit.agent(margin(20));
    kit.lamp(agent, drawing(8));
    kit.lamp(agent, drawing(8));
    let (bench, _) = kit.finish(agent);
    let ticket = bench.ticket(1, 1);
    ticket.invoke(Switch::On).unwrap();
    assert_eq!(bench.tapes[0].events(), []);
    assert_eq!(bench.tapes[1].events_of(ticket.id().serial).len(), 2);
}
