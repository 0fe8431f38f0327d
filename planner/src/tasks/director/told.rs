//! What the host knows and the manager does not.

use faregate_tickets::amount::Microjoules;

use super::Director;
use crate::plan::ActivityId;
use crate::state::Window;
use crate::trace::Why;
use crate::units::Bytes;

impl Director {
    /// What the sensors say of the battery. Each time is a sample.
    pub fn charge(&mut self, charge: Microjoules) {
        self.state.charge = charge.min(self.state.capacity);
        self.judge_charge();
    }

    /// What an activity has really added to the data on board by now.
    pub fn data(&mut self, id: ActivityId, data: Bytes) {
        if let Some(running) = self.state.running.iter_mut().find(|one| one.id == id) {
            running.data = data;
        } else if let Some(ended) = self.state.ended.iter_mut().find(|one| one.id == id) {
            ended.data = data;
        }
    }

    /// The communication windows are these. Those that are over stay known,
    /// listed or not: what was sent in them is on board no more.
    pub fn windows(&mut self, windows: Vec<Window>) {
        let known = self.state.windows.clone();
        self.state.queried(windows);
        if self.state.windows != known {
            self.wish(Why::Windows);
        }
    }

    /// A variable's value; none: nobody knows it any more.
    pub fn variable(&mut self, name: &str, value: Option<i64>) {
        match value {
            Some(value) => self.state.variables.insert(name.to_owned(), value),
            None => self.state.variables.remove(name),
        };
    }

    /// A zone is not warm, though it should be: it is heated anew.
    pub fn zone_is_cold(&mut self, zone: &str) {
        self.state.heating.remove(zone);
        if !self.state.cold.iter().any(|one| one == zone) {
            self.state.cold.push(zone.to_owned());
        }
        self.wish(Why::ZoneCold);
    }

    /// A zone that was found cold is warm, by its estimate.
    pub fn zone_is_warm(&mut self, zone: &str) {
        self.state.cold.retain(|one| one != zone);
    }
}
