//! How much of the time categories are in use, and how much is drawn.

use std::collections::BTreeMap;

use faregate_tickets::amount::Milliwatts;

use crate::analyze::track::Track;
use crate::mission::Mission;
use crate::task::Task;
use crate::time::Duration;

/// What is used of what, until the horizon.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Utilisation {
    /// Over how long.
    pub over: Duration,
    /// Categories that any task has, by number.
    pub categories: Vec<CategoryUse>,
    /// Agents that any task draws from, in the mission's order.
    pub agents: Vec<AgentUse>,
}

/// How much of the time a category is in use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CategoryUse {
    /// Its number, 0 to 127.
    pub category: u8,
    /// Its name, where the mission gives it one.
    pub name: Option<String>,
    /// For how long some task ran that has it.
    pub busy: Duration,
}

/// What is drawn from an agent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AgentUse {
    /// Its name.
    pub name: String,
    /// What it can supply; none: no margin is kept.
    pub supply: Option<Milliwatts>,
    /// The most that was drawn at a time.
    pub peak: Milliwatts,
    /// What was drawn on average, at the largest draw of whatever ran.
    pub average: Milliwatts,
    /// The most that was wished for at a time, and since when.
    pub wished: (Milliwatts, Duration),
    /// When wishes exceeded the supply first.
    pub exceeded: Option<Duration>,
}

pub(super) fn utilisation(tracks: &[Track], mission: &Mission, over: Duration) -> Utilisation {
    Utilisation {
        over,
        categories: categories(tracks, mission),
        agents: agents(tracks, mission, over),
    }
}

fn categories(tracks: &[Track], mission: &Mission) -> Vec<CategoryUse> {
    let mut busy: BTreeMap<u8, Duration> = BTreeMap::new();
    for track in tracks {
        let ran = ran(track);
        for category in bits(track.task.categories.mask()) {
            let sum = busy.entry(category).or_default();
            *sum = sum.saturating_add(ran);
        }
    }
    let name = |category| {
        mission.categories.iter().find(|(_, bit)| **bit == category).map(|(name, _)| name.clone())
    };
    let uses = busy.into_iter();
    uses.map(|(category, busy)| CategoryUse { category, name: name(category), busy }).collect()
}

/// The numbers of the bits that are set.
pub(super) fn bits(mask: u128) -> impl Iterator<Item = u8> {
    (0..128_u8).filter(move |bit| mask >> bit & 1 == 1)
}

fn ran(track: &Track) -> Duration {
    let segments = track.runs.iter().flat_map(|run| &run.segments);
    let lengths = segments.map(|(from, until)| until.saturating_sub(*from));
    lengths.fold(Duration::ZERO, Duration::saturating_add)
}

/// What the task draws from the agent: its own draw, at the first one, and that
/// of its devices.
fn draw_from(task: &Task, agent: usize, mission: &Mission) -> u64 {
    let own = if agent == 0 { task.peak_draw.get() } else { 0 };
    let Some(agent) = mission.agents.get(agent) else { return own };
    let devices = mission.devices.iter().filter(|device| device.agent == agent.name);
    let mine = devices.filter(|device| task.gates.contains(&device.name));
    mine.filter_map(|device| device.draw).fold(own, |sum, draw| sum.saturating_add(draw.get()))
}

fn agents(tracks: &[Track], mission: &Mission, over: Duration) -> Vec<AgentUse> {
    let uses = mission.agents.iter().enumerate().map(|(index, agent)| {
        let drawing = tracks.iter().map(|track| (track, draw_from(&track.task, index, mission)));
        let drawing: Vec<_> = drawing.filter(|(_, draw)| *draw > 0).collect();
        let drawn = Curve::of(drawing.iter().flat_map(|(track, draw)| segments(track, *draw)));
        let wished = Curve::of(drawing.iter().flat_map(|(track, draw)| wishes(track, *draw)));
        AgentUse {
            name: agent.name.clone(),
            supply: agent.supply,
            peak: Milliwatts::new(drawn.peak().0),
            average: Milliwatts::new(drawn.average(over)),
            wished: (Milliwatts::new(wished.peak().0), wished.peak().1),
            exceeded: agent.supply.and_then(|supply| wished.first_above(supply.get())),
        }
    });
    uses.filter(|agent| !agent.wished.0.is_zero()).collect()
}

/// A draw from an instant to another one.
type Piece = (Duration, Duration, u64);

fn segments(track: &Track, draw: u64) -> impl Iterator<Item = Piece> + '_ {
    let segments = track.runs.iter().flat_map(|run| &run.segments);
    segments.map(move |(from, until)| (*from, *until, draw))
}

/// While it is due or runs, a task wishes for its draw.
fn wishes(track: &Track, draw: u64) -> impl Iterator<Item = Piece> + '_ {
    let runs = track.runs.iter().map(|run| {
        let last = run.segments.last().map_or(run.start, |(_, until)| *until);
        (run.start, run.end.unwrap_or(last))
    });
    let all = runs.chain(track.waits.iter().copied());
    all.map(move |(from, until)| (from, until, draw))
}

/// The sum of pieces over time, as steps: from when on it is how much.
#[derive(Debug)]
struct Curve(Vec<(Duration, u64)>);

impl Curve {
    fn of(pieces: impl Iterator<Item = Piece>) -> Self {
        let mut changes: BTreeMap<Duration, i128> = BTreeMap::new();
        for (from, until, draw) in pieces.filter(|(from, until, _)| from < until) {
            *changes.entry(from).or_default() += i128::from(draw);
            *changes.entry(until).or_default() -= i128::from(draw);
        }
        let mut sum = 0_i128;
        let steps = changes.into_iter().map(|(at, change)| {
            sum += change;
            (at, u64::try_from(sum).unwrap_or(u64::MAX))
        });
        Self(steps.collect())
    }

    /// The largest value, and when it is first there.
    fn peak(&self) -> (u64, Duration) {
        let first = |best: (u64, Duration), &(at, sum): &(Duration, u64)| {
            if sum > best.0 { (sum, at) } else { best }
        };
        self.0.iter().fold((0, Duration::ZERO), first)
    }

    fn first_above(&self, limit: u64) -> Option<Duration> {
        self.0.iter().find(|(_, sum)| *sum > limit).map(|(at, _)| *at)
    }

    fn average(&self, over: Duration) -> u64 {
        let pieces = self.0.iter().zip(self.0.iter().skip(1));
        let area = pieces.map(|((from, sum), (until, _))| {
            u128::from(*sum) * u128::from(until.saturating_sub(*from).as_micros())
        });
        let area: u128 = area.fold(0, u128::saturating_add);
        u64::try_from(area / u128::from(over.as_micros().max(1))).unwrap_or(u64::MAX)
    }
}
