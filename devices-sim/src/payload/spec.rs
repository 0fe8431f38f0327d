//! Units as a mission lists them: a name, a kind, settings.

use std::collections::BTreeMap;
use std::fmt;

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Effect, Profile};

use super::settings::{Settings, thousandths};
use super::unit::{Action, CommandHelp, Unit, UnitCommand};
use super::{camera, computer, gimbal, heater, processor, transmitter};

/// The kinds of units there are.
pub const KINDS: [&str; 6] = ["camera", "computer", "gimbal", "heater", "processor", "transmitter"];

/// How often a unit's switch is looked at.
const SENSOR_PERIOD: Duration = Duration::from_millis(50);
/// From the measurement until its estimate arrives.
const SENSOR_LAG: Duration = Duration::from_millis(100);
/// What is declared of each command. It takes a hundredth of it on the wire; the
/// rest is for ordinary hosts, which keep threads from running that long.
const WCET: Duration = Duration::from_millis(100);
/// How many times that before a gate counts as faulted.
const OVERRUN_FACTOR: u8 = 10;

/// A unit of a payload.
pub struct UnitSpec {
    pub(crate) name: String,
    pub(crate) sensor_period: Duration,
    pub(crate) sensor_lag: Duration,
    kind: &'static str,
    draw: Milliwatts,
    commands: &'static [CommandHelp],
    make: Box<dyn Fn() -> Box<dyn Unit> + Send + Sync>,
}

impl UnitSpec {
    /// A unit of this kind. Its largest draw is `draw`, or what its kind draws
    /// with these settings.
    ///
    /// # Errors
    /// Everything that is wrong with them: an unknown kind, an unknown setting,
    /// a value that is none, a `draw` that is less than the unit takes.
    pub fn new(
        name: &str,
        kind: &str,
        draw: Option<Milliwatts>,
        given: &BTreeMap<String, String>,
    ) -> Result<Self, Vec<String>> {
        let mut settings = Settings::new(given);
        let Some(model) = model(kind, &mut settings) else {
            return Err(vec![format!(
                "`{kind}` is no kind of unit; there are {}",
                KINDS.join(", ")
            )]);
        };
        let sensor_period = settings.seconds("sensor_period_s", SENSOR_PERIOD);
        let sensor_lag = settings.seconds("sensor_lag_s", SENSOR_LAG);
        let Model { kind, commands, largest, make } = settings.finish(kind, model)?;
        if let Some(draw) = draw.filter(|draw| *draw < largest) {
            return Err(vec![format!(
                "a draw of {draw} is declared for `{name}`, but it can draw {largest}"
            )]);
        }
        let draw = draw.unwrap_or(largest);
        Ok(Self { name: name.into(), sensor_period, sensor_lag, kind, draw, commands, make })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its largest draw.
    #[must_use]
    pub const fn draw(&self) -> Milliwatts {
        self.draw
    }

    /// What it can be told.
    #[must_use]
    pub const fn commands(&self) -> &'static [CommandHelp] {
        self.commands
    }

    /// What is declared of it.
    #[must_use]
    pub fn profile(&self) -> Profile {
        let mut profile = Profile::new().drawing(self.draw);
        profile.longest_command = WCET;
        profile.longest_safing = WCET;
        profile.estimate_lag = self.sensor_lag.saturating_add(self.sensor_period.saturating_mul(2));
        profile.overrun_factor = OVERRUN_FACTOR;
        profile
    }

    /// The command that this says.
    ///
    /// # Errors
    /// Why it says none, and what the unit understands.
    pub fn parse(&self, name: &str, arguments: &[String]) -> Result<UnitCommand, String> {
        let Some(help) = self.commands.iter().find(|help| help.name == name) else {
            let known = self.commands.iter().map(|help| help.name).collect::<Vec<_>>().join(", ");
            return Err(format!("a {} has no command `{name}`; it has {known}", self.kind));
        };
        let action = match (help.argument, arguments) {
            (None, []) => plain(name),
            (Some(_), [argument]) => with_argument(name, argument),
            (None, _) => return Err(format!("`{name}` takes no argument")),
            (Some(argument), _) => return Err(format!("`{name}` takes one argument: {argument}")),
        };
        let expected =
            || format!("`{}` is no {}", arguments.join(" "), help.argument.unwrap_or(""));
        let action = action.ok_or_else(expected)?;
        Ok(UnitCommand { action, wcet: WCET, effect: self.effect(action) })
    }

    fn effect(&self, action: Action) -> Effect {
        match action {
            Action::On => Effect::on(self.draw),
            Action::Off => Effect::Off,
            _ => Effect::Unchanged,
        }
    }

    /// The command that frees its draw.
    pub(crate) fn safing(&self) -> UnitCommand {
        UnitCommand { action: Action::Off, wcet: WCET, effect: Effect::Off }
    }

    pub(crate) fn make(&self) -> Box<dyn Unit> {
        (self.make)()
    }
}

impl fmt::Debug for UnitSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "UnitSpec({}: {}, {})", self.name, self.kind, self.draw)
    }
}

/// A kind with its settings.
struct Model {
    kind: &'static str,
    commands: &'static [CommandHelp],
    largest: Milliwatts,
    make: Box<dyn Fn() -> Box<dyn Unit> + Send + Sync>,
}

impl Model {
    fn new<U: Unit + Clone + Sync + 'static>(
        kind: &'static str,
        commands: &'static [CommandHelp],
        (unit, largest): (U, Milliwatts),
    ) -> Self {
        Self { kind, commands, largest, make: Box::new(move || Box::new(unit.clone())) }
    }
}

fn model(kind: &str, settings: &mut Settings<'_>) -> Option<Model> {
    Some(match kind {
        "camera" => Model::new("camera", camera::COMMANDS, camera::Camera::read(settings)),
        "computer" => {
            Model::new("computer", computer::COMMANDS, computer::Computer::read(settings))
        }
        "gimbal" => Model::new("gimbal", gimbal::COMMANDS, gimbal::Gimbal::read(settings)),
        "heater" => Model::new("heater", heater::COMMANDS, heater::Heater::read(settings)),
        "processor" => {
            Model::new("processor", processor::COMMANDS, processor::Processor::read(settings))
        }
        "transmitter" => {
            let read = transmitter::Transmitter::read(settings);
            Model::new("transmitter", transmitter::COMMANDS, read)
        }
        _ => return None,
    })
}

fn plain(name: &str) -> Option<Action> {
    match name {
        "on" => Some(Action::On),
        "off" => Some(Action::Off),
        "expose" => Some(Action::Expose),
        _ => None,
    }
}

fn with_argument(name: &str, argument: &str) -> Option<Action> {
    match name {
        "send" => argument.parse().ok().map(Action::Send),
        "load" => argument.parse().ok().filter(|percent| *percent <= 100).map(Action::Load),
        "acquire" => u32::try_from(thousandths(argument)?).ok().map(Action::Acquire),
        "point" => {
            let (sign, angle) = argument.strip_prefix('-').map_or((1, argument), |rest| (-1, rest));
            let angle =
                i32::try_from(thousandths(angle)?).ok().filter(|angle| *angle <= 180_000)?;
            Some(Action::Point(sign * angle))
        }
        _ => None,
    }
}
