//! A set of placed activities, and everything that is derived from it.

use faregate_planner::parameters::Load;
use faregate_planner::state::Mode;
use faregate_tickets::amount::Milliwatts;

use crate::computer::{self, Begin, Phase, Rules};
use crate::flow::{Curve, Flow};
use crate::heating::{Heating, heatings};
use crate::scene::{How, Placed, Scene};
use crate::steps::{Changes, Steps};

/// What follows from who is placed where.
#[derive(Clone, Debug)]
pub(crate) struct World<'a> {
    pub(crate) placed: Vec<Placed>,
    pub(crate) heatings: Vec<Heating<'a>>,
    pub(crate) phases: Vec<Phase>,
    pub(crate) charge: Curve,
    pub(crate) peak: Steps,
    /// What would have had to begin before now.
    pub(crate) flaws: Vec<Flaw>,
}

/// There is no time left before something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Flaw {
    /// What it is for: the heating of whom; none: a wakeup.
    pub(crate) index: Option<usize>,
    pub(crate) at: i64,
    pub(crate) by: i64,
}

/// The windows of a state that are not over, and the manual blocks' loads, are
/// in every world; so is the shutdown in progress.
impl<'a> World<'a> {
    /// Derives everything anew.
    pub(crate) fn new(scene: &Scene<'a>, placed: Vec<Placed>) -> Self {
        let (heatings, late) = heatings(scene, &placed);
        let net = net(scene, &placed, &heatings, &[]);
        let flow = Flow::new(net, scene.capacity());
        let needs = needs(scene, &placed, &heatings, true);
        let charge = i128::from(scene.state.charge.get()).min(scene.capacity());
        let (phases, short) = computer::phases(&rules(scene), &flow, begin(scene), needs, charge);
        let heating =
            late.iter().map(|late| Flaw { index: Some(late.index), at: late.at, by: late.by });
        let waking = short.iter().map(|short| Flaw { index: None, at: short.at, by: short.by });
        let asleep = not_up(scene, &placed, &heatings, &phases);
        let flaws = heating.chain(waking).chain(asleep).collect();
        Self::generated(scene, placed, heatings, phases, flaws)
    }

    /// The world in which just this is generated.
    pub(crate) fn generated(
        scene: &Scene<'a>,
        placed: Vec<Placed>,
        heatings: Vec<Heating<'a>>,
        phases: Vec<Phase>,
        flaws: Vec<Flaw>,
    ) -> Self {
        let net = net(scene, &placed, &heatings, &phases);
        let charge = i128::from(scene.state.charge.get());
        let charge = Curve::new(&net, charge, scene.capacity(), (scene.now, scene.end));
        let peak = peak(scene, &placed, &heatings, &phases);
        Self { placed, heatings, phases, charge, peak, flaws }
    }

    /// What nobody decides.
    pub(crate) fn base(scene: &Scene<'a>) -> Self {
        Self::new(scene, scene.fixed.clone())
    }

    /// This world and one more.
    pub(crate) fn with(&self, scene: &Scene<'a>, one: Placed) -> Self {
        Self::new(scene, self.placed.iter().copied().chain([one]).collect())
    }

    pub(crate) fn find(&self, index: usize) -> Option<&Placed> {
        self.placed.iter().find(|placed| placed.index == index)
    }
}

