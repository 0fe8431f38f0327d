//! The thread bodies that all designs share. They know nothing of each other,
//! and nothing of how their commands reach the devices.

use faregate::tickets::clock::{Clock, Duration, Instant};
use faregate::tickets::device::Power;
use faregate_devices_sim::{CameraCommand, DeviceId, Spacecraft};

use crate::scene::{Monitor, Scene};
use crate::stage::Stage;
use crate::tape::Tape;

const MS: Duration = Duration::from_millis(1);

/// Keeps the camera on and exposing, for the observation. It asserts its goal
/// in each period, and turns the camera on again whenever it finds it off.
pub(crate) fn camera_monitor(
    stage: &Stage,
    craft: &Spacecraft,
    monitor: Monitor,
    mut command: impl FnMut(CameraCommand) -> bool,
) {
    let mut refused = 0_u32;
    while stage.goes_on() {
        let on = craft.estimate(DeviceId::Camera).is_some_and(|seen| seen.state == Power::On);
        let issued = command(CameraCommand::On);
        tell_refusals(stage, issued, &mut refused);
        if on {
            command(CameraCommand::Expose);
        }
        stage.wait(monitor.period);
    }
}

fn tell_refusals(stage: &Stage, issued: bool, refused: &mut u32) {
    match (issued, *refused) {
        (false, 0) => {
            stage.tell("monitor", || "camera on: refused, and tries again and again".into())
        }
        (true, 1..) => {
            stage.tell("monitor", || format!("camera on: issued, after {refused} refusals"))
        }
        _ => {}
    }
    *refused = if issued { 0 } else { *refused + 1 };
}

/// Waits until the body spins faster than this; false if the run ends first.
pub(crate) fn wait_for_spin(stage: &Stage, craft: &Spacecraft, urad_s: u64) -> bool {
    while stage.goes_on() {
        if craft.measured_rate_urad_s().is_some_and(|rate| rate.value > urad_s) {
            return true;
        }
        stage.wait(MS.saturating_mul(2));
    }
    false
}

/// Whether the cutoff valve is measured shut.
pub(crate) fn is_shut(craft: &Spacecraft) -> bool {
    craft.measured_cutoff_shut().is_some_and(|shut| shut.value)
}

/// Turns the camera off and waits for a fresh estimate that says so; again and
/// again.
pub(crate) fn camera_off_for_sure(
    stage: &Stage,
    scene: &Scene,
    craft: &Spacecraft,
    mut off: impl FnMut(),
) {
    let parameters = &scene.parameters;
    while stage.goes_on() {
        off();
        let at_rest = stage.clock.now().after(parameters.camera_settling);
        let due =
            at_rest.after(parameters.sensor_lag).after(parameters.sensor_period.saturating_mul(2));
        while stage.goes_on() && stage.clock.now() <= due {
            stage.wait(MS);
            if is_freshly_off(craft, DeviceId::Camera, at_rest) {
                return;
            }
        }
    }
}

/// Whether a measurement later than this instant says off.
pub(crate) fn is_freshly_off(craft: &Spacecraft, device: DeviceId, after: Instant) -> bool {
    let seen = craft.estimate(device);
    seen.is_some_and(|seen| seen.state == Power::Off && seen.measured_at > after)
}

/// Drives the cutoff valve's coil until the valve is measured shut.
pub(crate) fn shut_for_sure(
    stage: &Stage,
    scene: &Scene,
    craft: &Spacecraft,
    mut shut: impl FnMut() -> bool,
) -> Option<Instant> {
    let mut first = None;
    let pulse = scene.parameters.cutoff_pulse.saturating_add(scene.parameters.sensor_lag);
    while stage.goes_on() && !is_shut(craft) {
        if shut() {
            first = first.or(Some(stage.clock.now()));
        }
        let again_at = stage.clock.now().after(pulse).after(MS.saturating_mul(12));
        while stage.goes_on() && stage.clock.now() < again_at && !is_shut(craft) {
            stage.wait(MS);
        }
    }
    first
}

/// Watches the run, as the ground would if it could: ends it when the
/// spacecraft is lost, or saved and observing again.
pub(crate) fn director(stage: &Stage, scene: &Scene, craft: &Spacecraft, tape: &Tape) {
    let mut shut_at = None;
    while stage.goes_on() {
        let truth = craft.truth();
        tape.sample(truth);
        if let Some((at, law)) = craft.broken_law() {
            stage.tell("SPACECRAFT", || format!("LOST at {at}: {law}"));
            break;
        }
        if truth.cutoff_shut && shut_at.is_none() {
            shut_at = Some((truth.at, truth.exposures_finished));
            stage.tell("spacecraft", || "the cutoff valve is shut; the rate grows no more".into());
        }
        let observed = shut_at.is_some_and(|(_, before)| truth.exposures_finished > before);
        let deadline_over = truth.at > scene.parameters.exposure_deadline;
        // The coil's pulse may still be to come to its end.
        let settled = shut_at.is_some_and(|(at, _)| truth.at > at.after(MS.saturating_mul(300)));
        if observed || (settled && (deadline_over || scene.monitor.is_none())) {
            break;
        }
        stage.wait(tape.period());
    }
    stage.end();
}
