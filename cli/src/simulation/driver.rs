//! A simulated unit behind a gate: its commands have names.

use std::sync::Arc;

use faregate_devices_sim::payload::{UnitCommand, UnitDriver, UnitWords};
use faregate_scheduler::tickets::{Catalogue, CommandSpec, Driver, Fault, GateCommand, Reply};
use faregate_tickets::Device;
use faregate_tickets::device::Profile;

/// The driver of a unit, for a gate that takes commands by name.
#[derive(Debug)]
pub(crate) struct Simulated(pub(crate) UnitDriver);

impl Driver for Simulated {
    fn profile(&self) -> Profile {
        self.0.profile()
    }

    fn catalogue(&self) -> Arc<dyn Catalogue> {
        Arc::new(Words(self.0.words()))
    }

    fn issue(&mut self, command: &GateCommand) -> Result<Reply, Fault> {
        let [argument, ..] = command.arguments();
        let command = UnitCommand::from_numbers(command.declaration(), argument)
            .ok_or_else(|| Fault::of("no such command"))?;
        self.0.issue(command).map(|()| Reply::none()).map_err(Fault::of)
    }

    fn safe(&mut self) -> Result<(), Fault> {
        self.0.safe().map_err(Fault::of)
    }
}

/// What a unit understands.
struct Words(UnitWords);

impl Catalogue for Words {
    fn commands(&self) -> Vec<CommandSpec> {
        let spec = |command: &faregate_devices_sim::payload::CommandHelp| CommandSpec {
            name: command.name.to_owned(),
            arguments: command.argument.map(str::to_owned).into_iter().collect(),
            help: command.help.to_owned(),
        };
        self.0.commands().iter().map(spec).collect()
    }

    fn parse(&self, name: &str, arguments: &[String]) -> Result<GateCommand, String> {
        let command = self.0.parse(name, arguments)?;
        Ok(GateCommand::new(command.declaration(), [command.argument(), 0, 0, 0]))
    }
}
