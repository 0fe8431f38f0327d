//! Bad days, drawn from a seed.

use faregate_agents::Categories;
use faregate_planner::plan::{Kind, StartRange};
use faregate_planner::state::Window;
use faregate_planner::units::{Span, Time};
use faregate_planner::{ActivityId, Parameters, Plan, State};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use super::{Mishap, Script};
use crate::throws::Throws;

/// What is hit, and the dice.
struct Day<'a> {
    plan: &'a Plan,
    parameters: &'a Parameters,
    state: &'a State,
    throws: Throws,
}

impl Script {
    /// What may go wrong on a bad day, drawn from a seed: charge is lost,
    /// something draws, a heater or the sensors fail, somebody takes tickets, a
    /// window is cancelled or moved, variables change, activities are vetoed or
    /// stopped. Most of it while something may run: at other times it would not
    /// be felt.
    #[must_use]
    pub fn drawn(plan: &Plan, parameters: &Parameters, state: &State, seed: u64) -> Self {
        let mut day = Day { plan, parameters, state, throws: Throws::new(seed, 1 << 41) };
        let mishaps = kinds().into_iter().filter_map(|(often, kind)| {
            let mishap = kind(&mut day);
            mishap.filter(|_| day.throws.chance(often))
        });
        Self(mishaps.collect())
    }
}

type Drawing<'a> = fn(&mut Day<'a>) -> Option<Mishap>;

/// How often in a hundred days each kind comes.
fn kinds<'a>() -> [(u64, Drawing<'a>); 13] {
    [
        (45, Day::discharge),
        (25, Day::discharge),
        (40, Day::drain),
        (35, Day::silence),
        (30, Day::dead_heater),
        (60, Day::commandeered),
        (40, Day::commandeered),
        (25, Day::window),
        (50, Day::variable),
        (30, Day::variable),
        (25, Day::veto),
        (25, Day::veto),
        (25, Day::stop),
    ]
}

impl Day<'_> {
    /// While something may run, three times out of four.
    fn moment(&mut self) -> Time {
        let (now, end) = (self.state.now, self.plan.end);
        let ranges: Vec<_> = self.plan.activities.iter().map(|one| (&one.starts, one)).collect();
        let range = ranges.get(self.throws.index(0, ranges.len().saturating_sub(1)));
        let range = range.and_then(|(starts, one)| Some((*starts.first()?, one.duration)));
        let by_chance = self.throws.within(now, end);
        let Some((StartRange { from, .. }, duration)) = range else { return by_chance };
        let meant = self.throws.within(from, from.after(duration).after(duration));
        let is_meant = self.throws.chance(75) && now < meant && meant < end;
        if is_meant { meant } else { by_chance }
    }

    fn stretch(&mut self, low: u64, high: u64) -> (Time, Time) {
        let from = self.moment();
        (from, from.after(self.throws.minutes(low, high)))
    }

    #[expect(clippy::unnecessary_wraps, reason = "some others do not always apply")]
    fn discharge(&mut self) -> Option<Mishap> {
        let part = self.state.capacity.get() / 100 * self.throws.number(5, 50);
        Some(Mishap::Discharge { at: self.moment(), energy: Microjoules::new(part) })
    }

    #[expect(clippy::unnecessary_wraps, reason = "some others do not always apply")]
    fn drain(&mut self) -> Option<Mishap> {
        let (from, until) = self.stretch(10, 180);
        let load = Milliwatts::new(self.throws.number(10, 150) * 1_000);
        Some(Mishap::Drain { from, until, load })
    }

    #[expect(clippy::unnecessary_wraps, reason = "some others do not always apply")]
    fn silence(&mut self) -> Option<Mishap> {
        let (from, until) = self.stretch(1, 90);
        Some(Mishap::SensorsSilent { from, until })
    }

    fn dead_heater(&mut self) -> Option<Mishap> {
        let zones = &self.parameters.zones;
        let zone = zones.get(self.throws.index(0, zones.len().saturating_sub(1)))?.name.clone();
        let (from, until) = self.stretch(10, 180);
        Some(Mishap::HeaterDead { zone, from, until })
    }

    #[expect(clippy::unnecessary_wraps, reason = "some others do not always apply")]
    fn commandeered(&mut self) -> Option<Mishap> {
        let (from, until) = self.stretch(1, 60);
        let draw = self.parameters.peak_limit.get() / 100 * self.throws.number(0, 95);
        let bits = if self.throws.chance(50) { 1 << self.throws.index(0, 12) } else { 0 };
        let resources = Categories::from_mask(bits);
        Some(Mishap::Commandeered { from, until, draw: Milliwatts::new(draw), resources })
    }

    /// Cancelled, or moved by up to an hour; not where the ground has the computer
    /// off at some time: nobody would move it there.
    fn window(&mut self) -> Option<Mishap> {
        let windows = &self.state.windows;
        let index = self.throws.index(0, windows.len().saturating_sub(1));
        let window = windows.get(index)?.clone();
        let (low, high) = (window.start.before(Span::from_mins(300)), window.start);
        let at = self.throws.within(low.max(self.state.now), high);
        let later = self.throws.minutes(0, 60);
        let moved =
            Window { start: window.start.after(later), end: window.end.after(later), ..window };
        let blocks = self.plan.activities.iter();
        let mut blocks = blocks.filter(|one| matches!(one.kind, Kind::ManualShutdown { .. }));
        let moves = self.throws.chance(50) && blocks.next().is_none();
        let becomes = moves.then_some(moved);
        Some(Mishap::Window { at, index, becomes })
    }

    /// One that somebody asks for: set right, set wrong, or forgotten.
    fn variable(&mut self) -> Option<Mishap> {
        let activities = self.plan.activities.iter();
        let asked: Vec<_> = activities.flat_map(|one| &one.conditions).collect();
        let condition = asked.get(self.throws.index(0, asked.len().saturating_sub(1)))?;
        let value = match self.throws.index(0, 3) {
            0 => None,
            1 => Some(condition.max.saturating_add(1)),
            _ => Some(condition.min),
        };
        Some(Mishap::Variable { at: self.moment(), name: condition.name.clone(), value })
    }

    fn someone(&mut self) -> Option<ActivityId> {
        let all = &self.plan.activities;
        all.get(self.throws.index(0, all.len().saturating_sub(1))).map(|one| one.id)
    }

    fn veto(&mut self) -> Option<Mishap> {
        let id = self.someone()?;
        let at = self.throws.within(self.state.now, self.plan.end);
        Some(Mishap::Veto { at, id })
    }

    /// In the middle of its first range: those that do not run are not bothered.
    fn stop(&mut self) -> Option<Mishap> {
        let id = self.someone()?;
        let activity = self.plan.activities.iter().find(|one| one.id == id)?;
        let from = activity.starts.first()?.from.max(self.state.now);
        let at = self.throws.within(from, from.after(activity.duration));
        Some(Mishap::Stop { at, id })
    }
}
