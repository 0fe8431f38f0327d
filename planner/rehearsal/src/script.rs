//! What goes wrong in an execution, as values.

mod drawn;

use faregate_agents::Categories;
use faregate_planner::ActivityId;
use faregate_planner::state::Window;
use faregate_planner::units::Time;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use serde::{Deserialize, Serialize};

/// Something goes wrong, or is otherwise than planned. Instants are the plan's.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mishap {
    /// A zone's heater draws and heats nothing.
    HeaterDead {
        /// The zone.
        zone: String,
        /// From then.
        from: Time,
        /// Until then.
        until: Time,
    },
    /// The sensors say nothing new.
    SensorsSilent {
        /// From then.
        from: Time,
        /// Until then.
        until: Time,
    },
    /// Something draws that nobody planned.
    Drain {
        /// From then.
        from: Time,
        /// Until then.
        until: Time,
        /// So much.
        load: Milliwatts,
    },
    /// The battery has lost so much at once.
    Discharge {
        /// When.
        at: Time,
        /// How much.
        energy: Microjoules,
    },
    /// An onboard variable changes.
    Variable {
        /// When.
        at: Time,
        /// Its name.
        name: String,
        /// Its value; none: nobody knows it any more.
        value: Option<i64>,
    },
    /// A communication window is replaced before it opens; none: it is
    /// cancelled.
    Window {
        /// When that becomes known.
        at: Time,
        /// Which window, by its place in the state.
        index: usize,
        /// What it is from then on.
        becomes: Option<Window>,
    },
    /// Somebody more important takes tickets, and gives them back.
    Commandeered {
        /// From then.
        from: Time,
        /// Until then.
        until: Time,
        /// So much power.
        draw: Milliwatts,
        /// These conflict categories.
        resources: Categories,
    },
    /// An activity is vetoed.
    Veto {
        /// When.
        at: Time,
        /// Which one.
        id: ActivityId,
    },
    /// An activity that runs is ordered to stop.
    Stop {
        /// When.
        at: Time,
        /// Which one.
        id: ActivityId,
    },
}

/// All that goes wrong in one execution.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Script(pub Vec<Mishap>);

impl Script {
    /// Whether the sensors ever say nothing new.
    pub(crate) fn is_ever_silent(&self) -> bool {
        self.0.iter().any(|mishap| matches!(mishap, Mishap::SensorsSilent { .. }))
    }

    /// What something draws then that nobody planned.
    pub(crate) fn leak(&self, at: Time) -> Milliwatts {
        let loads = self.0.iter().filter_map(|mishap| match mishap {
            Mishap::Drain { from, until, load } if *from <= at && at < *until => Some(*load),
            _ => None,
        });
        loads.fold(Milliwatts::ZERO, Milliwatts::saturating_add)
    }
}
