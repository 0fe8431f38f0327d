//! The payload: what its units draw and make, and when its bus trips. On a
//! plain virtual clock; a command's time passes when it is given.

use std::collections::BTreeMap;

use faregate_devices_sim::payload::{
    BatteryModel, KINDS, Payload, Supplies, UnitCommand, UnitDriver, UnitSpec, UnitTruth,
};
use faregate_devices_sim::{Law, Outcome, SimClock};
use faregate_tickets::Device;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Effect, Power};
use proptest::prelude::*;

fn settings(given: &[(&str, &str)]) -> BTreeMap<String, String> {
    given.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect()
}

fn spec(name: &str, kind: &str, given: &[(&str, &str)]) -> UnitSpec {
    UnitSpec::new(name, kind, None, &settings(given)).unwrap()
}

fn payload(watts: u32, specs: Vec<UnitSpec>) -> Payload {
    let clock = SimClock::virtual_time();
    Payload::new(Supplies::of(Milliwatts::from_watts(watts)), specs, 1, &clock)
}

fn give(driver: &mut UnitDriver, command: &str) {
    let mut words = command.split_whitespace().map(String::from);
    let name = words.next().unwrap();
    let arguments: Vec<String> = words.collect();
    let command = driver.parse(&name, &arguments).unwrap();
    assert_eq!(driver.issue(command), Ok(()));
}

fn pass(payload: &Payload, ms: u64) {
    payload.clock().advance_to(payload.clock().now().after(Duration::from_millis(ms)));
}

fn unit(payload: &Payload, name: &str) -> UnitTruth {
    payload.truth().units.into_iter().find(|unit| unit.name == name).unwrap()
}

fn watts(watts: u32) -> Milliwatts {
    Milliwatts::from_watts(watts)
}

#[test]
fn every_kind_can_be_made_and_commanded_on_within_what_it_declares() {
    for kind in KINDS {
        let payload = payload(100, vec![spec("it", kind, &[])]);
        let mut driver = payload.driver("it").unwrap();
        assert!(payload.driver("it").is_none(), "there is one driver of a {kind}");
        let on = driver.parse("on", &[]).unwrap();
        assert_eq!(on.declaration().effect, Effect::on(driver.profile().draw));
        give(&mut driver, "on");
        assert!(unit(&payload, "it").on);
        driver.safe().unwrap();
        assert_eq!(unit(&payload, "it").draw, Milliwatts::ZERO, "a {kind} that is safe draws");
        let last = payload.trace().pop().unwrap();
        assert!(last.safing);
        assert_eq!(last.outcome, Outcome::Took);
    }
}

#[test]
fn a_draw_over_the_limit_trips_the_bus_after_its_time_and_nothing_is_taken_any_more() {
    let draw = [("draw_w", "25"), ("inrush_w", "25")];
    let payload = payload(42, vec![spec("a", "camera", &draw), spec("b", "camera", &draw)]);
    let (mut a, mut b) = (payload.driver("a").unwrap(), payload.driver("b").unwrap());
    give(&mut a, "on");
    pass(&payload, 1_000);
    assert_eq!(payload.broken_law(), None);
    give(&mut b, "on");
    let overdrawn = payload.clock().now();
    pass(&payload, 5);
    assert_eq!(payload.broken_law(), None, "borne for the trip time");
    pass(&payload, 1);
    let law = Law::BusTripped { draw: watts(50), supply: watts(42) };
    assert_eq!(payload.broken_law(), Some((overdrawn.after(Duration::from_micros(5_001)), law)));
    assert_eq!(payload.truth().largest_draw, watts(50));
    let expose = a.parse("expose", &[]).unwrap();
    assert!(a.issue(expose).is_err(), "a dead bus takes no command");
}

#[test]
fn what_else_draws_from_the_bus_counts() {
    let payload = payload(10, vec![]);
    payload.set_other_draw(watts(10));
    pass(&payload, 1_000);
    assert_eq!(payload.broken_law(), None);
    assert_eq!(payload.truth().energy, Microjoules::from_joules(10));
    payload.set_other_draw(watts(11));
    pass(&payload, 1_000);
    assert!(payload.broken_law().is_some());
}

#[test]
fn an_exposure_that_is_cut_short_is_lost() {
    let payload = payload(42, vec![spec("camera", "camera", &[("exposure_s", "0.4")])]);
    let mut camera = payload.driver("camera").unwrap();
    give(&mut camera, "expose");
    assert_eq!(payload.trace()[0].outcome, Outcome::NoEffect, "it is off");
    give(&mut camera, "on");
    give(&mut camera, "expose");
    pass(&payload, 400);
    give(&mut camera, "expose");
    pass(&payload, 100);
    give(&mut camera, "off");
    let camera = unit(&payload, "camera");
    assert_eq!((camera.finished, camera.lost), (1, 1));
}

