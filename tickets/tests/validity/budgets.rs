//! Energy and propellant: what flows while the device is on.

use super::*;

#[test]
fn energy_flows_from_the_on_command_until_it_is_used_up() {
    // 2 W for 500 us are 1000 uJ.
    let mut energy = validity(Function::energy(Microjoules::new(1_000)));
    assert_eq!(invoke(&mut energy, 100, on(2 * W)), Ok(()));
    assert_eq!(energy.ran_out(at(599)), None);
    assert_eq!(energy.ran_out(at(600)), over(Rule::Energy));
    assert_eq!(energy.check(&ask(600, on(2 * W))), denial(Rule::Energy, 1, None));
    assert_eq!(energy.check(&ask(603, Effect::Unchanged)), denial(Rule::Energy, 7, None));
    assert_eq!(energy.check(&ask(700, Effect::Off)), Ok(()));
}

#[test]
fn propellant_flows_as_energy_does() {
    // 50 mg/s for 2 s are 100 mg.
    let flow = MilligramsPerSecond::new(50);
    let fire = Effect::On { draw: Milliwatts::new(7), flow };
    let mut propellant = validity(Function::propellant(Milligrams::new(100)));
    assert_eq!(invoke(&mut propellant, 0, fire), Ok(()));
    assert_eq!(propellant.ran_out(at(1_999_999)), None);
    assert_eq!(propellant.ran_out(at(2_000_000)), over(Rule::Propellant));
    assert_eq!(propellant.check(&ask(2_100_000, fire)), denial(Rule::Propellant, 6, None));
    propellant.confirmed_off(at(1_000_001));
    assert_eq!(propellant.propellant_left(), Milligrams::new(49));
    assert_eq!(propellant.energy_left(), Microjoules::ZERO);
}

#[test]
fn an_off_command_alone_stops_no_integral() {
    let mut energy = validity(Function::energy(Microjoules::new(1_000)));
    invoke(&mut energy, 0, on(W)).unwrap();
    invoke(&mut energy, 10, Effect::Off).unwrap();
    assert_eq!(energy.ran_out(at(1_000)), over(Rule::Energy));
    energy.confirmed_off(at(300));
    assert_eq!(energy.ran_out(at(u64::MAX)), None);
    assert_eq!(energy.look_again_at(at(1_000)), None);
    assert_eq!(energy.energy_left(), Microjoules::new(700));
}

#[test]
fn a_measurement_from_before_the_on_command_confirms_nothing() {
    let cycle = Function::duty_cycle(us(100), us(200)).unwrap();
    for function in [Function::energy(Microjoules::new(100)), cycle] {
        let mut limits = validity(function);
        invoke(&mut limits, 50, on(W)).unwrap();
        limits.confirmed_off(at(50));
        assert!(limits.ran_out(at(150)).is_some());
        invoke(&mut limits, 80, on(W)).unwrap();
        limits.confirmed_off(at(70));
        assert!(limits.ran_out(at(150)).is_some());
    }
}

#[test]
fn a_second_on_command_settles_and_goes_on_with_the_new_draw() {
    let mut energy = validity(Function::energy(Microjoules::new(1_000)));
    invoke(&mut energy, 0, on(W)).unwrap();
    invoke(&mut energy, 400, on(3 * W)).unwrap();
    assert_eq!(energy.energy_left(), Microjoules::new(600));
    assert_eq!(energy.ran_out(at(599)), None);
    assert_eq!(energy.ran_out(at(600)), over(Rule::Energy));
}

#[test]
fn what_is_left_survives_a_pause() {
    let mut energy = validity(Function::energy(Microjoules::new(1_000)));
    invoke(&mut energy, 0, on(W)).unwrap();
    energy.confirmed_off(at(900));
    energy.admitted(at(5_000));
    invoke(&mut energy, 5_000, on(W)).unwrap();
    assert_eq!(energy.ran_out(at(5_099)), None);
    assert_eq!(energy.ran_out(at(5_100)), over(Rule::Energy));
}

#[test]
fn a_device_without_draw_uses_no_budget() {
    let mut energy = validity(Function::energy(Microjoules::new(1)));
    invoke(&mut energy, 0, on(0)).unwrap();
    assert_eq!(energy.look_again_at(at(0)), None);
    assert_eq!(energy.ran_out(at(u64::MAX)), None);
}
