//! The physics: what trips, what spins, what the sensors say and when. The
//! spacecraft runs on a plain virtual clock here; a command's time passes when it
//! is given.

use faregate_devices_sim::{
    BareCamera, CameraCommand, CutoffCommand, DeviceId, DriverFault, Failing, Fault, FaultScript,
    HeatersCommand, Law, Measured, Outcome, Parameters, SimClock, Spacecraft, ThrusterCommand,
};
use faregate_tickets::Device;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Estimate, Power};

const STUCK_AT: Instant = Instant::from_micros(500_000);

fn ms(ms: u64) -> Instant {
    Instant::from_micros(ms * 1_000)
}

fn healthy() -> Spacecraft {
    with_faults(FaultScript::new())
}

fn with_faults(script: FaultScript) -> Spacecraft {
    Spacecraft::new(Parameters::default(), script, 1, &SimClock::virtual_time())
}

fn pass(spacecraft: &Spacecraft, ms: u64) {
    spacecraft.advance_to(spacecraft.clock().now().after(Duration::from_millis(ms)));
}

fn camera_on(spacecraft: &Spacecraft) -> BareCamera {
    let camera = spacecraft.bare_camera();
    assert_eq!(camera.issue(CameraCommand::On), Ok(()));
    camera
}

#[test]
fn camera_and_cutoff_coil_together_trip_the_bus_after_exactly_the_trip_time() {
    let spacecraft = healthy();
    camera_on(&spacecraft);
    pass(&spacecraft, 100);
    spacecraft.bare_cutoff().issue(CutoffCommand::Shut).unwrap();
    let overdrawn = spacecraft.clock().now();
    pass(&spacecraft, 5);
    assert_eq!(spacecraft.broken_law(), None, "borne for the trip time");
    pass(&spacecraft, 1);
    let law =
        Law::BusTripped { draw: Milliwatts::from_watts(145), supply: Milliwatts::from_watts(125) };
    assert_eq!(spacecraft.broken_law(), Some((overdrawn.after(Duration::from_micros(5_001)), law)));
    assert_eq!(law.to_string(), "the bus tripped: 145 W drawn, 125 W supplied");
}

#[test]
fn an_overdraw_that_ends_with_the_trip_time_does_not_trip_and_the_next_starts_anew() {
    let parameters = Parameters { cutoff_pulse: Duration::from_millis(5), ..Parameters::default() };
    let spacecraft = Spacecraft::new(parameters, FaultScript::new(), 1, &SimClock::virtual_time());
    camera_on(&spacecraft);
    pass(&spacecraft, 100);
    for _ in 0..2 {
        spacecraft.bare_cutoff().issue(CutoffCommand::Shut).unwrap();
        assert_eq!(spacecraft.truth().draw, Milliwatts::from_watts(145));
        pass(&spacecraft, 50);
        assert_eq!(spacecraft.broken_law(), None);
    }
}

#[test]
fn the_cutoff_coil_fits_the_supply_when_the_camera_is_off_and_settled() {
    let spacecraft = healthy();
    let camera = camera_on(&spacecraft);
    pass(&spacecraft, 100);
    camera.issue(CameraCommand::Off).unwrap();
    pass(&spacecraft, 10);
    spacecraft.bare_cutoff().issue(CutoffCommand::Shut).unwrap();
    pass(&spacecraft, 100);
    assert_eq!(spacecraft.broken_law(), None);
    assert!(spacecraft.truth().cutoff_shut);
}

#[test]
fn a_camera_that_was_just_switched_off_still_draws_enough_to_trip_the_bus() {
    let spacecraft = healthy();
    let camera = camera_on(&spacecraft);
    pass(&spacecraft, 100);
    camera.issue(CameraCommand::Off).unwrap();
    assert!(!spacecraft.truth().camera_on);
    spacecraft.bare_cutoff().issue(CutoffCommand::Shut).unwrap();
    pass(&spacecraft, 10);
    assert!(matches!(spacecraft.broken_law(), Some((_, Law::BusTripped { .. }))));
}

#[test]
fn the_cameras_inrush_is_within_what_it_declares_and_passes() {
    let spacecraft = healthy();
    let base = spacecraft.truth().draw;
    let driver = spacecraft.camera_driver().unwrap();
    camera_on(&spacecraft);
    let inrush = spacecraft.truth().draw.saturating_sub(base);
    assert_eq!(inrush, driver.profile().draw);
    pass(&spacecraft, 5);
    assert_eq!(spacecraft.truth().draw.saturating_sub(base), Milliwatts::from_watts(30));
}

