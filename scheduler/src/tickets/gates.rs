//! The gates of a mission, by name.

use core::fmt;
use std::collections::BTreeMap;
use std::sync::Arc;

use faregate_runtime::Handle;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::Profile;
use faregate_tickets::id::GateId;

use super::driver::{Catalogue, CommandSpec, GateCommand, GateDevice};

/// The gates of a mission, by name. No authority comes with it.
#[derive(Default)]
pub struct Gates {
    gates: Vec<NamedGate>,
    by_name: BTreeMap<String, usize>,
}

pub(super) struct NamedGate {
    pub(super) name: String,
    pub(super) handle: Handle<GateDevice>,
    catalogue: Arc<dyn Catalogue>,
    profile: Profile,
}

impl NamedGate {
    pub(super) fn new(
        name: &str,
        handle: Handle<GateDevice>,
        catalogue: Arc<dyn Catalogue>,
        profile: Profile,
    ) -> Self {
        Self { name: name.to_owned(), handle, catalogue, profile }
    }

    pub(super) fn parse(&self, name: &str, arguments: &[String]) -> Result<GateCommand, String> {
        self.catalogue.parse(name, arguments)
    }
}

impl Gates {
    /// The names, in the mission's order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.gates.iter().map(|gate| gate.name.as_str())
    }

    /// The broker's number of a gate: for estimates of its device.
    #[must_use]
    pub fn id(&self, name: &str) -> Option<GateId> {
        Some(self.get(name)?.handle.gate())
    }

    /// What a gate's device understands.
    #[must_use]
    pub fn commands(&self, name: &str) -> Option<Vec<CommandSpec>> {
        Some(self.get(name)?.catalogue.commands())
    }

    /// What is declared of a gate's device.
    #[must_use]
    pub fn profile(&self, name: &str) -> Option<&Profile> {
        Some(&self.get(name)?.profile)
    }

    /// The longest time that a command may take, where it is declared. What
    /// the arguments would change is not known without them.
    #[must_use]
    pub fn wcet(&self, gate: &str, command: &str) -> Option<Duration> {
        let gate = self.get(gate)?;
        let exact = gate.parse(command, &[]).map(|command| command.declaration().wcet).ok();
        let known = || gate.catalogue.commands().iter().any(|spec| spec.name == command);
        exact.or_else(|| known().then_some(gate.profile.longest_command))
    }

    pub(super) fn add(&mut self, gate: NamedGate) {
        self.by_name.insert(gate.name.clone(), self.gates.len());
        self.gates.push(gate);
    }

    pub(super) fn get(&self, name: &str) -> Option<&NamedGate> {
        self.gates.get(*self.by_name.get(name)?)
    }

    /// A gate as people call it.
    pub(super) fn called(&self, id: GateId) -> String {
        let gate = self.gates.iter().find(|gate| gate.handle.gate() == id);
        gate.map_or_else(|| "its place".to_owned(), |gate| gate.name.clone())
    }
}

impl fmt::Debug for Gates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}
