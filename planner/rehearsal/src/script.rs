//! What goes wrong in an execution, as values.

use faregate_agents::Categories;
use faregate_devices_sim::Dice;
use faregate_planner::state::Window;
use faregate_planner::units::{Span, Time};
use faregate_planner::{ActivityId, Parameters, Plan, State};
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
    /// What may go wrong on a bad day, drawn from a seed: charge is lost,
    /// something draws, a heater or the sensors fail, somebody takes tickets, a
    /// window is cancelled.
    #[must_use]
    pub fn drawn(plan: &Plan, parameters: &Parameters, state: &State, seed: u64) -> Self {
        let mut dice = Dice::new(seed, 1 << 41);
        let mut mishaps = Vec::new();
        let length = u64::try_from(plan.end.since(state.now).get()).unwrap_or(0);
        for kind in 0..6 {
            let (thrown, at, long) =
                (dice.below(100), dice.below(length), dice.below(length / 10 + 1));
            let at = later(state.now, at);
            let (from, until) = (at, later(at, long));
            let part = Microjoules::new(state.capacity.get() / 100 * (10 + dice.below(60)));
            let index = dice.index(state.windows.len());
            let zone = parameters.zones.get(dice.index(parameters.zones.len()));
            mishaps.extend(match kind {
                0 if thrown < 50 => Some(Mishap::Discharge { at, energy: part }),
                1 if thrown < 30 => {
                    Some(Mishap::Drain { from, until, load: Milliwatts::from_watts(200) })
                }
                2 if thrown < 20 => Some(Mishap::SensorsSilent { from, until }),
                3 if thrown < 30 => zone.map(|zone| {
                    let zone = zone.name.clone();
                    Mishap::HeaterDead { zone, from, until }
                }),
                4 if thrown < 60 => Some(Mishap::Commandeered {
                    from,
                    until,
                    draw: Milliwatts::new(parameters.peak_limit.get() / 2),
                    resources: Categories::NONE,
                }),
                5 if thrown < 20 && !state.windows.is_empty() => {
                    Some(Mishap::Window { at, index, becomes: None })
                }
                _ => None,
            });
        }
        Self(mishaps)
    }
}

impl Script {
    /// How long the sensors say nothing new, in sum.
    pub(crate) fn silence(&self) -> Span {
        let silent = self.0.iter().filter_map(|mishap| match mishap {
            Mishap::SensorsSilent { from, until } => Some(until.since(*from).get()),
            _ => None,
        });
        Span::new(silent.sum())
    }
}

fn later(at: Time, ms: u64) -> Time {
    at.after(Span::new(i64::try_from(ms).unwrap_or(0)))
}
