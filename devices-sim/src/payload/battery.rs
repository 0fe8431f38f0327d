//! The payload's battery, as its settings say it.

use std::collections::BTreeMap;

use faregate_tickets::amount::{Microjoules, Milliwatts};

use super::settings::Settings;

/// Twenty watt hours: a small spacecraft's.
const CAPACITY_WH: u64 = 20;
/// A milliwatt hour, in millijoules.
const MILLIJOULES_IN_MWH: u64 = 3_600;

/// A battery, and what charges it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatteryModel {
    /// What it holds when it is full.
    pub capacity: Microjoules,
    /// What it holds at the start.
    pub stored: Microjoules,
    /// What charges it all the time.
    pub generation: Milliwatts,
}

impl BatteryModel {
    /// The battery of these settings: `capacity_wh`, `charge_percent`,
    /// `generation_w`.
    ///
    /// # Errors
    /// Everything that is wrong with them.
    pub fn new(given: &BTreeMap<String, String>) -> Result<Self, Vec<String>> {
        let mut settings = Settings::new(given);
        let capacity_mwh = settings.thousandths("capacity_wh").unwrap_or(CAPACITY_WH * 1_000);
        let percent = settings.number("charge_percent", 100).min(100);
        let generation = settings.watts("generation_w", Milliwatts::ZERO);
        let capacity = capacity_mwh.saturating_mul(MILLIJOULES_IN_MWH).saturating_mul(1_000);
        let stored = capacity / 100 * percent;
        let model = Self {
            capacity: Microjoules::new(capacity),
            stored: Microjoules::new(stored),
            generation,
        };
        settings.finish("battery", model)
    }
}
