//! A typed device, with names for its commands.

use core::fmt;
use std::sync::Arc;

use faregate_tickets::Device;
use faregate_tickets::device::Profile;

use super::driver::{Catalogue, CommandSpec, Driver, Fault, GateCommand, Reply};

/// A typed [`Device`] whose commands tasks can name. Each name is one command:
/// one that has arguments of its own takes a [`Driver`] of its own.
///
/// ```
/// # use faregate_tickets::Device;
/// # use faregate_tickets::clock::Duration;
/// # use faregate_tickets::device::{Declaration, Effect, Profile};
/// use faregate_scheduler::tickets::{Catalogue, Driver, Named};
///
/// # #[derive(Debug)]
/// # struct Lamp;
/// # #[derive(Clone, Copy)]
/// # enum Switch { On, Off }
/// # impl Device for Lamp {
/// #     type Command = Switch;
/// #     type Response = ();
/// #     type Fault = ();
/// #     fn profile(&self) -> Profile { Profile::new() }
/// #     fn declare(command: &Switch) -> Declaration {
/// #         let wcet = Duration::from_millis(1);
/// #         Declaration { code: *command as u16, wcet, effect: Effect::Unchanged }
/// #     }
/// #     fn issue(&mut self, _: Switch) -> Result<(), ()> { Ok(()) }
/// #     fn safe(&mut self) -> Result<(), ()> { Ok(()) }
/// # }
/// let lamp = Named::new(Lamp)
///     .command("on", Switch::On, "light the lamp")
///     .command("off", Switch::Off, "darken it");
/// let catalogue = lamp.catalogue();
/// assert!(catalogue.parse("on", &[]).is_ok());
/// let refused = catalogue.parse("blink", &[]).unwrap_err();
/// assert_eq!(refused, "it has no command `blink`; it has on, off");
/// ```
pub struct Named<D: Device> {
    device: D,
    names: Vec<Name<D::Command>>,
    answer: fn(D::Response) -> Reply,
}

#[derive(Clone)]
struct Name<C> {
    name: &'static str,
    command: C,
    help: &'static str,
}

impl<D: Device> Named<D> {
    /// A device without names.
    #[must_use]
    pub fn new(device: D) -> Self {
        Self { device, names: Vec::new(), answer: |_| Reply::none() }
    }

    /// This name stands for this command.
    #[must_use]
    pub fn command(mut self, name: &'static str, command: D::Command, help: &'static str) -> Self {
        self.names.push(Name { name, command, help });
        self
    }

    /// What its responses say. Without this they say nothing.
    #[must_use]
    pub fn answering(mut self, answer: fn(D::Response) -> Reply) -> Self {
        self.answer = answer;
        self
    }
}

impl<D> Driver for Named<D>
where
    D: Device + 'static,
    D::Command: Send + Sync + 'static,
    D::Fault: fmt::Debug,
    D::Response: 'static,
{
    fn profile(&self) -> Profile {
        self.device.profile()
    }

    fn catalogue(&self) -> Arc<dyn Catalogue> {
        let commands = self.names.iter().zip(0..).map(|(name, number)| {
            let declaration = D::declare(&name.command);
            let command = GateCommand::new(declaration, [number, 0, 0, 0]);
            Name { name: name.name, command, help: name.help }
        });
        Arc::new(Names(commands.collect()))
    }

    fn issue(&mut self, command: &GateCommand) -> Result<Reply, Fault> {
        let [number, ..] = command.arguments();
        let named = usize::try_from(number).ok().and_then(|number| self.names.get(number));
        let named = named.ok_or_else(|| Fault::of("no such command"))?;
        let response = self.device.issue(named.command);
        response.map(self.answer).map_err(|fault| Fault::of(format_args!("{fault:?}")))
    }

    fn safe(&mut self) -> Result<(), Fault> {
        self.device.safe().map_err(|fault| Fault::of(format_args!("{fault:?}")))
    }

    fn drain(&mut self) -> Result<(), Fault> {
        self.device.drain().map_err(|fault| Fault::of(format_args!("{fault:?}")))
    }
}

impl<D: Device> fmt::Debug for Named<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.names.iter().map(|name| name.name);
        f.write_str("Named")?;
        f.debug_list().entries(names).finish()
    }
}

struct Names(Vec<Name<GateCommand>>);

impl Catalogue for Names {
    fn commands(&self) -> Vec<CommandSpec> {
        let spec = |name: &Name<GateCommand>| CommandSpec {
            name: name.name.to_owned(),
            arguments: Vec::new(),
            help: name.help.to_owned(),
        };
        self.0.iter().map(spec).collect()
    }

    fn parse(&self, name: &str, arguments: &[String]) -> Result<GateCommand, String> {
        let Some(named) = self.0.iter().find(|known| known.name == name) else {
            let known: Vec<_> = self.0.iter().map(|known| known.name).collect();
            return Err(format!("it has no command `{name}`; it has {}", known.join(", ")));
        };
        if !arguments.is_empty() {
            return Err(format!("`{name}` takes no argument"));
        }
        Ok(named.command)
    }
}
