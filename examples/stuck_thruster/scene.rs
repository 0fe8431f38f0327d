//! What happens to the spacecraft in one run, drawn from the run's seed.

use faregate::tickets::clock::{Duration, Instant};
use faregate_devices_sim::{DeviceId, Dice, Failing, Fault, FaultScript, Parameters};

/// One run: a spacecraft, what goes wrong with it, and how its threads behave.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) seed: u64,
    pub(crate) parameters: Parameters,
    pub(crate) script: FaultScript,
    pub(crate) monitor: Option<Monitor>,
    /// The first rescuer dies with its ticket in hand: it neither runs nor
    /// unwinds.
    pub(crate) rescuer_dies: bool,
    /// The camera's driver hangs in a command of the monitor, and a second
    /// sufficient victim is there: the heaters.
    pub(crate) driver_hangs: bool,
    pub(crate) ends_at: Instant,
}

/// How the camera monitor behaves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Monitor {
    /// How often it looks.
    pub(crate) period: Duration,
    /// How long it can be kept from running between a check and the command
    /// that follows, in designs where these are apart.
    pub(crate) window: Duration,
}

/// The widths of the window, from an interrupt to a long pre-emption.
pub(crate) const WINDOWS_MS: [u64; 5] = [1, 20, 50, 100, 200];

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

impl Scene {
    /// The scene of this seed.
    pub(crate) fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed, 17);
        let sticks_at = Instant::START.after(ms(150 + dice.below(250)));
        let lag = ms(5 + dice.below(36));
        let mut parameters = Parameters {
            sensor_lag: lag,
            exposure_time: ms(100),
            exposure_deadline: Instant::START.after(ms([300, 2_400, 2_400, 2_400][dice.index(4)])),
            ..Parameters::default()
        };
        let mut script = FaultScript::new()
            .with(Fault::ThrusterSticksOpen { at: sticks_at })
            .with(Fault::CameraOffFails { from: sticks_at, attempts: [0, 0, 1, 2][dice.index(4)] });
        if dice.below(2) == 0 {
            let at = sticks_at.after(ms(dice.below(300)));
            script = script.with(Fault::CameraUpset { at });
        }
        let period = ms(10 + dice.below(30));
        let window = ms(WINDOWS_MS[dice.index(WINDOWS_MS.len())]);
        let trouble = dice.below(6);
        let driver_hangs = trouble == 0;
        if driver_hangs {
            // The camera's charge stays; the rest must do.
            parameters.battery_output_max = Parameters::default().battery_output_max;
            parameters.generation = faregate::tickets::amount::Milliwatts::from_watts(135);
            let nth = 2 + u32::try_from(dice.below(2)).unwrap_or(0);
            let how = Failing::Hangs { lasting: Duration::from_secs(60) };
            script = script.with(Fault::CommandFails { device: DeviceId::Camera, nth, how });
        }
        Self {
            seed,
            parameters,
            script,
            monitor: Some(Monitor { period, window }),
            rescuer_dies: trouble == 1,
            driver_hangs,
            ends_at: Instant::START.after(ms(2_600)),
        }
    }

    /// The scene that a person is shown: one ignored command to switch off, and
    /// nothing else beside the thruster.
    pub(crate) fn demonstration(seed: u64) -> Self {
        let sticks_at = Instant::START.after(ms(400));
        let script = FaultScript::new()
            .with(Fault::ThrusterSticksOpen { at: sticks_at })
            .with(Fault::CameraOffFails { from: sticks_at, attempts: 1 });
        let parameters = Parameters {
            exposure_time: ms(250),
            exposure_deadline: Instant::START.after(ms(2_400)),
            sensor_unknown_permille: 0,
            overrun_factor: 100,
            ..Parameters::default()
        };
        Self {
            seed,
            parameters,
            script,
            monitor: Some(Monitor { period: ms(20), window: ms(1) }),
            rescuer_dies: false,
            driver_hangs: false,
            ends_at: Instant::START.after(ms(2_600)),
        }
    }

    /// The same scene, with nobody who keeps the camera on.
    pub(crate) fn without_monitor(mut self) -> Self {
        self.monitor = None;
        self
    }

    /// The same scene, in which the first rescuer lives: for designs that have
    /// nothing against its death, and are not to lose by it.
    pub(crate) fn without_deaths(mut self) -> Self {
        self.rescuer_dies = false;
        self
    }

    /// The same scene, in which the camera's driver does not hang. The
    /// exclusive policy's rescuer commands the camera itself: nobody can be
    /// rescued through a driver of its own that hangs.
    pub(crate) fn without_hangs(mut self) -> Self {
        if self.driver_hangs {
            self.driver_hangs = false;
            self.parameters.generation = Parameters::default().generation;
            let others =
                self.script.iter().filter(|fault| !matches!(fault, Fault::CommandFails { .. }));
            self.script = others.fold(FaultScript::new(), FaultScript::with);
        }
        self
    }
}