/// At 0.1 rad/s in a second, 0.15 rad/s are reached in exactly 1.5 s.
#[test]
fn a_stuck_thruster_spins_up_beyond_recovery_at_the_computed_instant() {
    let spacecraft =
        with_faults(FaultScript::new().with(Fault::ThrusterSticksOpen { at: STUCK_AT }));
    spacecraft.advance_to(Instant::from_micros(1_999_999));
    assert_eq!(spacecraft.broken_law(), None);
    assert_eq!(spacecraft.truth().rate_urad_s, 149_999);
    spacecraft.advance_to(ms(60_000));
    let law = Law::SpunUp { rate_urad_s: 150_000 };
    assert_eq!(spacecraft.broken_law(), Some((ms(2_000), law)));
    assert_eq!(law.to_string(), "spun up beyond recovery: 0.150 rad/s");
    assert_eq!(spacecraft.truth().at, ms(2_000), "physics ends with the loss");
}

#[test]
fn closing_a_stuck_thruster_does_nothing_and_the_cutoff_valve_stops_it() {
    let spacecraft =
        with_faults(FaultScript::new().with(Fault::ThrusterSticksOpen { at: STUCK_AT }));
    spacecraft.advance_to(ms(600));
    let thruster = spacecraft.bare_thruster();
    thruster.issue(ThrusterCommand::Open).unwrap();
    thruster.issue(ThrusterCommand::Close).unwrap();
    assert!(spacecraft.truth().thruster_open);
    spacecraft.bare_cutoff().issue(CutoffCommand::Shut).unwrap();
    let shut_at = spacecraft.clock().now().after(Duration::from_millis(40));
    spacecraft.advance_to(ms(60_000));
    let truth = spacecraft.truth();
    assert_eq!(spacecraft.broken_law(), None);
    let pushed_us = shut_at.since(STUCK_AT).as_micros();
    assert_eq!(truth.rate_urad_s, pushed_us / 10, "0.1 urad/s in each microsecond");
    assert_eq!(truth.propellant_ng, 5_000_000_000_000 - 463 * pushed_us);
}

#[test]
fn safing_the_cutoff_coil_leaves_a_shut_valve_shut() {
    let spacecraft = healthy();
    let mut cutoff = spacecraft.cutoff_driver().unwrap();
    cutoff.issue(CutoffCommand::Shut).unwrap();
    pass(&spacecraft, 40);
    assert!(spacecraft.truth().cutoff_coil_on);
    cutoff.safe().unwrap();
    let truth = spacecraft.truth();
    assert!(!truth.cutoff_coil_on && truth.cutoff_shut);
    assert_eq!(truth.draw, Milliwatts::from_watts(70));
}

#[test]
fn safing_the_cutoff_coil_too_soon_leaves_the_valve_open() {
    let spacecraft = healthy();
    let mut cutoff = spacecraft.cutoff_driver().unwrap();
    cutoff.issue(CutoffCommand::Shut).unwrap();
    pass(&spacecraft, 38);
    cutoff.safe().unwrap();
    pass(&spacecraft, 100);
    assert!(!spacecraft.truth().cutoff_shut);
}

#[test]
fn the_cutoff_pulse_ends_by_itself() {
    let spacecraft = healthy();
    spacecraft.bare_cutoff().issue(CutoffCommand::Shut).unwrap();
    pass(&spacecraft, 59);
    assert!(spacecraft.truth().cutoff_coil_on);
    pass(&spacecraft, 1);
    assert!(!spacecraft.truth().cutoff_coil_on && spacecraft.truth().cutoff_shut);
}

#[test]
fn heaters_and_thruster_valve_together_trip_the_propulsion_converter() {
    let spacecraft = healthy();
    spacecraft.bare_heaters().issue(HeatersCommand::On).unwrap();
    pass(&spacecraft, 100);
    assert_eq!(spacecraft.broken_law(), None);
    spacecraft.bare_thruster().issue(ThrusterCommand::Open).unwrap();
    pass(&spacecraft, 6);
    let law = Law::PropulsionTripped {
        draw: Milliwatts::from_watts(20),
        supply: Milliwatts::from_watts(15),
    };
    assert_eq!(spacecraft.broken_law().map(|(_, law)| law), Some(law));
}

