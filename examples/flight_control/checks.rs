//! What Faregate guarantees, looked at from outside: by what the devices
//! received, and by what became of the spacecraft.

use faregate::prelude::*;
use faregate_devices_sim::{CameraCommand, Command, DeviceId, HeatersCommand, ReceivedCommand};

use crate::craft::{Craft, STICKS_AT};
use crate::support::{Outcome, claim};
use crate::tally::Tally;
use crate::threads::Rescue;

/// Tells the emergency as it happened.
pub(crate) fn tell(craft: &Craft, rescue: &Rescue, camera: &Tally) {
    let trace = craft.spacecraft.trace();
    let took = rescue.valid.since(rescue.requested);
    let mut story = vec![
        (STICKS_AT, "the thruster valve sticks open".to_owned()),
        (rescue.requested, "the fault response requests the cutoff valve".to_owned()),
        (rescue.valid, format!("its ticket is valid, after {took} of at most {}", bound(craft))),
        (rescue.seen_shut, "the cutoff valve is seen shut".to_owned()),
        (rescue.relinquished, "the fault response relinquishes its ticket".to_owned()),
    ];
    for received in trace.iter().filter(|received| received.safing) {
        story.push((received.begun, made_safe(received.command.device())));
    }
    if let Some(restored) = first_on(&trace, CameraCommand::On.into(), rescue) {
        let refused = camera.refused;
        story.push((restored.begun, format!("the camera is on again, after {refused} refusals")));
    }
    if let Some(restored) = first_on(&trace, HeatersCommand::On.into(), rescue) {
        story.push((restored.begun, "the heaters are on again".to_owned()));
    }
    story.sort_by_key(|(at, _)| *at);
    println!();
    for (at, what) in story {
        println!("{at}  {what}");
    }
    let truth = craft.spacecraft.truth();
    println!(
        "\nrate at the end: {} urad/s; {} exposures",
        truth.rate_urad_s, truth.exposures_finished
    );
}

/// No supply was overdrawn, and the spacecraft is not lost.
pub(crate) fn margin_kept(craft: &Craft) -> Outcome<()> {
    match craft.spacecraft.broken_law() {
        None => Ok(()),
        Some((at, law)) => Err(format!("the spacecraft is lost at {at}: {law}").into()),
    }
}

/// Makes sure of each other guarantee that this flight can put to the test.
pub(crate) fn check(craft: &Craft, rescue: &Rescue, tallies: &[Tally; 4]) -> Outcome<()> {
    let [_, heaters, camera, _] = tallies;
    let trace = craft.spacecraft.trace();
    for gate in [craft.valve.gate(), craft.heaters.gate(), craft.camera.gate()] {
        let report = craft.broker.agents().device(gate);
        if let Some(fault) = report.and_then(|report| report.fault) {
            return Err(format!("{gate} is faulted, {fault}: is the host too busy?").into());
        }
    }
    claim(craft.spacecraft.truth().cutoff_shut, "the cutoff valve is shut")?;
    let took = rescue.valid.since(rescue.requested);
    claim(took <= bound(craft), "Bounded Hand-over: the ticket is valid within the bound")?;
    let meanwhile = |received: &&ReceivedCommand| {
        let device = received.command.device();
        let is_victim = matches!(device, DeviceId::Camera | DeviceId::Heaters);
        let began = rescue.valid <= received.begun && received.begun < rescue.relinquished;
        is_victim && began && !received.safing
    };
    claim(
        !trace.iter().any(|received| meanwhile(&received)),
        "Closed Door: no victim is commanded",
    )?;
    claim(camera.taken_by.is_some(), "the camera monitor is refused meanwhile")?;
    for victim in [camera, heaters] {
        let true_name = victim.taken_by.is_none_or(|by| by == rescue.ticket);
        claim(true_name, "Every Refusal Explains Itself: it names who took the ticket")?;
    }
    for command in [CameraCommand::On.into(), HeatersCommand::On.into()] {
        let restored = first_on(&trace, command, rescue).is_some();
        claim(restored, "Restoration: victims go on without asking again")?;
    }
    println!("\nAll guarantees held.");
    Ok(())
}

/// Computed from the declared times, for one round of victims.
fn bound(craft: &Craft) -> Duration {
    let bound = craft.broker.agents().hand_over_bound(craft.cutoff.gate(), 1);
    bound.unwrap_or(Duration::ZERO)
}

/// The first command of this kind after the rescue that the device took.
fn first_on<'a>(
    trace: &'a [ReceivedCommand],
    command: Command,
    rescue: &Rescue,
) -> Option<&'a ReceivedCommand> {
    let after = |received: &&ReceivedCommand| received.begun >= rescue.relinquished;
    let took = |received: &&ReceivedCommand| {
        received.command == command && received.outcome == faregate_devices_sim::Outcome::Took
    };
    trace.iter().filter(after).find(took)
}

fn made_safe(device: DeviceId) -> String {
    let verb = if device == DeviceId::Heaters { "are" } else { "is" };
    format!("the {device} {verb} made safe")
}