#[test]
fn an_estimate_is_as_old_as_the_sensor_lags() {
    let lag = [("sensor_lag_s", "2"), ("sensor_period_s", "0.1")];
    let payload = payload(42, vec![spec("heater", "heater", &lag)]);
    let mut heater = payload.driver("heater").unwrap();
    assert_eq!(payload.estimate("heater"), None, "no measurement has arrived");
    pass(&payload, 5_000);
    give(&mut heater, "on");
    let on_since = payload.clock().now();
    pass(&payload, 1_900);
    assert_eq!(payload.estimate("heater").unwrap().state, Power::Off);
    pass(&payload, 201);
    let estimate = payload.estimate("heater").unwrap();
    assert_eq!(estimate.state, Power::On);
    assert!(estimate.measured_at >= on_since);
    assert!(estimate.measured_at.after(Duration::from_secs(2)) <= payload.clock().now());
    let profile = heater.profile();
    assert_eq!(profile.estimate_lag, Duration::from_millis(2_200), "what is declared is enough");
}

#[test]
fn what_is_sent_outside_a_radio_window_does_not_arrive() {
    let given = [("windows_s", "10..20"), ("rate_kib_s", "100")];
    let payload = payload(42, vec![spec("radio", "transmitter", &given)]);
    let mut radio = payload.driver("radio").unwrap();
    give(&mut radio, "on");
    payload.clock().advance_to(Instant::from_micros(5_000_000));
    give(&mut radio, "send 2000");
    assert_eq!(unit(&payload, "radio").draw, watts(15));
    payload.clock().advance_to(Instant::from_micros(40_000_000));
    let radio = unit(&payload, "radio");
    assert_eq!(radio.finished, 1_000, "the ten seconds of the window");
    assert_eq!(radio.finished + radio.lost, 2_000, "the rest went out unheard");
    assert_eq!(radio.draw, watts(4), "it is silent again");
}

#[test]
fn a_transmission_that_is_cut_short_keeps_what_has_arrived() {
    let payload = payload(42, vec![spec("radio", "transmitter", &[("rate_kib_s", "100")])]);
    let mut radio = payload.driver("radio").unwrap();
    give(&mut radio, "on");
    give(&mut radio, "send 2000");
    pass(&payload, 5_000);
    assert_eq!(unit(&payload, "radio").finished, 500);
    radio.safe().unwrap();
    pass(&payload, 60_000);
    assert_eq!(unit(&payload, "radio").finished, 500);
}

#[test]
fn a_computer_that_boots_acquires_nothing() {
    let payload = payload(42, vec![spec("it", "computer", &[("boot_s", "2")])]);
    let mut it = payload.driver("it").unwrap();
    give(&mut it, "on");
    assert_eq!(unit(&payload, "it").draw, watts(8));
    give(&mut it, "acquire 1.5");
    pass(&payload, 2_000);
    assert_eq!(unit(&payload, "it").draw, watts(5), "booted, idle");
    give(&mut it, "acquire 1.5");
    pass(&payload, 1_500);
    assert_eq!(unit(&payload, "it").finished, 1, "the first one was not taken");
}

#[test]
fn a_processor_draws_from_4_to_10_w_as_it_is_loaded() {
    let payload = payload(42, vec![spec("cpu", "processor", &[])]);
    let mut cpu = payload.driver("cpu").unwrap();
    give(&mut cpu, "load 100");
    assert_eq!(unit(&payload, "cpu").draw, Milliwatts::ZERO, "it is off");
    give(&mut cpu, "on");
    for (load, mw) in [(0, 4_000), (50, 7_000), (100, 10_000)] {
        give(&mut cpu, &format!("load {load}"));
        assert_eq!(unit(&payload, "cpu").draw, Milliwatts::new(mw));
    }
}

#[test]
fn a_gimbal_draws_more_while_it_turns_and_stays_where_it_was_stopped() {
    let payload = payload(42, vec![spec("gimbal", "gimbal", &[("rate_deg_s", "10")])]);
    let mut gimbal = payload.driver("gimbal").unwrap();
    give(&mut gimbal, "on");
    give(&mut gimbal, "point -90");
    assert_eq!(unit(&payload, "gimbal").draw, watts(12));
    pass(&payload, 9_000);
    assert_eq!(unit(&payload, "gimbal").draw, watts(3));
    assert_eq!(unit(&payload, "gimbal").finished, 1);
    give(&mut gimbal, "point 0");
    pass(&payload, 4_500);
    give(&mut gimbal, "off");
    give(&mut gimbal, "on");
    give(&mut gimbal, "point 0");
    pass(&payload, 4_490);
    assert_eq!(unit(&payload, "gimbal").draw, watts(12), "half the way was left");
    pass(&payload, 20);
    assert_eq!(unit(&payload, "gimbal").draw, watts(3));
}