#[test]
fn heaters_then_thruster_valve_trip_nothing() {
    let spacecraft = healthy();
    let heaters = spacecraft.bare_heaters();
    heaters.issue(HeatersCommand::On).unwrap();
    pass(&spacecraft, 100);
    heaters.issue(HeatersCommand::Off).unwrap();
    spacecraft.bare_thruster().issue(ThrusterCommand::Open).unwrap();
    pass(&spacecraft, 100);
    assert_eq!(spacecraft.broken_law(), None);
}

#[test]
fn the_camera_fails_to_switch_off_as_often_as_scripted_and_its_driver_cannot_tell() {
    let spacecraft =
        with_faults(FaultScript::new().with(Fault::CameraOffFails { from: ms(10), attempts: 2 }));
    let camera = camera_on(&spacecraft);
    camera.issue(CameraCommand::Off).unwrap();
    assert!(!spacecraft.truth().camera_on, "the fault has not begun");
    spacecraft.advance_to(ms(20));
    camera.issue(CameraCommand::On).unwrap();
    for expected in [true, true, false] {
        assert_eq!(camera.issue(CameraCommand::Off), Ok(()));
        assert_eq!(spacecraft.truth().camera_on, expected);
    }
}

#[test]
fn an_upset_switches_the_camera_off_and_ends_its_exposure() {
    let spacecraft = with_faults(FaultScript::new().with(Fault::CameraUpset { at: ms(200) }));
    let camera = camera_on(&spacecraft);
    camera.issue(CameraCommand::Expose).unwrap();
    spacecraft.advance_to(Instant::from_micros(199_999));
    assert!(spacecraft.truth().camera_on);
    spacecraft.advance_to(ms(1_000));
    let truth = spacecraft.truth();
    assert_eq!((truth.camera_on, truth.exposures_finished, truth.exposures_lost), (false, 0, 1));
    camera.issue(CameraCommand::On).unwrap();
    assert!(spacecraft.truth().camera_on, "it can be turned on again");
}

#[test]
fn an_exposure_counts_if_it_ends_by_its_deadline() {
    let parameters = Parameters { exposure_deadline: ms(1_000), ..Parameters::default() };
    let spacecraft = Spacecraft::new(parameters, FaultScript::new(), 1, &SimClock::virtual_time());
    let camera = camera_on(&spacecraft);
    camera.issue(CameraCommand::Expose).unwrap();
    spacecraft.advance_to(ms(700));
    assert_eq!(spacecraft.truth().exposures_finished, 1);
    assert_eq!(spacecraft.measured_exposures().map(|m| m.value), Some(1));
    camera.issue(CameraCommand::Expose).unwrap();
    spacecraft.advance_to(ms(1_200));
    let truth = spacecraft.truth();
    assert_eq!((truth.exposures_finished, truth.exposures_late), (1, 1));
}

#[test]
fn an_estimate_is_of_a_moment_at_least_the_lag_ago_and_at_most_a_period_more() {
    let parameters = Parameters { sensor_unknown_permille: 0, ..Parameters::default() };
    for seed in 0..20 {
        let spacecraft = Spacecraft::new(
            parameters.clone(),
            FaultScript::new(),
            seed,
            &SimClock::virtual_time(),
        );
        assert_eq!(spacecraft.estimate(DeviceId::Camera), None, "nothing has arrived");
        spacecraft.advance_to(ms(100));
        camera_on(&spacecraft);
        let on_at = spacecraft.clock().now();
        for _ in 0..200 {
            spacecraft.advance_to(spacecraft.clock().now().after(Duration::from_micros(313)));
            let Estimate { state, measured_at } = spacecraft.estimate(DeviceId::Camera).unwrap();
            let age = spacecraft.clock().now().since(measured_at);
            assert!(Duration::from_millis(20) <= age && age < Duration::from_millis(25), "{age}");
            assert_eq!(state, if measured_at < on_at { Power::Off } else { Power::On });
        }
    }
}

