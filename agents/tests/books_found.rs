//! What the random histories and the model found, each as a short history of
//! its own.

#![cfg(not(loom))]

mod books;

use std::sync::atomic::Ordering::Relaxed;

use books::lamp::Switch;
use books::step::{Limit, Step};
use books::world::{Declared, GATES, Ground, Rules, Setup, World};
use faregate_agents::{Ask, Books, Categories, DeviceState, Event, Policy};
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::Profile;
use faregate_tickets::id::{GateId, Priority};
use faregate_tickets::ticket::Holder;
use faregate_tickets::validity::{Function, Validity};

const LAMP: Declared = Declared {
    agent: 0,
    draw: 3,
    categories: 0,
    settling_ms: 0,
    attempts: 2,
    safe_at_once: false,
    safe_unless_held: false,
    on_at_start: false,
};

/// Lives through `story` in a world of equal lamps, all seen off at first.
fn live(rules: Rules, lamp: Declared, story: impl FnOnce(&mut World<'_>)) {
    let setup = Setup { agents: vec![rules], devices: vec![lamp; GATES] };
    let ground = Ground::new(setup);
    let mut gates = ground.gates();
    let mut world = World::new(&ground, &mut gates);
    world.settle();
    story(&mut world);
}

fn margin(supply: u64) -> Rules {
    Rules { supply: Some(supply), ..Rules::default() }
}

fn request(world: &mut World<'_>, gates: &[u8], priority: u8, limit: Limit) -> usize {
    world.apply(&Step::Request { gates: gates.to_vec(), priority, limit });
    *world.grants.last_key_value().unwrap().0
}

fn turn_on(world: &World<'_>, serial: usize) -> bool {
    world.grants[&serial].tickets[0].1.invoke(Switch::On).is_ok()
}

fn is_valid(world: &World<'_>, serial: usize) -> bool {
    world.grants[&serial].tickets.iter().all(|(_, ticket)| ticket.check().is_ok())
}

fn state(world: &World<'_>, gate: u8) -> DeviceState {
    world.books.device_report(GateId(gate)).unwrap().state
}

#[test]
fn who_was_put_out_before_being_admitted_keeps_its_limits() {
    live(margin(9), LAMP, |world| {
        let monitor = request(world, &[0], 0, Limit::Invocations);
        let rescuer = request(world, &[0], 255, Limit::None);
        world.service();
        assert!(is_valid(world, rescuer));
        world.relinquish(rescuer, 0);
        world.settle();
        assert!(turn_on(world, monitor) && turn_on(world, monitor));
        assert!(!turn_on(world, monitor), "two invocations are what it asked for");
    });
}

#[test]
fn a_device_behind_a_gate_that_was_reset_is_made_safe_again() {
    live(margin(3), LAMP, |world| {
        let first = request(world, &[0], 0, Limit::None);
        world.service();
        assert!(turn_on(world, first));
        world.ground.truths[0].deaf_to_safing.store(2, Relaxed);
        let rescuer = request(world, &[1], 255, Limit::None);
        world.relinquish(first, 0);
        world.settle();
        assert_eq!(state(world, 0), DeviceState::Stuck);
        world.apply(&Step::Reset { gate: 0 });
        world.settle();
        assert_eq!(state(world, 0), DeviceState::Off);
        assert!(is_valid(world, rescuer));
    });
}

#[test]
fn a_device_that_something_else_turned_on_is_made_safe_as_often_as_it_takes() {
    live(margin(3), LAMP, |world| {
        let first = request(world, &[0], 0, Limit::None);
        world.service();
        assert!(turn_on(world, first));
        world.relinquish(first, 0);
        let second = request(world, &[1], 0, Limit::None);
        for _ in 0..3 {
            world.ground.truths[0].deaf_to_safing.store(1, Relaxed);
            world.settle();
            assert!(is_valid(world, second));
            world.apply(&Step::Unbidden { gate: 0 });
            world.settle();
            assert_eq!(state(world, 0), DeviceState::Off);
        }
    });
}

#[test]
fn a_set_becomes_valid_without_the_gate_that_was_given_back_meanwhile() {
    live(margin(9), LAMP, |world| {
        let set = request(world, &[0, 1], 0, Limit::None);
        let work = world.books.work().unwrap();
        let done = world.perform(&work);
        world.report(done);
        world.relinquish(set, 1);
        world.settle();
        assert!(is_valid(world, set));
    });
}

#[test]
fn who_rests_is_back_in_line_when_another_takes_the_device() {
    live(margin(9), LAMP, |world| {
        let rests = request(world, &[0], 0, Limit::DutyCycle);
        world.service();
        assert!(turn_on(world, rests));
        world.ground.truths[0].deaf_to_safing.store(9, Relaxed);
        world.ground.clock.advance(Duration::from_millis(6));
        world.settle();
        assert_eq!(state(world, 0), DeviceState::Stuck);
        let other = request(world, &[0], 0, Limit::None);
        world.settle();
        assert!(is_valid(world, other) && !is_valid(world, rests));
        world.relinquish(other, 0);
        world.settle();
        assert!(is_valid(world, rests));
    });
}

#[test]
fn a_set_rests_no_longer_than_it_has_the_gate() {
    live(margin(9), LAMP, |world| {
        let set = request(world, &[0, 1], 0, Limit::DutyCycle);
        world.service();
        assert!(turn_on(world, set));
        world.ground.clock.advance(Duration::from_millis(6));
        world.service();
        assert!(world.grants[&set].resting);
        world.relinquish(set, 0);
        world.settle();
        assert!(is_valid(world, set));
    });
}

#[test]
fn no_gate_of_a_set_is_valid_before_the_others() {
    live(margin(9), LAMP, |world| {
        let set = request(world, &[0, 1], 64, Limit::None);
        world.service();
        world.ground.scopes[0].revoke_all();
        while !matches!(world.books.work(), Ok(faregate_agents::Work::Admit { .. })) {
            if let Ok(work) = world.books.work() {
                let done = world.perform(&work);
                world.report(done);
            }
            world.look();
            let now = world.measure(GateId(0));
            world.ground.clock.advance(Duration::from_millis(1));
            world.observe(GateId(0), now);
        }
        let work = world.books.work().unwrap();
        let done = world.perform(&work);
        assert!(world.grants[&set].tickets.iter().all(|(_, ticket)| ticket.check().is_err()));
        world.report(done);
        world.settle();
        assert!(is_valid(world, set));
    });
}

#[test]
fn an_orphan_at_the_start_is_made_safe_if_its_gate_says_so() {
    let lamp = Declared { safe_at_once: true, on_at_start: true, ..LAMP };
    live(margin(99), lamp, |world| {
        assert!(!world.ground.truths[0].draws(world.now()));
        assert_eq!(world.books.charged(0).get(), 0);
    });
}

#[test]
fn a_measurement_from_the_future_says_nothing() {
    let lamp = Declared { on_at_start: true, ..LAMP };
    live(margin(99), lamp, |world| {
        let mut lie = world.measure(GateId(0));
        lie.state = faregate_tickets::device::Power::Off;
        lie.measured_at = world.now().after(Duration::from_secs(1));
        world.observe(GateId(0), lie);
        assert_eq!(state(world, 0), DeviceState::Orphaned);
    });
}

#[test]
fn the_exempt_ticket_survives_the_moment_between_floor_and_epoch() {
    live(margin(9), LAMP, |world| {
        let mine = request(world, &[0], 0, Limit::None);
        world.service();
        let ticket = &world.grants[&mine].tickets[0].1;
        assert!(ticket.revoke_all_but_me(&world.ground.broker, World::priority(64)));
        // The service read the epoch before its increment, and the floor after
        // it was set.
        let mut broker = world.ground.broker.read();
        broker.epoch -= 1;
        let mut agents = [faregate_tickets::scope::Seen { epoch: 1, floor: 0 }; 8];
        agents[0] = world.ground.scopes[0].read();
        world.feed(faregate_agents::Event::Noticed { broker, agents, survivors: 1 });
        assert!(is_valid(world, mine));
        world.settle();
        assert!(is_valid(world, mine));
    });
}

#[test]
fn what_was_seen_on_stays_charged_when_its_holder_leaves_it() {
    live(margin(9), LAMP, |world| {
        let quiet = request(world, &[0], 0, Limit::None);
        world.settle();
        world.apply(&Step::Unbidden { gate: 0 });
        world.settle();
        assert!(is_valid(world, quiet), "which never commanded anything");
        world.relinquish(quiet, 0);
        world.service();
        assert_eq!(world.books.charged(0).get(), LAMP.draw);
    });
}

#[test]
fn each_ticket_whose_time_is_over_is_reported_once_however_many_there_are() {
    let mut books = Box::new(Books::<4, 256, 16>::new(Instant::START));
    let mut actions = faregate_agents::Actions::default();
    let agent = books.add_agent(Policy::unlimited()).unwrap();
    let gates = [(); 3].map(|()| books.add_gate(agent, Profile::new(), Categories::NONE).unwrap());
    let ask = |gate| Ask::new(Priority::EMERGENCY, gate, Validity::always());
    let holders = gates.map(|gate| books.request(&ask(gate), &mut actions).unwrap());
    let window: Validity = Function::window(Instant::START, Instant::from_micros(10)).into();
    let short = |gate| Ask::new(Priority::EMERGENCY, gate, window);
    for _ in 0..64 {
        books.request(&short(gates[0]), &mut actions).unwrap();
    }
    for _ in 0..16 {
        books.request(&short(gates[1]).and(gates[2], window).unwrap(), &mut actions).unwrap();
    }
    for (gate, holder) in gates.iter().zip(holders) {
        books.relinquished(holder, *gate, Holder::Lives, &mut actions);
    }
    let taken = 256 - books.free_seats();
    let mut ended = 0;
    for _ in 0..80 {
        books.step(Event::Tick(Instant::from_micros(20)), &mut actions);
        ended += actions.ended.len();
    }
    assert_eq!((taken, ended, books.free_seats()), (80, 80, 256));
}

#[test]
fn what_was_owed_before_a_reset_is_not_owed_after_it() {
    let lamp = |draw| Declared { draw, attempts: 1, ..LAMP };
    let setup = Setup { agents: vec![margin(12)], devices: [3, 6, 4, 2].map(lamp).to_vec() };
    let ground = Ground::new(setup);
    let mut gates = ground.gates();
    let mut world = World::new(&ground, &mut gates);
    world.settle();
    request(&mut world, &[2], 255, Limit::None);
    let first = request(&mut world, &[0], 255, Limit::None);
    world.service();
    assert!(turn_on(&world, first));
    request(&mut world, &[1], 65, Limit::None);
    let ticket = world.grants.keys().position(|serial| *serial == first).unwrap();
    world.apply(&Step::DriverFault { ticket: u8::try_from(ticket).unwrap() });
    world.service();
    // While the first one's gate is faulted, the room is owed to the third;
    // from its reset on it is the first one's, and leaves some for this one.
    let last = request(&mut world, &[3], 0, Limit::None);
    world.service();
    assert!(!is_valid(&world, last));
    world.apply(&Step::Reset { gate: 0 });
    world.settle();
    assert!(is_valid(&world, first) && is_valid(&world, last));
}
