//! What came of one run.

use faregate::tickets::clock::{Duration, Instant};
use faregate_devices_sim::{
    CameraCommand, CutoffCommand, Law, Outcome, ReceivedCommand, Spacecraft, Truth,
};

use crate::scene::Scene;
use crate::tape::{Hold, Tape};

/// What came of one run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flight {
    pub(crate) lost: Option<(Instant, Law)>,
    /// Commands of the monitor that reached the camera while it had no right to
    /// it.
    pub(crate) after_quiescence: u32,
    /// Commands refused although their ticket was valid all the while.
    pub(crate) valid_refused: u32,
    /// From the request until the cutoff command began.
    pub(crate) cutoff_after: Option<Duration>,
    /// The longest that this could take, with the rounds that it took.
    pub(crate) bound: Option<Duration>,
    /// Whether the observation was restored, where its deadline allowed.
    pub(crate) restored: Option<bool>,
    pub(crate) samples: Vec<Truth>,
    pub(crate) holds: Vec<Hold>,
}

impl Flight {
    /// What the spacecraft itself tells.
    pub(crate) fn of(scene: &Scene, craft: &Spacecraft, tape: &Tape) -> Self {
        let lost = craft.broken_law();
        let restored = restored(scene, &craft.trace()).filter(|_| lost.is_none());
        Self { lost, restored, samples: tape.samples(), ..Self::default() }
    }
}

pub(crate) fn is_shut_command(entry: &ReceivedCommand) -> bool {
    entry.command == CutoffCommand::Shut.into()
}

/// Whether an exposure began after the valve was shut. It counts if there was
/// time for it: to see the coil off, to turn the camera on, and to expose.
fn restored(scene: &Scene, trace: &[ReceivedCommand]) -> Option<bool> {
    let monitor = scene.monitor.filter(|_| !scene.driver_hangs)?;
    let parameters = &scene.parameters;
    let shut_at = trace.iter().rfind(|entry| is_shut_command(entry))?.begun;
    let seen_off = parameters.sensor_lag.saturating_add(parameters.sensor_period.saturating_mul(3));
    let exposed_by = shut_at
        .after(parameters.cutoff_pulse)
        .after(seen_off.saturating_mul(3))
        .after(monitor.period.saturating_mul(3))
        .after(monitor.window)
        .after(parameters.exposure_time)
        .after(Duration::from_millis(50));
    let began = trace.iter().any(|entry| {
        let expose = entry.command == CameraCommand::Expose.into();
        expose && entry.outcome == Outcome::Took && entry.begun > shut_at
    });
    (exposed_by <= parameters.exposure_deadline.min(scene.ends_at)).then_some(began)
}
