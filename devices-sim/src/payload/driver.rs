//! The driver of a unit: the handle that goes into a gate.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

use faregate_tickets::clock::Clock;
use faregate_tickets::device::{Declaration, Device, Profile};

use super::Shared;
use super::unit::{CommandHelp, UnitCommand};
use crate::interleave;

/// A driver of one unit. There is one, and it cannot be copied.
pub struct UnitDriver {
    shared: Arc<Shared>,
    index: usize,
}

impl UnitDriver {
    pub(crate) const fn new(shared: Arc<Shared>, index: usize) -> Self {
        Self { shared, index }
    }

    /// What its unit understands. It answers when the driver is behind a gate.
    #[must_use]
    pub fn words(&self) -> UnitWords {
        UnitWords { shared: Arc::clone(&self.shared), index: self.index }
    }

    /// What its unit can be told.
    #[must_use]
    pub fn commands(&self) -> &'static [CommandHelp] {
        self.shared.spec(self.index).commands()
    }

    /// The command that this says; see [`UnitSpec::parse`](super::UnitSpec::parse).
    ///
    /// # Errors
    /// Why it says none, and what the unit understands.
    pub fn parse(&self, name: &str, arguments: &[String]) -> Result<UnitCommand, String> {
        self.shared.spec(self.index).parse(name, arguments)
    }

    /// Sends a command. It takes effect when it has been on its way for its
    /// time; others run meanwhile.
    fn give(&self, command: UnitCommand, safing: bool) -> Result<(), UnitFault> {
        let Shared { clock, bus, .. } = &*self.shared;
        interleave::switch_point("command begins");
        let (entry, time) = bus.lock().begin(clock.now(), self.index, command, safing);
        clock.wait_until(clock.now().after(time));
        let lived = bus.lock().arrive(clock.now(), entry);
        interleave::switch_point("command ends");
        let fault = || UnitFault { unit: self.shared.spec(self.index).name.clone() };
        if lived { Ok(()) } else { Err(fault()) }
    }
}

impl Device for UnitDriver {
    type Command = UnitCommand;
    type Response = ();
    type Fault = UnitFault;

    fn profile(&self) -> Profile {
        self.shared.spec(self.index).profile()
    }

    fn declare(command: &UnitCommand) -> Declaration {
        command.declaration()
    }

    fn issue(&mut self, command: UnitCommand) -> Result<(), UnitFault> {
        self.give(command, false)
    }

    fn safe(&mut self) -> Result<(), UnitFault> {
        self.give(self.shared.spec(self.index).safing(), true)
    }
}

impl fmt::Debug for UnitDriver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "UnitDriver({})", self.shared.spec(self.index).name)
    }
}

/// The words of a unit: they make commands, and give none.
#[derive(Clone)]
pub struct UnitWords {
    shared: Arc<Shared>,
    index: usize,
}

impl UnitWords {
    /// What the unit can be told.
    #[must_use]
    pub fn commands(&self) -> &'static [CommandHelp] {
        self.shared.spec(self.index).commands()
    }

    /// The command that this says; see [`UnitSpec::parse`](super::UnitSpec::parse).
    ///
    /// # Errors
    /// Why it says none, and what the unit understands.
    pub fn parse(&self, name: &str, arguments: &[String]) -> Result<UnitCommand, String> {
        self.shared.spec(self.index).parse(name, arguments)
    }
}

impl fmt::Debug for UnitWords {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "UnitWords({})", self.shared.spec(self.index).name)
    }
}

/// The bus is dead: no unit takes a command any more.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct UnitFault {
    /// Whose driver.
    pub unit: String,
}

impl fmt::Display for UnitFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` did not take the command: its bus has no power", self.unit)
    }
}

impl Error for UnitFault {}
