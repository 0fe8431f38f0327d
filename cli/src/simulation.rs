//! The mission's devices, simulated.

use faregate_devices_sim::payload::UnitSpec;
use faregate_scheduler::Mission;
use faregate_scheduler::mission::DeviceSpec;

/// The kind of a device that is the battery: it has no gate.
const BATTERY: &str = "battery";

/// The units of the mission, and everything that is wrong with them, each with
/// the name of its device.
pub(crate) fn units(mission: &Mission) -> (Vec<UnitSpec>, Vec<(String, String)>) {
    let (mut units, mut wrong) = (Vec::new(), Vec::new());
    for device in mission.devices.iter().filter(|device| device.kind != BATTERY) {
        match unit(device) {
            Ok(unit) => units.push(unit),
            Err(why) => wrong.extend(why.into_iter().map(|why| (device.name.clone(), why))),
        }
    }
    (units, wrong)
}

fn unit(device: &DeviceSpec) -> Result<UnitSpec, Vec<String>> {
    UnitSpec::new(&device.name, &device.kind, device.draw, &device.parameters)
}
