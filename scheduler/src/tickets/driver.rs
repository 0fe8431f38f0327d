//! Devices that are commanded by name: a driver that says what it understands,
//! behind a gate like any other.

use core::fmt;
use std::sync::Arc;

use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::device::{Declaration, Profile, WhenOrphaned};

/// How many numbers a command carries.
pub const ARGUMENTS: usize = 4;
/// How many bytes a device can say in one answer.
pub const ANSWER: usize = 96;

/// A driver whose commands have names. It is moved behind its gate, and is then
/// reached by tickets alone.
///
/// It must be the only handle to its hardware, as for
/// [`Device`](faregate_tickets::Device).
pub trait Driver: Send + 'static {
    /// What is declared of the device as a whole. Read once.
    fn profile(&self) -> Profile;

    /// What it understands. Asked for once, before the driver goes behind its
    /// gate: it answers without the driver.
    fn catalogue(&self) -> Arc<dyn Catalogue>;

    /// Gives the command to the hardware.
    ///
    /// # Errors
    /// Why the hardware did not take it. The gate is faulted then, until a
    /// supervisor resets it.
    fn issue(&mut self, command: &GateCommand) -> Result<Reply, Fault>;

    /// Frees the device's draw.
    ///
    /// # Errors
    /// As for [`Driver::issue`].
    fn safe(&mut self) -> Result<(), Fault>;

    /// Waits until every command given so far has reached the device.
    ///
    /// # Errors
    /// As for [`Driver::issue`].
    fn drain(&mut self) -> Result<(), Fault> {
        Ok(())
    }
}

/// The commands of one device, by name.
pub trait Catalogue: Send + Sync {
    /// What there is, for people.
    fn commands(&self) -> Vec<CommandSpec>;

    /// The command that this says.
    ///
    /// # Errors
    /// Why it says none, for people: there is no such command, or not with
    /// these arguments.
    fn parse(&self, name: &str, arguments: &[String]) -> Result<GateCommand, String>;
}

/// A command, for people.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct CommandSpec {
    /// Its name.
    pub name: String,
    /// Its arguments, as they are asked for.
    pub arguments: Vec<String>,
    /// What it does.
    pub help: String,
}

/// One command, as numbers: plain data that means the same whenever it is looked
/// at. A gate is only given what its own catalogue made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GateCommand {
    declaration: Declaration,
    arguments: [i64; ARGUMENTS],
}

impl GateCommand {
    /// A command of which this is declared, with these arguments.
    #[must_use]
    pub const fn new(declaration: Declaration, arguments: [i64; ARGUMENTS]) -> Self {
        Self { declaration, arguments }
    }

    /// What is declared of it; its code tells it apart.
    #[must_use]
    pub const fn declaration(&self) -> Declaration {
        self.declaration
    }

    /// Its arguments.
    #[must_use]
    pub const fn arguments(&self) -> [i64; ARGUMENTS] {
        self.arguments
    }
}

/// What a device says, in place: nothing is allocated behind a gate. What does
/// not fit is cut off.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Answer(heapless::String<ANSWER>);

/// What a device answers to a command.
pub type Reply = Answer;
/// Why a device did not do what it was told.
pub type Fault = Answer;

impl Answer {
    /// Nothing to say.
    #[must_use]
    pub const fn none() -> Self {
        Self(heapless::String::new())
    }

    /// This, as far as it fits.
    #[must_use]
    pub fn of(text: impl fmt::Display) -> Self {
        let mut answer = Cut(heapless::String::new());
        // What does not fit ends the writing: that is meant.
        let _ = fmt::Write::write_fmt(&mut answer, format_args!("{text}"));
        Self(answer.0)
    }

    /// What it says.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Takes text as long as there is room for a whole character.
struct Cut(heapless::String<ANSWER>);

impl fmt::Write for Cut {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.chars().try_for_each(|character| self.0.push(character).map_err(|_| fmt::Error))
    }
}

/// A driver behind a gate.
pub struct GateDevice {
    driver: Box<dyn Driver>,
    profile: Profile,
}

impl GateDevice {
    /// It is charged this draw, if the driver does not declare more. A device
    /// whose task has lost it is made safe: nobody may be left to turn it off.
    pub(super) fn new(driver: Box<dyn Driver>, draw: Milliwatts) -> Self {
        let profile = driver.profile();
        let profile = Profile { when_orphaned: WhenOrphaned::SafeUnlessHeld, ..profile };
        Self { driver, profile: profile.drawing(profile.draw.max(draw)) }
    }
}

impl Device for GateDevice {
    type Command = GateCommand;
    type Response = Reply;
    type Fault = Fault;

    fn profile(&self) -> Profile {
        self.profile
    }

    fn declare(command: &GateCommand) -> Declaration {
        command.declaration
    }

    fn issue(&mut self, command: GateCommand) -> Result<Reply, Fault> {
        self.driver.issue(&command)
    }

    fn safe(&mut self) -> Result<(), Fault> {
        self.driver.safe()
    }

    fn drain(&mut self) -> Result<(), Fault> {
        self.driver.drain()
    }
}

impl fmt::Debug for GateDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("GateDevice")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_is_too_long_is_cut_between_characters() {
        let text = "é".repeat(ANSWER);
        let answer = Answer::of(&text);
        assert_eq!(answer.as_str(), "é".repeat(ANSWER / 2));
        assert_eq!(Answer::of(42).as_str(), "42");
    }
}
