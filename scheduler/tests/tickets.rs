//! The ticket port on a real broker: a task is a device.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

#[path = "tickets/rig.rs"]
mod rig;

use std::sync::atomic::Ordering::SeqCst;
use std::time::Instant;

use faregate_scheduler::manager::Event;
use faregate_scheduler::tickets::{MOST_GATES, SLOTS};
use faregate_scheduler::time::Duration;
use faregate_tickets::id::Priority;
use rig::{Needing, Rig, needs, task};

fn task_1_has_a_camera() -> Rig {
    let mut rig = Rig::new(&["camera"]);
    rig.run(1, &needs(5).commanding(&["camera"]));
    rig
}

#[test]
fn who_takes_a_category_is_granted_it_when_the_task_that_had_it_has_stopped() {
    let mut rig = Rig::new(&[]);
    rig.run(1, &needs(1).using(3));
    rig.request(2, &needs(9).using(3), &[1]);
    rig.taken(1, "task 2");
    rig.nothing_is_told();
    rig.stop(1);
    rig.granted(2);
    rig.nothing_is_told();
}

#[test]
fn what_nothing_stands_in_the_way_of_is_granted_in_the_next_turn() {
    let mut rig = Rig::new(&["camera"]);
    rig.until("the camera is seen off", |rig| rig.charged() == 0);
    for number in 1..=30 {
        let gates = if number == 7 { &["camera"][..] } else { &[] };
        rig.request(number, &needs(5).using(number).drawing(1).commanding(gates), &[]);
        rig.turn();
        assert_eq!(rig.events, [Event::Granted { occurrence: task(number) }]);
        rig.events.clear();
        rig.start(number);
    }
}

#[test]
fn a_task_whose_tickets_were_taken_gets_them_back_without_asking() {
    let mut rig = Rig::new(&[]);
    rig.run(1, &needs(1).using(3).drawing(30));
    rig.request(2, &needs(9).drawing(20), &[1]);
    rig.taken(1, "task 2");
    rig.stop(1);
    rig.granted_and_done(2);
    rig.granted(1);
}

#[test]
fn a_task_that_is_still_being_stopped_is_not_told_that_it_may_go_on() {
    let mut rig = Rig::new(&[]);
    rig.run(1, &needs(1).using(3));
    rig.request(2, &needs(9).using(3), &[1]);
    rig.taken(1, "task 2");
    rig.relinquish(2);
    rig.nothing_is_told();
    rig.stop(1);
    rig.granted(1);
}

#[test]
fn between_equals_the_managers_word_counts_and_not_who_asked_first() {
    let mut rig = Rig::new(&[]);
    rig.run(1, &needs(5).using(3));
    rig.request(2, &needs(5).using(3), &[1]);
    rig.taken(1, "task 2");
    rig.nothing_is_told();
    rig.stop(1);
    rig.granted_and_done(2);
    rig.granted(1);
}

/// The control: an equal that is nobody's victim keeps what it has.
#[test]
fn an_equal_that_is_no_victim_keeps_its_tickets() {
    let mut rig = Rig::new(&[]);
    rig.run(1, &needs(5).using(3));
    rig.request(2, &needs(5).using(3), &[]);
    rig.nothing_is_told();
    rig.end(1);
    rig.granted(2);
}

/// What it has lost already cannot be taken again: it keeps its turn.
#[test]
fn a_victim_that_somebody_else_has_taken_already_keeps_its_turn() {
    let mut rig = Rig::new(&[]);
    rig.run(1, &needs(5).using(3));
    rig.request(2, &needs(9).using(3), &[1]);
    rig.taken(1, "task 2");
    rig.request(3, &needs(5).using(3), &[1]);
    rig.stop(1);
    rig.granted_and_done(2);
    rig.granted(1);
}

#[test]
fn a_victim_is_not_granted_again_before_its_taker() {
    let mut rig = Rig::new(&[]);
    rig.run(1, &needs(5).drawing(30));
    rig.run(2, &needs(5).using(3));
    rig.request(3, &needs(5).drawing(30).using(3), &[1, 2]);
    rig.taken(1, "task 3");
    rig.taken(2, "task 3");
    rig.stop(1);
    // Nobody draws anything now, and yet.
    rig.nothing_is_told();
    rig.stop(2);
    rig.granted(3);
}

