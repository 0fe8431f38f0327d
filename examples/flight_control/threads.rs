//! The threads. None knows of another.

use faregate::prelude::*;
use faregate_devices_sim::{
    CameraCommand, CutoffCommand, DeviceId, HeatersCommand, Spacecraft, ThrusterCommand,
};

use crate::craft::{Craft, Torque};
use crate::rhythm::Rhythm;
use crate::support::{Outcome, claim, wait_for};
use crate::tally::Tally;

const SECOND: Duration = Duration::from_secs(1);

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Holds the attitude with the wheel, and unloads the wheel with a pulse of the
/// thruster for one cycle in twenty, as soon as the interlock agrees.
pub(crate) fn attitude_control(craft: &Craft, until: Instant) -> Outcome<Tally> {
    let mut tally = Tally::begin("attitude control", 60);
    let broker = &craft.broker;
    let wheel = broker.request(Priority::ENGINEERING, &craft.wheel)?;
    let valve =
        broker.request(Priority::ENGINEERING, &craft.valve.limited(Function::interlock()))?;
    broker.wait(&wheel, SECOND)?;
    broker.wait(&valve, SECOND)?;

    let mut rhythm = Rhythm::new(craft.spacecraft.clock(), ms(10), until);
    let (mut open, mut pulse_due) = (false, 20);
    while rhythm.next_cycle() {
        let rate = craft.spacecraft.measured_rate_urad_s().map_or(0, |rate| rate.value);
        let unm = i64::try_from(rate).unwrap_or(i64::MAX).saturating_neg();
        tally.count(wheel.invoke(Torque { unm }));
        // Most cycles have no command for the valve; this says that we live.
        tally.note(valve.renew());
        if open {
            tally.count(valve.invoke(ThrusterCommand::Close));
            open = false;
        } else if rhythm.cycles >= pulse_due {
            open = tally.count(valve.invoke(ThrusterCommand::Open));
            pulse_due = if open { rhythm.cycles + 20 } else { pulse_due };
        }
    }
    // It may refuse, if it was taken: then the valve has been made safe.
    tally.count(valve.invoke(ThrusterCommand::Close));
    Ok(tally.end(&rhythm))
}

/// Heats the catalyst bed for two cycles in five.
pub(crate) fn heater_control(craft: &Craft, until: Instant) -> Outcome<Tally> {
    let mut tally = Tally::begin("heater control", 50);
    let want = craft.heaters.limited(Function::interlock());
    let heaters = craft.broker.request(Priority::new(100), &want)?;
    craft.broker.wait(&heaters, SECOND)?;

    let mut rhythm = Rhythm::new(craft.spacecraft.clock(), ms(100), until);
    while rhythm.next_cycle() {
        let heats = rhythm.cycles % 5 < 2;
        let command = if heats { HeatersCommand::On } else { HeatersCommand::Off };
        tally.count(heaters.invoke(command));
    }
    Ok(tally.end(&rhythm))
}

/// Keeps the camera on and exposing. It has never heard of thrusters: that the
/// camera goes off is an anomaly to it, and it turns the camera on again.
pub(crate) fn camera_monitor(craft: &Craft, until: Instant) -> Outcome<Tally> {
    let mut tally = Tally::begin("camera monitor", 40);
    let camera = craft.broker.request(Priority::SCIENCE, &craft.camera)?;
    craft.broker.wait(&camera, SECOND)?;

    let mut rhythm = Rhythm::new(craft.spacecraft.clock(), ms(20), until);
    while rhythm.next_cycle() {
        let seen = craft.spacecraft.estimate(DeviceId::Camera);
        let is_on = seen.is_some_and(|seen| seen.state == Power::On);
        let command = if is_on { CameraCommand::Expose } else { CameraCommand::On };
        tally.count(camera.invoke(command));
    }
    Ok(tally.end(&rhythm))
}

/// Watches for a thruster that pushes though its valve is seen shut, and cuts
/// it off. It knows nothing of cameras and heaters.
pub(crate) fn fault_response(craft: &Craft, until: Instant) -> Outcome<(Tally, Option<Rescue>)> {
    let mut tally = Tally::begin("fault response", 70);
    let mut rhythm = Rhythm::new(craft.spacecraft.clock(), ms(10), until);
    let mut shut_since = None;
    let mut rescue = None;
    while rescue.is_none() && rhythm.next_cycle() {
        if pushes_though_shut(&craft.spacecraft, &mut shut_since) {
            rescue = Some(Rescue::fly(craft, &mut tally)?);
        }
    }
    Ok((tally.end(&rhythm), rescue))
}

/// Whether the rate has grown by more than any pulse that is still on its way
/// through the sensors could explain, since the valve was seen shut.
fn pushes_though_shut(spacecraft: &Spacecraft, rate_then: &mut Option<u64>) -> bool {
    const SUSPICIOUS_URAD_S: u64 = 4_000;
    let shut = spacecraft.estimate(DeviceId::Thruster).is_some_and(|seen| seen.state == Power::Off);
    let Some(rate) = spacecraft.measured_rate_urad_s().filter(|_| shut) else {
        *rate_then = None;
        return false;
    };
    rate.value > rate_then.get_or_insert(rate.value).saturating_add(SUSPICIOUS_URAD_S)
}

/// What the fault response did, and when.
pub(crate) struct Rescue {
    pub(crate) ticket: TicketId,
    pub(crate) requested: Instant,
    pub(crate) valid: Instant,
    pub(crate) seen_shut: Instant,
    pub(crate) relinquished: Instant,
}

impl Rescue {
    fn fly(craft: &Craft, tally: &mut Tally) -> Outcome<Self> {
        let clock = craft.spacecraft.clock();
        let requested = clock.now();
        let cutoff = craft.broker.request(Priority::EMERGENCY, &craft.cutoff)?;
        craft.broker.wait(&cutoff, SECOND)?;
        let valid = clock.now();
        tally.count(cutoff.invoke(CutoffCommand::Shut));
        let is_shut = || craft.spacecraft.measured_cutoff_shut().is_some_and(|shut| shut.value);
        claim(wait_for(clock, SECOND, is_shut), "the cutoff valve shuts")?;
        let seen_shut = clock.now();
        tally.count(cutoff.invoke(CutoffCommand::CoilOff));
        let relinquished = clock.now();
        Ok(Self { ticket: cutoff.id(), requested, valid, seen_shut, relinquished })
    }
}
