//! Random worlds: a plan, parameters and a state that fit together, in which
//! about half of what is wanted has room.

mod activities;
mod later;

pub(crate) use later::later;

use faregate_agents::Categories;
use faregate_planner::parameters::{
    Day, Load, Phase, PreheatRow, TimelineKind, TimelineSpec, Zone,
};
use faregate_planner::plan::{Kind, Outcome};
use faregate_planner::state::{Ended, Mode, Running, Window};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
use faregate_planner::{Activity, ActivityId, Parameters, Plan, State};
use faregate_tickets::amount::{Microjoules, Milliwatts};
use fastrand::Rng;

/// Everything that a planner is asked.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub(crate) plan: Plan,
    pub(crate) parameters: Parameters,
    pub(crate) state: State,
}

/// How large a world is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// The unit of time, in milliseconds. With 1, every start can be tried.
    pub(crate) unit: i64,
    /// How long it lasts, in units.
    pub(crate) horizon: i64,
    /// At most so many activities.
    pub(crate) activities: usize,
}

/// Every millisecond can be tried.
pub(crate) const TINY: Scale = Scale { unit: 1, horizon: 150, activities: 8 };

/// Everything can be tried.
pub(crate) const MICRO: Scale = Scale { unit: 1, horizon: 45, activities: 4 };

/// A day at a six-hundredth of its length, in tenths of seconds and odd
/// milliseconds.
pub(crate) const DAY: Scale = Scale { unit: 100, horizon: 1_440, activities: 24 };

/// A day at its full length, in minutes and odd milliseconds.
pub(crate) const SOL: Scale = Scale { unit: 60_000, horizon: 1_440, activities: 24 };

impl Scale {
    /// How much of what is used up at a rate there is: rates are whole numbers
    /// for each second, and days have many.
    const fn fuel(self) -> i64 {
        if self.unit > 1_000 { self.unit / 1_000 } else { 1 }
    }
}

/// The world of a seed.
pub(crate) fn world(seed: u64, scale: Scale) -> World {
    let mut make = Make { rng: Rng::with_seed(seed), scale };
    let parameters = make.parameters();
    let mut plan = make.plan(&parameters);
    let state = make.state(&mut plan, &parameters);
    World { plan, parameters, state }
}

struct Make {
    rng: Rng,
    scale: Scale,
}

const ZONES: [&str; 2] = ["arm", "mast"];

const fn w(watts: u64) -> Milliwatts {
    Milliwatts::new(watts * 1_000)
}

impl Make {
    /// So many units of a day of 150, with odd milliseconds where there is room
    /// for them.
    fn span(&mut self, from: i64, to: i64) -> Span {
        let of = |units: i64| units * self.scale.horizon * self.scale.unit / 150;
        let exact = self.rng.i64(of(from)..=of(to));
        let whole = self.rng.bool();
        Span::new(if whole { exact / self.scale.unit * self.scale.unit } else { exact })
    }

    fn time(&mut self, from: i64, to: i64) -> Time {
        Time::ZERO.after(self.span(from, to))
    }

    fn chance(&mut self, percent: u8) -> bool {
        self.rng.u8(0..100) < percent
    }

    fn watts(&mut self, from: u64, to: u64) -> Milliwatts {
        w(self.rng.u64(from..=to))
    }

    fn load(&mut self, from: u64, to: u64) -> Load {
        let marginal = self.watts(from, to);
        Load { marginal, peak: marginal.saturating_add(self.watts(0, 30)) }
    }

    fn ppm(&mut self, from: i64, to: i64) -> Ppm {
        Ppm::new(self.rng.i64(from * 10_000..=to * 10_000))
    }

    fn parameters(&mut self) -> Parameters {
        let rtg = self.watts(80, 120);
        let base = self.watts(20, 60);
        let soft = self.ppm(15, 45);
        let wakeup = Phase { duration: self.span(1, 3), load: self.load(20, 60) };
        let shutdown = Phase { duration: self.span(1, 2), load: self.load(10, 40) };
        let zones = ZONES.iter().map(|name| self.zone(name)).collect();
        Parameters {
            mandatory_from: 9,
            soft_min_soc: soft,
            hard_min_soc: Ppm::new(soft.get() / 2),
            max_soc: if self.chance(20) { Ppm::new(1_000_000) } else { self.ppm(60, 100) },
            peak_limit: self.watts(180, 320),
            engines: self.rng.u32(1..=3),
            rtg,
            base,
            awake: self.load(30, 110),
            wakeup,
            shutdown,
            min_awake: self.span(3, 9),
            min_sleep: self.span(4, 14),
            day: Day { length: self.span(60, 150).max(Span::new(50)), midnight: self.time(0, 40) },
            zones,
            timelines: timelines(self.scale.fuel()),
            commit: self.span(1, 10),
            soft_samples: 1,
            ..Parameters::default()
        }
    }

    fn zone(&mut self, name: &str) -> Zone {
        let first = PreheatRow { from: Span::ZERO, duration: self.span(0, 8) };
        let second = PreheatRow { from: self.span(20, 50), duration: self.span(0, 8) };
        Zone { name: name.into(), load: self.load(5, 40), table: vec![first, second] }
    }

