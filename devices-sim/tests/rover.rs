//! The simulated rover: what it does by itself, and to the digit.

use faregate_devices_sim::SimClock;
use faregate_devices_sim::rover::{
    ComputerMode, Rover, RoverCommand, RoverEvent, RoverFault, RoverModel, RoverScript, RunSpec,
    WindowModel, ZoneModel,
};
use faregate_tickets::Device;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Clock, Duration, Instant};

const fn at(s: u64) -> Instant {
    Instant::from_micros(s * 1_000_000)
}

fn watts(w: u32) -> Milliwatts {
    Milliwatts::from_watts(w)
}

fn sequence(s: u64) -> RunSpec {
    RunSpec {
        place: 0,
        length: Duration::from_secs(s),
        ending: Duration::from_secs(3),
        succeeds: true,
        average: watts(30),
        peak: watts(50),
        engines: 1,
        data: 1_000,
        zones: Vec::new(),
    }
}

struct Bench {
    clock: SimClock,
    rover: Rover,
}

impl Bench {
    fn new(model: RoverModel, script: Vec<RoverFault>) -> Self {
        let clock = SimClock::virtual_time();
        let rover = Rover::new(model, RoverScript(script), 7, &clock);
        Self { clock, rover }
    }

    fn awake(mut model: RoverModel, script: Vec<RoverFault>) -> Self {
        model.computer.is_awake = true;
        Self::new(model, script)
    }

    fn to(&self, s: u64) {
        self.clock.advance_to(at(s));
    }

    fn charge(&self) -> u64 {
        self.rover.truth().charge.get()
    }
}

#[test]
fn charge_is_exact_whoever_looks() {
    let [often, once] = [(); 2].map(|()| Bench::awake(RoverModel::default(), Vec::new()));
    for bench in [&often, &once] {
        bench.rover.start(1, sequence(600));
    }
    for s in 0..1_000 {
        often.to(s);
        let _ = often.rover.truth();
    }
    often.to(1_000);
    once.to(1_000);
    assert_eq!(often.rover.truth(), once.rover.truth());
    let stored = RoverModel::default().stored.get();
    // 110 W in; 45 W base, 90 W computer, 30 W for 600 s out.
    let out = (45 + 90 - 110) * 1_000 + 30 * 600;
    assert_eq!(stored - often.charge(), out * 1_000_000);
}

#[test]
fn a_full_battery_takes_no_more() {
    let model = RoverModel::default();
    let full = RoverModel { stored: model.capacity, ..model };
    let bench = Bench::new(full.clone(), Vec::new());
    bench.to(1_000);
    assert_eq!(bench.charge(), full.capacity.get());
}

#[test]
fn a_sequence_stops_when_its_place_is_made_safe_and_goes_on_where_it_stopped() {
    let bench = Bench::awake(RoverModel::default(), Vec::new());
    let mut place = bench.rover.place_driver(0).unwrap();
    bench.rover.start(1, sequence(100));
    bench.to(40);
    place.safe().unwrap();
    bench.to(500);
    assert_eq!(bench.rover.data_of(1), 400);
    bench.rover.resume(1);
    bench.to(559);
    assert_eq!(bench.rover.truth().engines, 1);
    bench.to(560);
    let events = bench.rover.take_events();
    let done = RoverEvent::Finished { key: 1, succeeded: true, data: 1_000 };
    assert!(events.contains(&(at(40), RoverEvent::Stopped(1))), "{events:?}");
    assert!(events.contains(&(at(560), done)), "{events:?}");
}

#[test]
fn a_sequence_that_is_told_to_end_ends_in_its_own_time() {
    let bench = Bench::awake(RoverModel::default(), Vec::new());
    bench.rover.start(1, sequence(100));
    bench.to(50);
    bench.rover.tell_to_end(1);
    bench.to(100);
    let finished = RoverEvent::Finished { key: 1, succeeded: true, data: 530 };
    assert!(bench.rover.take_events().contains(&(at(53), finished)));
}

fn zone() -> ZoneModel {
    ZoneModel {
        heater: watts(20),
        peak: watts(25),
        needed: -40_000,
        warms: 100,
        cools: 10,
        surroundings: vec![(Duration::ZERO, -90_000), (Duration::from_secs(10_000), -60_000)],
    }
}

