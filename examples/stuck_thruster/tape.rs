//! What a picture is drawn from: the truth over time, and who held what.

use std::sync::Mutex;

use faregate::tickets::clock::{Duration, Instant};
use faregate_devices_sim::Truth;

/// Samples of the truth, if anybody wants them.
pub(crate) struct Tape {
    samples: Option<Mutex<Vec<Truth>>>,
}

/// Somebody's hold on a device, from then until then.
#[derive(Clone, Debug)]
pub(crate) struct Hold {
    pub(crate) device: &'static str,
    pub(crate) by: &'static str,
    pub(crate) from: Instant,
    pub(crate) until: Instant,
}

impl Tape {
    pub(crate) fn off() -> Self {
        Self { samples: None }
    }

    pub(crate) fn on() -> Self {
        Self { samples: Some(Mutex::default()) }
    }

    pub(crate) fn period(&self) -> Duration {
        Duration::from_millis(if self.samples.is_some() { 1 } else { 5 })
    }

    pub(crate) fn sample(&self, truth: Truth) {
        if let Some(samples) = &self.samples {
            samples.lock().expect("no sampler panics").push(truth);
        }
    }

    pub(crate) fn samples(&self) -> Vec<Truth> {
        let samples = self.samples.as_ref();
        samples
            .map(|samples| samples.lock().expect("no sampler panics").clone())
            .unwrap_or_default()
    }
}
