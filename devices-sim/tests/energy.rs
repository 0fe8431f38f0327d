//! The energy books are exact: after any history the battery holds what an
//! independent integral says, to the nanojoule.

use faregate_devices_sim::{
    CameraCommand, CutoffCommand, FaultScript, HeatersCommand, Parameters, SimClock, Spacecraft,
    ThrusterCommand,
};
use faregate_tickets::clock::{Clock, Duration, Instant};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// A spacecraft that nothing trips, so that histories are long.
fn tireless() -> Parameters {
    Parameters {
        bus_trip_time: Duration::MAX,
        propulsion_trip_time: Duration::MAX,
        ..Parameters::default()
    }
}

fn give(spacecraft: &Spacecraft, command: u8) {
    let answer = match command {
        0 => spacecraft.bare_camera().issue(CameraCommand::On),
        1 => spacecraft.bare_camera().issue(CameraCommand::Off),
        2 => spacecraft.bare_cutoff().issue(CutoffCommand::Shut),
        3 => spacecraft.bare_cutoff().issue(CutoffCommand::CoilOff),
        4 => spacecraft.bare_heaters().issue(HeatersCommand::On),
        5 => spacecraft.bare_heaters().issue(HeatersCommand::Off),
        6 => spacecraft.bare_thruster().issue(ThrusterCommand::Open),
        _ => spacecraft.bare_thruster().issue(ThrusterCommand::Close),
    };
    assert_eq!(answer, Ok(()));
}

/// Steps through every single microsecond of a gap and adds up what it sees. A
/// battery that cannot feed a whole microsecond feeds none of it.
fn integrate(
    spacecraft: &Spacecraft,
    until: Instant,
    generation: u64,
    stored: &mut u64,
    capacity: u64,
) {
    while spacecraft.clock().now() < until {
        let draw = spacecraft.truth().draw.get();
        let full = *stored + generation;
        *stored = full.checked_sub(draw).unwrap_or(*stored).min(capacity);
        spacecraft.advance_to(spacecraft.clock().now().after(Duration::from_micros(1)));
    }
}

/// Commands take time, so two spacecraft with one seed are commanded alike: one
/// is stepped through by the microsecond, commands excepted, the other is not
/// looked at before the end.
fn check(history: &[(u8, u64)], stored_uj: u64) -> Result<(), TestCaseError> {
    let parameters = Parameters {
        battery_stored: faregate_tickets::amount::Microjoules::new(stored_uj),
        battery_capacity: faregate_tickets::amount::Microjoules::new(2_000_000),
        ..tireless()
    };
    let (generation, capacity) = (parameters.generation.get(), 2_000_000_000);
    let spacecraft =
        || Spacecraft::new(parameters.clone(), FaultScript::new(), 5, &SimClock::virtual_time());
    let (stepped, leapt) = (spacecraft(), spacecraft());
    for (command, gap_us) in history {
        let until = leapt.clock().now().after(Duration::from_micros(*gap_us));
        let mut stored = stepped.truth().stored_nj;
        integrate(&stepped, until, generation, &mut stored, capacity);
        prop_assert_eq!(stepped.truth().stored_nj, stored);
        leapt.clock().advance_to(until);
        give(&stepped, *command);
        give(&leapt, *command);
    }
    prop_assert_eq!(stepped.truth(), leapt.truth());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 60,
        rng_seed: RngSeed::Fixed(0),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_battery_holds_what_an_independent_integral_says(
        history in prop::collection::vec((0_u8..8, 0_u64..9_000), 1..12),
        stored_uj in 1_000_000_u64..2_000_000,
    ) {
        check(&history, stored_uj)?;
    }
}