#[test]
fn a_zone_warms_and_cools_in_straight_lines() {
    let bench = Bench::awake(RoverModel { zones: vec![zone()], ..Default::default() }, Vec::new());
    let mut heater = bench.rover.heater_driver(0).unwrap();
    heater.issue(RoverCommand::Drawing(watts(25))).unwrap();
    let temperature = |s| {
        bench.to(s);
        bench.rover.truth().zones[0].temperature
    };
    assert_eq!(temperature(250), -65_000);
    assert_eq!(temperature(500), -40_000);
    assert_eq!(temperature(600), -35_000, "a thermostat keeps it there");
    heater.issue(RoverCommand::Off).unwrap();
    assert_eq!(temperature(700), -36_000);
    assert_eq!(temperature(9_000), -90_000);
    assert_eq!(temperature(11_000), -80_000, "noon");
    assert_eq!(temperature(20_000), -60_000);
}

#[test]
fn a_dead_heater_draws_and_heats_nothing() {
    let dead = RoverFault::HeaterDead { zone: 0, from: at(100), until: at(200) };
    let bench = Bench::awake(RoverModel { zones: vec![zone()], ..Default::default() }, vec![dead]);
    let mut heater = bench.rover.heater_driver(0).unwrap();
    heater.issue(RoverCommand::On).unwrap();
    bench.to(100);
    assert_eq!(bench.rover.truth().peak, watts(110), "the computer alone");
    bench.to(200);
    // Warmed for 100 s, and did not quite cool for as long.
    assert_eq!(bench.rover.truth().zones[0].temperature, -81_000);
    assert_eq!(bench.rover.truth().peak, watts(135));
}

#[test]
fn what_the_sensors_say_is_late_and_noisy_and_nothing_in_sleep() {
    let bench = Bench::awake(RoverModel::default(), Vec::new());
    bench.to(31);
    assert_eq!(bench.rover.charge().unwrap().measured_at, at(0), "still on its way");
    bench.to(32);
    let told = bench.rover.charge().unwrap();
    assert_eq!(told.measured_at, at(30));
    let noise = RoverModel::default().senses.charge_noise.get();
    assert!(told.value.get().abs_diff(bench.charge()) <= noise + 60_000_000);
    assert_ne!(told.value.get(), bench.charge());
    let mut computer = bench.rover.computer_driver().unwrap();
    computer.issue(RoverCommand::Off).unwrap();
    bench.to(10_000);
    assert_eq!(bench.rover.charge(), Some(told));
    assert_eq!(bench.rover.truth().mode, ComputerMode::Asleep);
}

#[test]
fn windows_open_by_themselves_and_a_cancelled_one_does_not() {
    let window = WindowModel {
        start: at(100),
        end: at(200),
        average: watts(40),
        peak: watts(60),
        data: -5_000,
    };
    let later = WindowModel { start: at(300), end: at(400), ..window };
    let cancelled = RoverFault::Window { at: at(50), index: 1, becomes: None };
    let model = RoverModel { windows: vec![window, later], ..Default::default() };
    let bench = Bench::new(model, vec![cancelled]);
    bench.to(150);
    assert_eq!(bench.rover.truth().load, watts(40));
    bench.to(500);
    assert_eq!(bench.rover.truth().data, -5_000);
    let events = bench.rover.take_events();
    let opened = events.iter().filter(|(_, event)| matches!(event, RoverEvent::Window { .. }));
    assert_eq!(opened.count(), 2);
}

#[test]
fn nothing_that_needs_the_computer_outlives_it() {
    let model = RoverModel { zones: vec![zone()], ..Default::default() };
    let bench = Bench::awake(model, Vec::new());
    let mut heater = bench.rover.heater_driver(0).unwrap();
    let mut computer = bench.rover.computer_driver().unwrap();
    heater.issue(RoverCommand::On).unwrap();
    bench.rover.start(1, sequence(100));
    bench.to(10);
    computer.issue(RoverCommand::Off).unwrap();
    bench.to(1_000);
    let truth = bench.rover.truth();
    assert!(!truth.zones[0].heater_on);
    assert_eq!(truth.load, Milliwatts::ZERO);
    assert_eq!(heater.issue(RoverCommand::On), Ok(()), "the switch takes it");
    assert!(!bench.rover.truth().zones[0].heater_on, "and it goes off again");
}

#[test]
fn lost_charge_and_unplanned_loads_are_in_the_sum() {
    let energy = Microjoules::from_joules(1_000);
    let script = vec![
        RoverFault::Discharge { at: at(10), energy },
        RoverFault::Drain { from: at(20), until: at(30), load: watts(100) },
    ];
    let bench = Bench::new(RoverModel::default(), script);
    bench.to(40);
    let stored = RoverModel::default().stored.get();
    let expected = stored + (40 * (110 - 45) - 1_000 - 10 * 100) * 1_000_000;
    assert_eq!(bench.charge(), expected);
    assert_eq!(bench.clock.now(), at(40));
}