    fn plan(&mut self, parameters: &Parameters) -> Plan {
        let end = self.time(120, 150);
        let handover = Time::new(self.rng.i64(end.get() / 2..=end.get()));
        let count = self.rng.usize(2..=self.scale.activities);
        let mut activities: Vec<Activity> = Vec::new();
        for number in 1..=count {
            let activity = self.activity(number, &activities, parameters);
            activities.push(activity);
        }
        if self.chance(15) {
            activities.push(self.manual(count + 1));
        }
        Plan {
            name: "random".into(),
            handover,
            handover_min_soc: self.ppm(20, 70),
            end,
            max_delta_data: Bytes::new(self.rng.i64(20..200)),
            next_plan: None,
            activities,
        }
    }

    fn state(&mut self, plan: &mut Plan, parameters: &Parameters) -> State {
        let now = self.time(0, 25);
        let capacity = i128::from(w(100).get()) * i128::from(self.span(60, 120).get());
        let capacity = u64::try_from(capacity).unwrap();
        let share = self.rng.u64(30..=100);
        let mut state = State {
            now,
            charge: Microjoules::new(capacity / 100 * share),
            capacity: Microjoules::new(capacity),
            ..State::default()
        };
        self.mode(&mut state, parameters);
        self.past(&mut state, plan);
        let windows = self.rng.usize(0..=2);
        for number in 0..windows {
            let window = self.window(number, now);
            state.windows.push(window);
        }
        clear_of_windows(plan, &state);
        if self.chance(25) {
            let ago = self.span(110, 150);
            let gone = self.window(windows, now.before(ago));
            state.windows.insert(0, gone);
        }
        state
    }

    fn mode(&mut self, state: &mut State, parameters: &Parameters) {
        let ago = |now: Time, span: Span| now.before(span);
        (state.mode, state.mode_since) = match self.rng.u8(0..10) {
            0..4 => (Mode::Asleep, ago(state.now, self.span(0, 30))),
            4..8 => (Mode::Awake, ago(state.now, self.span(0, 20))),
            8 => {
                let passed = self.rng.i64(0..=parameters.wakeup.duration.get());
                (Mode::WakingUp, ago(state.now, Span::new(passed)))
            }
            _ => {
                let passed = self.rng.i64(0..=parameters.shutdown.duration.get());
                (Mode::ShuttingDown, ago(state.now, Span::new(passed)))
            }
        };
    }

    /// What has ended, and what runs.
    fn past(&mut self, state: &mut State, plan: &Plan) {
        let now = state.now;
        for activity in &plan.activities {
            if matches!(activity.kind, Kind::ManualShutdown { .. } | Kind::Cleanup) {
                continue;
            }
            if self.chance(12) {
                let outcomes =
                    [Outcome::Succeeded, Outcome::Failed, Outcome::Aborted, Outcome::NotStarted];
                let outcome = outcomes[self.rng.usize(0..4)];
                let ended = Time::new(now.get() - self.span(0, 10).get());
                let started = ended.before(self.span(1, 10));
                let started = (outcome != Outcome::NotStarted).then_some(started);
                let data = started.map_or(Bytes::ZERO, |_| activity.data);
                state.ended.push(Ended { id: activity.id, outcome, started, ended, data });
            } else if state.mode == Mode::Awake && state.running.is_empty() && self.chance(10) {
                let started = now.before(self.span(1, 8));
                let ends = started.after(activity.duration);
                let paused = (self.chance(20)).then_some(now);
                let cutoff = ends.after(Span::new(1_000));
                let data = Bytes::ZERO;
                let id = activity.id;
                state.running.push(Running { id, started, ends, cutoff, paused, data });
            }
        }
        if self.chance(20) {
            state.heating.insert(ZONES[0].into(), now.before(self.span(0, 8)));
        }
        if self.chance(10) {
            state.cold.push(ZONES[1].into());
        }
    }

    fn window(&mut self, number: usize, now: Time) -> Window {
        let start = now.after(self.span(15, 100));
        Window {
            name: format!("window {number}"),
            start,
            end: start.after(self.span(1, 10)),
            awake: self.rng.bool(),
            marginal: self.watts(0, 40),
            peak: self.watts(40, 60),
            data: Bytes::new(self.rng.i64(-30..10)),
            engines: 0,
            resources: Categories::from_mask(u128::from(self.rng.bool())),
        }
    }
}

/// Manual blocks keep clear of windows: a plan with both is refused.
fn clear_of_windows(plan: &mut Plan, state: &State) {
    let windows = &state.windows;
    plan.activities.retain(|activity| {
        let block = matches!(activity.kind, Kind::ManualShutdown { .. });
        let from = activity.starts[0].from;
        let margin = Span::new(activity.duration.get());
        let (from, to) = (from.before(margin), from.after(activity.duration).after(margin));
        let clear = windows.iter().all(|w| w.end <= from || to <= w.start);
        let ahead = from > state.now;
        !block || clear && ahead && to <= plan.end
    });
}

fn timelines(fuel: i64) -> Vec<TimelineSpec> {
    let line = |name: &str, kind, initial, max| {
        let name = name.to_owned();
        TimelineSpec { name, kind, initial, min: 0, max }
    };
    vec![
        line("mode", TimelineKind::State, 1, 3),
        line("bus", TimelineKind::Unit, 0, 1),
        line("seats", TimelineKind::Renewable, 0, 4),
        line("fuel", TimelineKind::Consumable, 50 * fuel, 60 * fuel),
    ]
}

/// The activity of a number.
pub(crate) fn id(number: usize) -> ActivityId {
    ActivityId::new(u32::try_from(number).unwrap()).unwrap()
}