#[test]
fn a_battery_gauge_follows_the_energy_and_a_flat_one_takes_the_bus_with_it() {
    let given = settings(&[("capacity_wh", "1"), ("charge_percent", "50"), ("generation_w", "2")]);
    let battery = BatteryModel::new(&given).unwrap();
    let supplies = Supplies { battery: Some(battery), ..Supplies::of(watts(42)) };
    let payload = Payload::new(supplies, vec![], 1, &SimClock::virtual_time());
    assert_eq!(payload.state_of_charge(), Some(50));
    payload.set_other_draw(watts(12));
    pass(&payload, 72_000);
    assert_eq!(payload.state_of_charge(), Some(30), "10 W for 72 s is a fifth of 3600 J");
    pass(&payload, 200_000);
    let law = payload.broken_law().unwrap().1;
    assert_eq!(law, Law::BusTripped { draw: watts(12), supply: watts(2) });
}

#[test]
fn settings_that_are_wrong_are_all_named() {
    let given = settings(&[("exposure_s", "soon"), ("inrush_w", "1.2345"), ("colour", "red")]);
    let wrong = UnitSpec::new("camera", "camera", None, &given).unwrap_err();
    assert_eq!(wrong.len(), 3, "{wrong:?}");
    assert!(wrong.iter().any(|text| text.contains("`colour`") && text.contains("exposure_s")));
    let wrong = UnitSpec::new("it", "toaster", None, &settings(&[])).unwrap_err();
    assert!(wrong[0].contains("toaster") && wrong[0].contains("gimbal"), "{wrong:?}");
    let too_little = UnitSpec::new("it", "heater", Some(watts(5)), &settings(&[])).unwrap_err();
    assert!(too_little[0].contains("6 W"), "{too_little:?}");
}

#[test]
fn commands_that_say_nothing_are_refused_with_what_is_known() {
    let spec = spec("gimbal", "gimbal", &[]);
    let parse = |name: &str, arguments: &[&str]| {
        spec.parse(name, &arguments.iter().map(|text| String::from(*text)).collect::<Vec<_>>())
    };
    assert!(parse("fold", &[]).unwrap_err().contains("on, off, point"));
    assert!(parse("on", &["now"]).unwrap_err().contains("no argument"));
    assert!(parse("point", &[]).unwrap_err().contains("DEGREES"));
    assert!(parse("point", &["181"]).unwrap_err().contains("181"));
    assert_eq!(parse("point", &["-12.5"]).unwrap().to_string(), "point -12.500");
}

proptest! {
    /// Any random use of any units, looked at or not: no unit ever draws more
    /// than it declares, and what was drawn is the same whoever looked when.
    #[test]
    fn no_unit_draws_more_than_it_declares_and_looking_changes_nothing(
        commands in proptest::collection::vec((0_usize..6, 0_usize..4, 0_u64..3_000), 1..60),
        looks in proptest::collection::vec(any::<bool>(), 60),
    ) {
        let specs = || KINDS.iter().map(|kind| spec(kind, kind, &[])).collect::<Vec<_>>();
        let fly = |look: &dyn Fn(usize) -> bool| {
            let payload = payload(1_000, specs());
            let mut drivers: Vec<_> = KINDS.iter().map(|kind| payload.driver(kind).unwrap()).collect();
            for (step, (index, which, ms)) in commands.iter().enumerate() {
                let known = drivers[*index].commands();
                let command = known[which % known.len()];
                let argument: Vec<String> = command.argument.iter().map(|_| "50".into()).collect();
                let command = drivers[*index].parse(command.name, &argument).unwrap();
                drivers[*index].issue(command).unwrap();
                if look(step) {
                    for (unit, driver) in payload.truth().units.iter().zip(&drivers) {
                        assert!(unit.draw <= driver.profile().draw, "{unit:?}");
                    }
                }
                pass(&payload, *ms);
            }
            payload.truth()
        };
        prop_assert_eq!(fly(&|_| false), fly(&|step| looks[step]));
    }

    /// Commands that a program carried as numbers are the same commands.
    #[test]
    fn commands_survive_as_numbers(index in 0_usize..6, which in 0_usize..4, argument in 0_u8..=100) {
        let spec = spec("it", KINDS[index], &[]);
        let command = spec.commands()[which % spec.commands().len()];
        let argument: Vec<String> = command.argument.iter().map(|_| argument.to_string()).collect();
        let command = spec.parse(command.name, &argument).unwrap();
        let again = UnitCommand::from_numbers(command.declaration(), command.argument());
        prop_assert_eq!(again, Some(command));
    }
}