#[test]
fn an_estimate_does_not_depend_on_who_asked_before() {
    let asked = healthy();
    let left_alone = healthy();
    for spacecraft in [&asked, &left_alone] {
        spacecraft.advance_to(ms(100));
        camera_on(spacecraft);
    }
    for step in 0..500 {
        asked.advance_to(ms(101 + step));
        let _ = (asked.estimate(DeviceId::Camera), asked.truth());
    }
    left_alone.advance_to(ms(600));
    assert_eq!(asked.estimate(DeviceId::Camera), left_alone.estimate(DeviceId::Camera));
    assert_eq!(asked.truth(), left_alone.truth());
}

#[test]
fn some_measurements_say_nothing_and_none_lies() {
    let spacecraft = healthy();
    let mut unknown = 0;
    for step in 1..=10_000 {
        spacecraft.advance_to(ms(30 + 5 * step));
        match spacecraft.estimate(DeviceId::Heaters).unwrap().state {
            Power::Off => {}
            Power::Unknown => unknown += 1,
            Power::On => panic!("the heaters were never on"),
        }
    }
    assert!((100..300).contains(&unknown), "{unknown} of 10000, where 2 % were meant");
}

#[test]
fn a_silent_sensors_last_estimate_grows_old() {
    let silent = Fault::SensorSilent { device: DeviceId::Camera, from: ms(100), until: ms(400) };
    let spacecraft = with_faults(FaultScript::new().with(silent));
    camera_on(&spacecraft);
    spacecraft.advance_to(ms(410));
    let old = spacecraft.estimate(DeviceId::Camera).unwrap().measured_at;
    assert!(ms(95) <= old && old < ms(100), "{old}");
    spacecraft.advance_to(ms(426));
    assert!(spacecraft.estimate(DeviceId::Camera).unwrap().measured_at >= ms(400));
    assert!(spacecraft.estimate(DeviceId::Heaters).unwrap().measured_at >= ms(400), "others speak");
}

#[test]
fn a_blind_sensor_says_unknown() {
    let blind = Fault::SensorBlind { device: DeviceId::Camera, from: ms(100), until: ms(400) };
    let spacecraft = with_faults(FaultScript::new().with(blind));
    for at in [130, 200, 300, 410] {
        spacecraft.advance_to(ms(at));
        assert_eq!(spacecraft.estimate(DeviceId::Camera).unwrap().state, Power::Unknown);
    }
}

#[test]
fn the_measured_rate_is_the_rate_at_the_measurement() {
    let spacecraft =
        with_faults(FaultScript::new().with(Fault::ThrusterSticksOpen { at: STUCK_AT }));
    for at in (510..1_900).step_by(7) {
        spacecraft.advance_to(ms(at));
        let Measured { value, measured_at } = spacecraft.measured_rate_urad_s().unwrap();
        assert_eq!(value, measured_at.since(STUCK_AT).as_micros() / 10);
        assert!(value <= spacecraft.truth().rate_urad_s);
    }
}

#[test]
fn a_falling_supply_trips_the_bus_under_a_load_that_it_carried() {
    let script = FaultScript::new()
        .with(Fault::GenerationFalls { at: ms(300), to: Milliwatts::from_watts(70) });
    let spacecraft = with_faults(script);
    camera_on(&spacecraft);
    spacecraft.advance_to(ms(1_000));
    let law =
        Law::BusTripped { draw: Milliwatts::from_watts(100), supply: Milliwatts::from_watts(95) };
    assert_eq!(spacecraft.broken_law(), Some((Instant::from_micros(305_001), law)));
}

#[test]
fn a_flat_battery_leaves_the_generator_alone_with_the_load() {
    // 40 mJ against a deficit of 20 W: flat after exactly 2 ms.
    let parameters = Parameters {
        generation: Milliwatts::from_watts(50),
        battery_stored: Microjoules::new(40_000),
        ..Parameters::default()
    };
    let spacecraft = Spacecraft::new(parameters, FaultScript::new(), 1, &SimClock::virtual_time());
    spacecraft.advance_to(Instant::from_micros(1_999));
    assert_eq!(
        (spacecraft.truth().supply, spacecraft.truth().stored_nj),
        (Milliwatts::from_watts(75), 20_000)
    );
    spacecraft.advance_to(ms(100));
    let law =
        Law::BusTripped { draw: Milliwatts::from_watts(70), supply: Milliwatts::from_watts(50) };
    assert_eq!(spacecraft.broken_law(), Some((Instant::from_micros(7_001), law)));
    assert_eq!(spacecraft.truth().stored(), Microjoules::ZERO);
}

