//! Conditions: telemetry, modes and the interlock.

use super::*;

fn seen(table: &Telemetry, now: u64, effect: Effect) -> Ask<'_> {
    Ask { now: at(now), effect, telemetry: Some(table) }
}

fn range() -> (Channel, Validity) {
    let channel = Channel::new(3).expect("less than 16");
    (channel, validity(Function::telemetry(channel, -5..=40, us(100))))
}

#[test]
fn what_was_never_measured_is_too_old() {
    let never = denial(Rule::TelemetryAge, u64::MAX, None);
    let (_, warm) = range();
    assert_eq!(warm.check(&seen(&Telemetry::new(), 0, on(W))), never);
    assert_eq!(warm.check(&ask(0, on(W))), never);
}

#[test]
fn a_value_must_be_in_range_and_fresh() {
    let (channel, warm) = range();
    let table = Telemetry::new();
    for (value, short_by) in
        [(-6, 1), (i32::MIN, 2_147_483_643), (41, 1), (i32::MAX, 2_147_483_607)]
    {
        table.publish(channel, value, at(1_000));
        assert_eq!(
            warm.check(&seen(&table, 1_000, on(W))),
            denial(Rule::Telemetry, short_by, None)
        );
        assert_eq!(warm.check(&seen(&table, 1_000, Effect::Off)), Ok(()));
    }
    for value in [-5, -4, 0, 39, 40] {
        table.publish(channel, value, at(1_000));
        assert_eq!(warm.check(&seen(&table, 1_100, on(W))), Ok(()));
        assert_eq!(warm.check(&seen(&table, 1_102, on(W))), denial(Rule::TelemetryAge, 2, None));
    }
}

#[test]
fn a_mode_outside_the_set_refuses() {
    let [cruise, science, safe] = [0, 5, 31].map(|number| Mode::new(number).unwrap());
    let in_science = validity(Function::modes(Modes::from(science).and(safe)));
    let table = Telemetry::new();
    let refused = denial(Rule::Mode, 0, None);
    assert_eq!(in_science.check(&ask(0, on(W))), refused);
    for (mode, answer) in [(science, Ok(())), (cruise, refused), (safe, Ok(()))] {
        table.set_mode(mode);
        assert_eq!(in_science.check(&seen(&table, 0, on(W))), answer);
    }
}

#[test]
fn the_interlock_is_left_to_the_gate() {
    let interlocked = validity(Function::interlock());
    assert!(interlocked.has_interlock());
    assert_eq!(interlocked.check(&ask(0, on(W))), Ok(()));
}
