//! Modes: while one lasts, some tasks do not run.

use crate::manager::demand::{Demand, bit_of};
use crate::manager::step::Step;
use crate::manager::{Action, Manager, Note, Record, WaitsFor};
use crate::task::TaskPriority;

/// The modes that were entered and not left.
#[derive(Clone, Debug, Default)]
pub(crate) struct Modes {
    entered: Vec<Mode>,
}

#[derive(Clone, Debug)]
struct Mode {
    name: String,
    floor: TaskPriority,
    blocks: u128,
    gates: u128,
}

impl Modes {
    /// The mode that keeps such a task from running, if one does.
    pub(crate) fn against(&self, priority: TaskPriority, demand: &Demand) -> Option<WaitsFor> {
        let keeps = |mode: &&Mode| {
            priority.level() < mode.floor.level()
                || mode.blocks & demand.categories != 0
                || mode.gates & demand.gates != 0
        };
        self.entered.iter().find(keeps).map(|mode| WaitsFor::Mode(mode.name.clone()))
    }

    pub(crate) fn is_in(&self, name: &str) -> bool {
        self.entered.iter().any(|mode| mode.name == name)
    }
}

impl Step<'_> {
    /// Enters a mode. One that was entered already goes on.
    ///
    /// # Errors
    /// When the mission does not have it.
    pub(crate) fn enter_mode(&mut self, name: &str) -> Result<(), String> {
        let Some(spec) = self.manager.mission.modes.iter().find(|mode| mode.name == name) else {
            return Err(format!("the mission has no mode {name}"));
        };
        if self.manager.modes.is_in(name) {
            return Ok(());
        }
        let mode = Mode {
            name: name.to_owned(),
            floor: spec.floor,
            blocks: spec.blocks.mask(),
            gates: self.manager.gate_bits(&spec.reserves),
        };
        let reserves = !spec.reserves.is_empty();
        self.manager.modes.entered.push(mode);
        self.write(Record::Mode { name: name.to_owned(), entered: true });
        self.act(crate::manager::Action::Sync);
        if reserves {
            self.act(Action::Reserve { mode: name.to_owned() });
        }
        self.note(Note::Mode { name: name.to_owned(), entered: true });
        Ok(())
    }

    /// Leaves a mode.
    ///
    /// # Errors
    /// When it was not entered.
    pub(crate) fn leave_mode(&mut self, name: &str) -> Result<(), String> {
        if !self.manager.modes.is_in(name) {
            return Err(format!("mode {name} was not entered"));
        }
        self.manager.modes.entered.retain(|mode| mode.name != name);
        self.write(Record::Mode { name: name.to_owned(), entered: false });
        self.act(crate::manager::Action::Sync);
        let spec = self.manager.mission.modes.iter().find(|mode| mode.name == name);
        if spec.is_some_and(|spec| !spec.reserves.is_empty()) {
            self.act(Action::Unreserve { mode: name.to_owned() });
        }
        self.note(Note::Mode { name: name.to_owned(), entered: false });
        Ok(())
    }
}

impl Manager {
    pub(crate) fn gate_bits(&self, gates: &[String]) -> u128 {
        let devices = self.mission.devices.iter().enumerate();
        devices
            .filter(|(_, device)| gates.contains(&device.name))
            .map(|(index, _)| bit_of(index))
            .fold(0, |bits, bit| bits | bit)
    }

    /// The first of these gates, by name.
    pub(crate) fn gate_name(&self, bits: u128) -> String {
        let mut devices = self.mission.devices.iter().enumerate();
        let gate = devices.find(|(index, _)| bits & bit_of(*index) != 0);
        gate.map(|(_, device)| device.name.clone()).unwrap_or_default()
    }
}