#[test]
fn an_empty_tank_ends_the_push_short_of_the_loss() {
    let parameters = Parameters {
        propellant: faregate_tickets::amount::Milligrams::new(463),
        ..Parameters::default()
    };
    let script = FaultScript::new().with(Fault::ThrusterSticksOpen { at: STUCK_AT });
    let spacecraft = Spacecraft::new(parameters, script, 1, &SimClock::virtual_time());
    spacecraft.advance_to(ms(60_000));
    assert_eq!(spacecraft.broken_law(), None);
    let truth = spacecraft.truth();
    assert_eq!((truth.rate_urad_s, truth.propellant_ng), (100_000, 0), "one second's worth");
}

#[test]
fn there_is_one_driver_for_each_device() {
    let spacecraft = healthy();
    let clone = spacecraft.clone();
    assert!(spacecraft.camera_driver().is_some() && clone.camera_driver().is_none());
    assert!(clone.thruster_driver().is_some() && spacecraft.thruster_driver().is_none());
    assert!(spacecraft.cutoff_driver().is_some() && clone.cutoff_driver().is_none());
    assert!(clone.heaters_driver().is_some() && spacecraft.heaters_driver().is_none());
}

#[test]
fn every_command_is_traced_with_its_time_source_and_outcome() {
    let fails = |nth, how| Fault::CommandFails { device: DeviceId::Camera, nth, how };
    let script = FaultScript::new().with(fails(3, Failing::Faults)).with(fails(4, Failing::Panics));
    let spacecraft = with_faults(script);
    let mut camera = spacecraft.camera_driver().unwrap();
    spacecraft.advance_to(ms(10));
    camera.issue(CameraCommand::On).unwrap();
    camera.issue(CameraCommand::On).unwrap();
    assert_eq!(camera.issue(CameraCommand::Off), Err(DriverFault { device: DeviceId::Camera }));
    let unwinds =
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| camera.issue(CameraCommand::Off)));
    assert!(unwinds.is_err());
    camera.safe().unwrap();
    let trace = spacecraft.trace();
    let outcomes: Vec<Outcome> = trace.iter().map(|received| received.outcome).collect();
    use Outcome::{DriverFailed, NoEffect, Took};
    assert_eq!(outcomes, [Took, NoEffect, DriverFailed, DriverFailed, Took]);
    assert_eq!(trace[0].begun, ms(10));
    assert!(trace.is_sorted_by_key(|received| received.begun));
    for received in &trace {
        let time = received.done.unwrap().since(received.begun);
        assert!(Duration::from_micros(250) <= time && time <= Duration::from_millis(1), "{time}");
        assert_eq!(received.by, "every_command_is_traced_with_its_time_source_and_outcome");
        assert_eq!(received.command.device(), DeviceId::Camera);
    }
    assert!(trace[4].safing && !trace[0].safing);
    assert!(!spacecraft.truth().camera_on);
}

#[test]
fn a_command_that_hangs_reaches_its_device_late() {
    let hangs = Failing::Hangs { lasting: Duration::from_millis(300) };
    let spacecraft = with_faults(FaultScript::new().with(Fault::CommandFails {
        device: DeviceId::Camera,
        nth: 1,
        how: hangs,
    }));
    camera_on(&spacecraft);
    assert!(spacecraft.clock().now() >= ms(300));
    assert!(spacecraft.truth().camera_on);
}

#[test]
fn a_command_after_the_loss_comes_too_late() {
    let spacecraft =
        with_faults(FaultScript::new().with(Fault::ThrusterSticksOpen { at: STUCK_AT }));
    spacecraft.advance_to(ms(3_000));
    spacecraft.bare_cutoff().issue(CutoffCommand::Shut).unwrap();
    assert_eq!(spacecraft.trace()[0].outcome, Outcome::TooLate);
    assert!(!spacecraft.truth().cutoff_coil_on);
}

#[test]
fn in_real_time_the_same_spacecraft_follows_the_machines_clock() {
    let spacecraft =
        Spacecraft::new(Parameters::default(), FaultScript::new(), 1, &SimClock::real_time());
    let before = spacecraft.clock().now();
    camera_on(&spacecraft);
    let took = spacecraft.clock().now().since(before);
    assert!(took >= Duration::from_micros(250), "{took}");
    assert!(spacecraft.truth().camera_on);
    assert!(spacecraft.trace()[0].begun >= before);
}
