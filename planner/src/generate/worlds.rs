//! Parameters and states: what activities are drawn into.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::draws::Draws;
use crate::parameters::{
    Day, Load, Parameters, Phase, PreheatRow, TimelineKind, TimelineSpec, Zone,
};
use crate::plan::Plan;
use crate::state::{State, Window};
use crate::units::{Bytes, Ppm, Span, Time};

use super::activities::{Crowd, crowd};
use super::{Shape, World};

const MB: i64 = 1_000_000;
const HOUR: i64 = 3_600_000;
const MINUTE: i64 = 60_000;

/// So many watt-hours.
pub(super) const fn watt_hours(number: u64) -> Microjoules {
    Microjoules::new(number * 3_600_000_000)
}

pub(super) const fn watts(number: u64) -> Milliwatts {
    Milliwatts::new(number * 1_000)
}

pub(super) const fn load(marginal: u64, peak: u64) -> Load {
    Load { marginal: watts(marginal), peak: watts(peak) }
}

/// As many sols as it takes, each as crowded as the others.
pub(super) fn sols(shape: Shape, per_sol: usize) -> World {
    let mut draws = Draws::new(shape.seed);
    let sols = i64::try_from(shape.activities.div_ceil(per_sol)).unwrap_or(i64::MAX).max(1);
    let end = Time::new(sols * Day::SOL.length.get());
    let now = Time::new(6 * HOUR);
    let windows = (0..sols).flat_map(|sol| passes(sol, &mut draws)).collect();
    let crowd_of = Crowd { sols, day: Day::SOL.length.get(), draw: shape.draw };
    let plan = Plan {
        name: format!("{} activities, seed {}", shape.activities, shape.seed),
        handover: end.before(Span::new(2 * HOUR)),
        handover_min_soc: Ppm::new(500_000),
        end,
        max_delta_data: Bytes::new(sols * 300 * MB),
        next_plan: None,
        activities: crowd(shape.activities, crowd_of, &mut draws),
    };
    let state = State {
        now,
        mode_since: now.before(Span::new(HOUR)),
        charge: watt_hours(1_500),
        capacity: watt_hours(2_400),
        windows,
        ..State::default()
    };
    World { plan, parameters: rover(), state }
}

/// The orbiters' passes of a sol.
fn passes(sol: i64, draws: &mut Draws) -> Vec<Window> {
    let pass = |hour: i64| {
        let start = sol * Day::SOL.length.get() + hour * HOUR + draws.between(0, 40) * MINUTE;
        Window {
            name: format!("pass {} of sol {}", hour, sol + 1),
            start: Time::new(start),
            end: Time::new(start + draws.between(8, 14) * MINUTE),
            awake: true,
            marginal: watts(30),
            peak: watts(60),
            data: Bytes::new(-draws.between(40, 80) * MB),
            engines: 1,
            resources: Categories::from_mask(1 << 12),
        }
    };
    [7, 11, 16, 21].map(pass).into()
}

fn rover() -> Parameters {
    let row = |hour: i64, min: i64| PreheatRow {
        from: Span::new(hour * HOUR),
        duration: Span::from_mins(min),
    };
    let zone = |name: &str, load, rows: [(i64, i64); 4]| Zone {
        name: name.into(),
        load,
        table: rows.map(|(hour, min)| row(hour, min)).into(),
    };
    let line =
        |name: &str, kind, max| TimelineSpec { name: name.into(), kind, initial: 0, min: 0, max };
    Parameters {
        max_soc: Ppm::new(950_000),
        zones: vec![
            zone("mast", load(20, 25), [(0, 60), (9, 30), (13, 10), (18, 45)]),
            zone("wheels", load(45, 50), [(0, 120), (10, 55), (13, 20), (18, 90)]),
        ],
        timelines: vec![
            line("arm", TimelineKind::State, 3),
            line("memory", TimelineKind::Renewable, 3),
            line("sieve", TimelineKind::Unit, 1),
            line("tubes", TimelineKind::Consumable, 40),
        ],
        resources: (0..13).map(|bit| (format!("bit {bit}"), bit)).collect::<BTreeMap<_, _>>(),
        commit: Span::from_secs(60),
        expansion_grace: Span::from_secs(30),
        handover_tolerance: Span::from_secs(5),
        ..computer()
    }
}

pub(super) fn computer() -> Parameters {
    Parameters {
        mandatory_from: 128,
        soft_min_soc: Ppm::new(400_000),
        hard_min_soc: Ppm::new(300_000),
        peak_limit: watts(400),
        engines: 4,
        rtg: watts(110),
        base: watts(45),
        awake: load(75, 90),
        wakeup: Phase { duration: Span::from_mins(5), load: load(60, 90) },
        shutdown: Phase { duration: Span::from_mins(5), load: load(60, 90) },
        min_awake: Span::from_mins(10),
        min_sleep: Span::from_mins(30),
        soft_samples: 3,
        ..Parameters::default()
    }
}
