//! A camera: a file that says whether it is on. It outlives managers, as
//! hardware does.

use std::io;
use std::path::{Path, PathBuf};

use faregate_scheduler::tickets::Named;
use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Effect, Power, Profile};

use crate::truth::{Chronicle, Fact};
use crate::{Break, Failure};

/// Its gate's name.
pub(crate) const CAMERA: &str = "camera";

const DRAW: Milliwatts = Milliwatts::from_watts(8);
/// Longer than a loaded machine lets anybody wait.
const LONG: Duration = Duration::from_secs(20);

fn file(place: &Path) -> PathBuf {
    place.join(CAMERA)
}

/// What its sensor says.
pub(crate) fn measure(place: &Path, broken: Option<Break>) -> Power {
    let seen = is_on(place) && broken != Some(Break::LeftOn);
    if seen { Power::On } else { Power::Off }
}

pub(crate) fn is_on(place: &Path) -> bool {
    file(place).exists()
}

/// The driver.
pub(crate) struct Camera {
    file: PathBuf,
    chronicle: Chronicle,
    /// Whether it goes off when it is made safe.
    obeys: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Switch {
    On,
    Off,
}

pub(crate) fn driver(place: &Path, broken: Option<Break>) -> Result<Named<Camera>, Failure> {
    let chronicle = Chronicle::open(place)?;
    let camera = Camera { file: file(place), chronicle, obeys: broken != Some(Break::LeftOn) };
    let named = Named::new(camera);
    Ok(named.command("on", Switch::On, "turn it on").command("off", Switch::Off, "turn it off"))
}

impl Camera {
    /// A manager can be killed between the deed and the word. So what is written
    /// down is never that the camera is on when it is not.
    fn switch(&mut self, on: bool) -> io::Result<()> {
        if on {
            std::fs::write(&self.file, "")?;
            return self.chronicle.note(&Fact::Device(true));
        }
        self.chronicle.note(&Fact::Device(false))?;
        match std::fs::remove_file(&self.file) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

impl Device for Camera {
    type Command = Switch;
    type Response = ();
    type Fault = io::Error;

    fn profile(&self) -> Profile {
        Profile {
            longest_command: LONG,
            longest_safing: LONG,
            estimate_lag: LONG,
            lease: LONG,
            ..Profile::new().drawing(DRAW)
        }
    }

    fn declare(command: &Switch) -> Declaration {
        let effect = match command {
            Switch::On => Effect::on(DRAW),
            Switch::Off => Effect::Off,
        };
        Declaration { code: *command as u16, wcet: LONG, effect }
    }

    fn issue(&mut self, command: Switch) -> io::Result<()> {
        self.switch(matches!(command, Switch::On))
    }

    fn safe(&mut self) -> io::Result<()> {
        if self.obeys { self.switch(false) } else { Ok(()) }
    }
}
