//! The emergency is real: doing nothing loses the spacecraft, doing the right
//! thing saves it with time to spare, and a monitor that does not know of it
//! loses it: always if it looks often, sometimes if it looks seldom.

use std::collections::BTreeSet;

use faregate_devices_sim::interleave::{self, Interleaver, Report};
use faregate_devices_sim::{
    CameraCommand, CutoffCommand, DeviceId, FaultScript, Law, Parameters, ReceivedCommand,
    SimClock, Spacecraft,
};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::Power;
use faregate_tickets::id::Priority;

const END: Instant = Instant::from_micros(4_000_000);
const MS: Duration = Duration::from_millis(1);

fn spacecraft(seed: u64) -> Spacecraft {
    let script = FaultScript::emergency(seed);
    Spacecraft::new(Parameters::default(), script, seed, &SimClock::virtual_time())
}

/// Keeps the camera on, knowing nothing else.
fn monitor(spacecraft: &Spacecraft, period: Duration) {
    let camera = spacecraft.bare_camera();
    loop {
        let seen = spacecraft.estimate(DeviceId::Camera).map(|estimate| estimate.state);
        if seen != Some(Power::On) {
            let _ = camera.issue(CameraCommand::On);
        }
        interleave::wait(period);
    }
}

/// Waits for the spin, turns the camera off until it is seen off, shuts the
/// cutoff valve until it is seen shut; without authority over anybody.
fn rescue(spacecraft: &Spacecraft) {
    let spins = || spacecraft.measured_rate_urad_s().is_some_and(|rate| rate.value > 10_000);
    while !spins() {
        interleave::wait(MS);
    }
    while !seen_off_after(spacecraft, switch_off(spacecraft)) {}
    while spacecraft.measured_cutoff_shut().is_none_or(|shut| !shut.value) {
        let _ = spacecraft.bare_cutoff().issue(CutoffCommand::Shut);
        interleave::wait(Duration::from_millis(70));
    }
}

fn switch_off(spacecraft: &Spacecraft) -> Instant {
    let _ = spacecraft.bare_camera().issue(CameraCommand::Off);
    interleave::now().after(Parameters::default().camera_settling)
}

fn seen_off_after(spacecraft: &Spacecraft, settled: Instant) -> bool {
    interleave::wait_until(settled.after(Duration::from_millis(26)));
    spacecraft
        .estimate(DeviceId::Camera)
        .is_some_and(|estimate| estimate.state == Power::Off && estimate.measured_at > settled)
}

/// How the spacecraft fared, how the run went, and what was commanded.
type Flight = (Option<(Instant, Law)>, Report, Vec<ReceivedCommand>);

fn fly(seed: u64, monitor_period: Option<Duration>, with_rescue: bool) -> Flight {
    let spacecraft = spacecraft(seed);
    assert_eq!(spacecraft.bare_camera().issue(CameraCommand::On), Ok(()));
    let mut threads = Interleaver::new(spacecraft.clock(), seed);
    if let Some(period) = monitor_period {
        let spacecraft = &spacecraft;
        threads.spawn("monitor", Priority::SCIENCE, move || monitor(spacecraft, period));
    }
    if with_rescue {
        threads.spawn("rescue", Priority::EMERGENCY, || rescue(&spacecraft));
    }
    let report = threads.run(END);
    spacecraft.advance_to(END);
    (spacecraft.broken_law(), report, spacecraft.trace())
}

#[test]
fn doing_nothing_loses_the_spacecraft_by_spin_within_a_second_and_a_half() {
    for seed in 0..100 {
        let (at, law) = fly(seed, Some(MS), false).0.expect("nobody shuts the valve");
        assert!(matches!(law, Law::SpunUp { .. }), "{law}");
        assert!(Instant::from_micros(2_000_000) <= at && at < Instant::from_micros(2_500_000));
    }
}

#[test]
fn an_undisturbed_rescue_saves_it_with_half_the_time_to_spare() {
    for seed in 0..300 {
        let (law, _, trace) = fly(seed, None, true);
        assert_eq!(law, None, "seed {seed}: {trace:#?}");
        let stuck_at = FaultScript::emergency(seed).iter().find_map(|fault| match fault {
            faregate_devices_sim::Fault::ThrusterSticksOpen { at } => Some(at),
            _ => None,
        });
        let commanded =
            trace.iter().rfind(|received| received.command == CutoffCommand::Shut.into());
        let took = commanded.unwrap().begun.since(stuck_at.unwrap());
        assert!(took < Duration::from_millis(750), "seed {seed}: {took}");
    }
}

fn fates(monitor_period: Duration) -> BTreeSet<Option<&'static str>> {
    (0..200).map(|seed| fly(seed, Some(monitor_period), true).0.map(kind)).collect()
}

#[test]
fn bare_switches_and_a_watchful_monitor_always_lose_it() {
    assert_eq!(fates(MS), BTreeSet::from([Some("bus")]));
}

#[test]
fn bare_switches_and_a_lazy_monitor_lose_it_under_some_schedules() {
    assert_eq!(fates(Duration::from_millis(150)), BTreeSet::from([None, Some("bus")]));
}

fn kind((_, law): (Instant, Law)) -> &'static str {
    match law {
        Law::BusTripped { .. } => "bus",
        Law::PropulsionTripped { .. } => "propulsion",
        Law::SpunUp { .. } => "spin",
    }
}

#[test]
fn the_same_seed_flies_the_same_flight() {
    for seed in 0..100 {
        assert_eq!(fly(seed, Some(MS), true), fly(seed, Some(MS), true), "seed {seed}");
    }
}

#[test]
fn commands_are_traced_under_the_names_of_their_threads() {
    let (_, _, trace) = fly(1, Some(MS), true);
    let sources: BTreeSet<&str> = trace.iter().map(|received| &*received.by).skip(1).collect();
    assert_eq!(sources, BTreeSet::from(["monitor", "rescue"]));
}

/// Another thread runs while a command is on its way, so one that was admitted
/// before can arrive after.
#[test]
fn others_run_inside_a_command() {
    let spacecraft = spacecraft(0);
    let mut threads = Interleaver::new(spacecraft.clock(), 0);
    for name in ["one", "two"] {
        threads.spawn(name, Priority::SCIENCE, || {
            let _ = spacecraft.bare_heaters().issue(faregate_devices_sim::HeatersCommand::On);
        });
    }
    threads.run(END);
    let trace = spacecraft.trace();
    assert!(trace[1].begun < trace[0].done.unwrap(), "{trace:#?}");
    assert!(spacecraft.clock().now() <= Instant::START.after(MS));
}