/// Who needs the computer before it is up: a candidate that begins with what
/// comes too late by itself comes too late, too.
fn not_up(
    scene: &Scene<'_>,
    placed: &[Placed],
    heatings: &[Heating<'_>],
    phases: &[Phase],
) -> Vec<Flaw> {
    let runs = placed.iter().filter(|one| !matches!(one.how, How::Block { .. }));
    let runs = runs.map(|one| (one.index, one.start, one.end));
    let heated = heatings.iter().filter_map(|heating| {
        let uses = |one: &&Placed| {
            let activity = scene.activity(one.index);
            one.start == heating.end && crate::scene::zones(activity).any(|z| z == heating.zone)
        };
        let whose = placed.iter().filter(uses).map(|one| one.index).min()?;
        Some((whose, heating.start, heating.end))
    });
    let needs = runs.chain(heated).filter_map(|(index, start, end)| {
        let (at, end) = (start.max(scene.now), end.min(scene.end));
        let phase = phases.iter().find(|phase| phase.down > at && at < end)?;
        let by = phase.up - at;
        (by > 0).then_some(Flaw { index: Some(index), at, by })
    });
    needs.collect()
}

/// What is drawn over [start, end).
pub(crate) struct Draw {
    pub(crate) start: i64,
    pub(crate) end: i64,
    pub(crate) marginal: i128,
    pub(crate) peak: i128,
}

fn draw((start, end): (i64, i64), load: Load) -> Draw {
    Draw { start, end, marginal: milliwatts(load.marginal), peak: milliwatts(load.peak) }
}

pub(crate) fn milliwatts(amount: Milliwatts) -> i128 {
    i128::from(amount.get())
}

/// Everything that draws power beside the base load.
fn draws(
    scene: &Scene<'_>,
    placed: &[Placed],
    heatings: &[Heating<'_>],
    phases: &[Phase],
) -> Vec<Draw> {
    let parameters = scene.parameters;
    let mut all = Vec::new();
    for placed in placed {
        let activity = scene.activity(placed.index);
        let paused = placed.how == How::Runs { paused: true };
        let marginal = if paused { Milliwatts::ZERO } else { activity.marginal };
        let load = Load { marginal, peak: activity.peak };
        all.push(draw((placed.start, placed.end), load));
        if let How::Block { shutdown, wakeup } = placed.how {
            let (start, end) = (placed.start, placed.end);
            all.push(draw((start, start + shutdown), parameters.shutdown.load));
            all.push(draw((end - wakeup, end), parameters.wakeup.load));
        }
    }
    for window in &scene.state.windows {
        let load = Load { marginal: window.marginal, peak: window.peak };
        all.push(draw((window.start.get(), window.end.get()), load));
    }
    for heating in heatings {
        let zone = parameters.zones.iter().find(|zone| zone.name == heating.zone);
        all.push(draw((heating.start, heating.end), zone.map(|z| z.load).unwrap_or_default()));
    }
    for phase in phases {
        all.push(draw((phase.wakeup, phase.up), parameters.wakeup.load));
        all.push(draw((phase.up, phase.down), parameters.awake));
        all.push(draw((phase.down, phase.asleep), parameters.shutdown.load));
    }
    if let Begin::Asleep { since } = begin(scene) {
        all.push(draw((scene.now, since), parameters.shutdown.load));
    }
    all
}

fn net(scene: &Scene<'_>, placed: &[Placed], heatings: &[Heating<'_>], phases: &[Phase]) -> Steps {
    let mut changes = Changes::default();
    let parameters = scene.parameters;
    changes.add(scene.now, milliwatts(parameters.rtg) - milliwatts(parameters.base));
    for draw in draws(scene, placed, heatings, phases) {
        changes.add_over(draw.start, draw.end, -draw.marginal);
    }
    changes.from(scene.now)
}

fn peak(scene: &Scene<'_>, placed: &[Placed], heatings: &[Heating<'_>], phases: &[Phase]) -> Steps {
    let mut changes = Changes::default();
    for draw in draws(scene, placed, heatings, phases) {
        changes.add_over(draw.start, draw.end, draw.peak);
    }
    changes.from(scene.now)
}

/// What the computer must be up for: communication windows, too, if they are
/// asked for.
pub(crate) fn needs(
    scene: &Scene<'_>,
    placed: &[Placed],
    heatings: &[Heating<'_>],
    windows: bool,
) -> Vec<(i64, i64)> {
    let runs = placed.iter().filter(|placed| !matches!(placed.how, How::Block { .. }));
    let queried = scene.state.windows.iter().filter(|window| windows && window.awake);
    runs.map(|placed| (placed.start, placed.end))
        .chain(heatings.iter().map(|heating| (heating.start, heating.end)))
        .chain(queried.map(|window| (window.start.get(), window.end.get())))
        .collect()
}

/// What the computer does at the begin.
pub(crate) fn begin(scene: &Scene<'_>) -> Begin {
    let (parameters, state) = (scene.parameters, scene.state);
    let since = state.mode_since;
    if scene.manual().iter().any(|block| block.start <= scene.now) {
        return Begin::Block;
    }
    match state.mode {
        Mode::Asleep => Begin::Asleep { since: since.get() },
        Mode::ShuttingDown => {
            Begin::Asleep { since: since.after(parameters.shutdown.duration).get() }
        }
        Mode::WakingUp => {
            Begin::Waking { up: since.after(parameters.wakeup.duration).get().max(scene.now) }
        }
        Mode::Awake => Begin::Up { floor: since.after(parameters.min_awake).get().max(scene.now) },
    }
}

pub(crate) fn rules(scene: &Scene<'_>) -> Rules {
    let parameters = scene.parameters;
    let loads = [parameters.wakeup.load, parameters.awake, parameters.shutdown.load];
    let surplus = milliwatts(parameters.rtg) - milliwatts(parameters.base);
    Rules {
        now: scene.now,
        end: scene.end,
        wakeup: parameters.wakeup.duration.get(),
        shutdown: parameters.shutdown.duration.get(),
        min_awake: parameters.min_awake.get(),
        min_sleep: parameters.min_sleep.get(),
        loads: loads.map(|load| milliwatts(load.marginal)),
        most: scene.at_most(parameters.max_soc),
        surplus: surplus.max(0),
        blocks: scene.manual().iter().map(|block| (block.start, block.end)).collect(),
    }
}