#[test]
fn the_place_of_a_task_that_ended_is_free_for_the_next() {
    let mut rig = Rig::new(&[]);
    for number in 1..=3 * u32::try_from(SLOTS).unwrap() {
        rig.run(number, &needs(5).using(3).drawing(40));
        rig.end(number);
    }
    rig.until("nothing is charged", |rig| rig.charged() == 0);
}

#[test]
fn when_all_places_are_taken_a_request_says_so_and_waits_for_one() {
    let mut rig = Rig::new(&[]);
    let slots = u32::try_from(SLOTS).unwrap();
    for number in 1..=slots {
        rig.run(number, &needs(5));
    }
    rig.request(slots + 1, &needs(6), &[]);
    assert_eq!(rig.why(slots + 1), format!("all {SLOTS} places for tasks are taken"));
    rig.nothing_is_told();
    rig.end(7);
    rig.granted(slots + 1);
}

#[test]
fn a_request_that_can_never_be_granted_is_refused() {
    let mut rig = Rig::new(&["camera"]);
    rig.request(1, &needs(5).drawing(43), &[]);
    assert_eq!(rig.why(1), "it would draw 43 W, and the supply is 42 W at most");
    rig.request(2, &needs(5).drawing(35).commanding(&["camera"]), &[]);
    assert_eq!(rig.why(2), "it would draw 43 W, and the supply is 42 W at most");
    rig.request(3, &needs(5).commanding(&["heater"]), &[]);
    assert_eq!(rig.why(3), "the mission has no gate `heater`");
    // Nothing is left behind.
    rig.run(1, &needs(5).drawing(42));
}

