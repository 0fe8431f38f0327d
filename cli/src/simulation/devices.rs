//! The devices of a mission, as units of a simulated payload.

use faregate_devices_sim::payload::{BatteryModel, UnitSpec};
use faregate_scheduler::Mission;
use faregate_scheduler::format::{Diagnostic, Place, Rule, Severity};
use faregate_scheduler::mission::DeviceSpec;

/// The kind of a device that is the battery: it has no gate.
const BATTERY: &str = "battery";

/// Fills in what only the kinds of devices know: what they draw. The manager
/// counts with it.
pub(crate) fn complete(mission: &mut Mission) {
    for device in &mut mission.devices {
        if let (None, Ok(unit)) = (device.draw, unit(device)) {
            device.draw = Some(unit.draw());
        }
    }
}

/// What is to be said of the mission's devices in a file.
pub(crate) fn doubts(mission: &Mission, file: &str) -> Vec<Diagnostic> {
    let (_, mut wrong) = units(mission);
    for device in mission.devices.iter().filter(|device| device.kind == BATTERY) {
        let why = BatteryModel::new(&device.parameters).err().unwrap_or_default();
        wrong.extend(why.into_iter().map(|why| (device.name.clone(), why)));
    }
    let doubt = |(device, why)| Diagnostic {
        severity: Severity::Warning,
        rule: Rule::UnknownName,
        file: file.to_owned(),
        place: Place { line: 1, column: 1, span: 0..0 },
        field: Some("mission.device".to_owned()),
        message: format!("the device `{device}` cannot be simulated: {why}"),
        expected: None,
        help: Some("a program of your own can bring it; `faregate run` cannot".to_owned()),
        also: None,
    };
    wrong.into_iter().map(doubt).collect()
}

/// The units of the mission, and everything that is wrong with them, each with
/// the name of its device.
pub(super) fn units(mission: &Mission) -> (Vec<UnitSpec>, Vec<(String, String)>) {
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

/// The mission with the devices that have gates alone.
pub(crate) fn gated(mission: &Mission) -> Mission {
    let mut mission = mission.clone();
    mission.devices.retain(|device| device.kind != BATTERY);
    mission
}

/// The mission's battery, if it has one.
pub(super) fn battery(mission: &Mission) -> Result<Option<BatteryModel>, Vec<String>> {
    let battery = mission.devices.iter().find(|device| device.kind == BATTERY);
    battery.map(|device| BatteryModel::new(&device.parameters)).transpose()
}

/// The agent of a device.
pub(super) fn agent_of<'a>(mission: &'a Mission, device: &str) -> Option<&'a String> {
    mission.devices.iter().find(|spec| spec.name == device).map(|spec| &spec.agent)
}