#[test]
fn a_task_that_commands_more_gates_than_fit_one_request_is_refused() {
    let names: Vec<String> = (0..=MOST_GATES).map(|number| format!("lamp {number}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut rig = Rig::new(&names);
    rig.request(1, &needs(5).commanding(&names), &[]);
    let expected = format!("it commands {} gates, and a task can command 7", MOST_GATES + 1);
    assert_eq!(rig.why(1), expected);
}

#[test]
fn a_task_commands_its_gates_and_no_others() {
    let mut rig = Rig::new(&["camera", "heater"]);
    rig.run(1, &needs(5).commanding(&["camera", "camera"]));
    assert_eq!(rig.command(1, "camera", "on"), Ok(String::new()));
    assert!(rig.is_on("camera"));
    let refused = |gate, command| rig.command(1, gate, command).unwrap_err();
    let mine = "NotItsGate: task 1 did not say that it commands `heater`: name it among its gates";
    assert_eq!(refused("heater", "on"), mine);
    let none = "NoSuchGate: the mission has no gate `radio`; it has camera, heater";
    assert_eq!(refused("radio", "on"), none);
    let bad = "BadCommand: camera: it has no command `expose`; it has on, off, break";
    assert_eq!(refused("camera", "expose"), bad);
    assert_eq!(refused("camera", "break"), "Fault: camera failed: \"its filament broke\"");
}

#[test]
fn the_commands_of_a_task_are_refused_with_the_name_of_the_taker() {
    let mut rig = task_1_has_a_camera();
    rig.command(1, "camera", "on").unwrap();
    rig.request(2, &needs(200).commanding(&["camera"]), &[1]);
    // At once: nobody has told the manager yet.
    let taken = "Taken: the ticket is not valid: taken by task 2 at priority 200";
    assert_eq!(rig.command(1, "camera", "on"), Err(taken.to_owned()));
    assert_eq!(rig.taker(1, "camera"), Some("task 2".to_owned()));
    rig.taken(1, "task 2");
    rig.stop(1);
    rig.granted(2);
    rig.start(2);
    assert_eq!(rig.command(1, "camera", "off"), Err(taken.to_owned()));
    rig.command(2, "camera", "off").unwrap();
    rig.end(2);
    rig.granted(1);
    assert_eq!(rig.command(1, "camera", "on"), Ok(String::new()));
}

#[test]
fn the_commands_of_an_equal_that_was_chosen_as_a_victim_name_the_taker_too() {
    let mut rig = task_1_has_a_camera();
    rig.request(2, &needs(5).commanding(&["camera"]), &[1]);
    let taken = "Taken: the ticket is not valid: taken by task 2";
    assert_eq!(rig.command(1, "camera", "on"), Err(taken.to_owned()));
    assert_eq!(rig.taker(1, "camera"), Some("task 2".to_owned()));
}

#[test]
fn the_commands_of_an_attempt_that_is_over_are_refused() {
    let mut rig = task_1_has_a_camera();
    rig.command(1, "camera", "on").unwrap();
    rig.end(1);
    let over = Err("Over: task 1 attempt 1 is over, or has no tickets".to_owned());
    assert_eq!(rig.command(1, "camera", "on"), over);
}

#[test]
fn the_next_attempt_has_the_tickets_and_the_one_before_has_nothing() {
    let mut rig = task_1_has_a_camera();
    rig.stop(1);
    let second = faregate_scheduler::manager::Attempt { number: 2, ..rig::attempt(1) };
    faregate_scheduler::executive::TicketPort::started(
        &mut rig.tickets,
        second,
        faregate_scheduler::time::Now::default(),
    );
    let over = Err("Over: task 1 attempt 1 is over, or has no tickets".to_owned());
    assert_eq!(rig.command(1, "camera", "on"), over);
    rig.nothing_is_told();
}

#[test]
fn a_device_that_a_dead_task_left_on_is_off_before_its_margin_is_anothers() {
    let mut rig = Rig::new(&["camera"]);
    rig.run(1, &needs(5).drawing(34).commanding(&["camera"]));
    rig.command(1, "camera", "on").unwrap();
    rig.end(1);
    rig.request(2, &needs(1).drawing(42), &[]);
    rig.granted(2);
    assert!(!rig.is_on("camera"));
}

#[test]
fn the_devices_of_a_task_that_stands_still_are_made_safe_and_stay_off() {
    let mut rig = Rig::new(&["camera"]);
    rig.run(1, &needs(1).using(3).commanding(&["camera"]));
    rig.command(1, "camera", "on").unwrap();
    // It needs nothing that the camera has, and there is draw for both.
    rig.request(2, &needs(9).using(3), &[1]);
    rig.taken(1, "task 2");
    rig.until("the camera is off", |rig| !rig.is_on("camera"));
    rig.stop(1);
    rig.granted_and_done(2);
    rig.granted(1);
    assert!(!rig.is_on("camera"), "who goes on turns it on itself");
}

#[test]
fn a_device_that_was_left_on_before_is_made_safe_at_the_start() {
    let mut rig = Rig::on_at_start(&["camera"]);
    rig.until("the camera is off", |rig| !rig.is_on("camera"));
}

#[test]
fn a_mode_takes_its_gates_from_everybody_and_leaves_their_devices_off() {
    let mut rig = Rig::new(&["camera", "heater"]);
    rig.run(1, &needs(239).commanding(&["camera"]));
    rig.command(1, "camera", "on").unwrap();
    rig.reserve("eclipse", &["camera"]);
    rig.taken(1, "mode eclipse");
    rig.until("the camera is off", |rig| !rig.is_on("camera"));
    rig.stop(1);
    assert_eq!(rig.why(1), "camera is taken by mode eclipse");
    rig.nothing_is_told();
    let refused = rig.command(1, "camera", "on").unwrap_err();
    assert_eq!(refused, "Taken: the ticket is not valid: taken by mode eclipse at priority 240");
    rig.request(2, &needs(239).commanding(&["heater"]), &[]);
    rig.granted(2);
    rig.request(3, &needs(239).commanding(&["camera"]), &[]);
    assert_eq!(rig.why(3), "camera is taken by mode eclipse");
    rig.unreserve("eclipse");
    rig.granted(1);
    assert!(!rig.is_on("camera"), "nobody turned it on again");
}

#[test]
fn a_gate_that_is_faulted_is_waited_for_and_named() {
    let mut rig = task_1_has_a_camera();
    rig.command(1, "camera", "break").unwrap_err();
    rig.taken(1, "its gate is faulted");
    rig.stop(1);
    assert_eq!(rig.why(1), "camera is faulted: its driver reported a fault");
    let gate = rig.commander.gates().id("camera").unwrap();
    let agents = rig.tickets.broker().agents();
    agents.reset_gate(&rig.supervisor, gate).unwrap();
    rig.granted(1);
}

#[test]
fn safe_mode_takes_every_task_and_gives_them_back() {
    let mut rig = Rig::new(&[]);
    rig.run(1, &needs(239).using(3));
    rig.run(2, &needs(5).using(4));
    let agents = rig.tickets.broker().agents();
    agents.enter_safe_mode(&rig.supervisor, Priority::FAULT_RESPONSE).unwrap().without_waiting();
    let by = "all tickets were revoked";
    for number in [1, 2] {
        let safe = |event: &Event| {
            matches!(event, Event::Taken { occurrence, by: who }
                if *occurrence == task(number) && (who == by || who == "safe mode"))
        };
        rig.told_one(safe, "taken by safe mode");
        rig.stop(number);
    }
    assert_eq!(rig.why(1), "safe mode: nothing below priority 240");
    agents.leave_safe_mode(&rig.supervisor).unwrap();
    rig.granted(1);
    rig.granted(2);
}

#[test]
fn a_task_hears_that_its_tickets_were_gone_even_if_they_are_back() {
    let mut rig = task_1_has_a_camera();
    rig.request(2, &needs(200).commanding(&["camera"]), &[]);
    rig.relinquish(2);
    // Nobody asks the port meanwhile.
    while rig.command(1, "camera", "on").is_err() {
        std::thread::yield_now();
    }
    rig.taken(1, "somebody, for a moment");
    rig.nothing_is_told();
    rig.stop(1);
    rig.granted(1);
}

#[test]
fn leases_are_renewed_as_long_as_the_port_takes_its_turns() {
    const TRIES: usize = 20;
    let lease = Duration::from_millis(600);
    for _ in 0..TRIES {
        let mut rig = Rig::with_lease(&["camera"], lease);
        rig.run(1, &needs(5).commanding(&["camera"]));
        rig.command(1, "camera", "on").unwrap();
        let (begun, mut latest) = (Instant::now(), Instant::now());
        let mut longest = std::time::Duration::ZERO;
        while begun.elapsed() < std::time::Duration::from(lease) * 3 {
            rig.turn();
            rig.sleep();
            longest = longest.max(std::mem::replace(&mut latest, Instant::now()).elapsed());
        }
        // Turns that came so seldom say nothing about the port.
        if longest < std::time::Duration::from(lease) / 4 {
            assert!(rig.is_on("camera") && rig.events.is_empty(), "{:?}", rig.events);
            return;
        }
    }
    eprintln!("this machine is too busy to tell");
}

/// The control: a manager that is gone renews nothing.
#[test]
fn a_device_goes_off_when_the_manager_is_gone() {
    let mut rig = Rig::with_lease(&["camera"], Duration::from_millis(50));
    rig.run(1, &needs(5).commanding(&["camera"]));
    rig.command(1, "camera", "on").unwrap();
    while rig.is_on("camera") {
        std::thread::yield_now();
    }
    // It comes back: the task is told, and asks anew.
    rig.taken(1, "it has expired; request a new one");
    rig.stop(1);
    rig.granted(1);
}

#[test]
fn a_worker_inside_a_slow_command_holds_up_nobody() {
    let mut rig = task_1_has_a_camera();
    rig.lamps["camera"].slow.store(true, SeqCst);
    let commander = rig.commander.clone();
    let worker = std::thread::spawn(move || {
        use faregate_scheduler::executive::Commands as _;
        commander.command(rig::attempt(1), "camera", "on", &[])
    });
    while !rig.lamps["camera"].inside.load(SeqCst) {
        std::thread::yield_now();
    }
    // Each of these would wait for ever.
    rig.end(1);
    rig.request(2, &needs(5).drawing(34), &[]);
    rig.granted(2);
    rig.request(3, &needs(5).commanding(&["camera"]), &[]);
    assert_eq!(rig.why(3), "camera is taken by task 1");
    rig.nothing_is_told();
    rig.lamps["camera"].slow.store(false, SeqCst);
    worker.join().unwrap().unwrap();
    rig.granted(3);
}
