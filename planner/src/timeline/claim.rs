//! What an activity or a window does to timelines, wherever it starts.

use core::fmt;

use crate::parameters::{Parameters, TimelineKind};
use crate::plan::{Activity, ActivityId, Constraint, Effect};
use crate::state::{Running, Window};
use crate::units::{Span, Time};

use super::starts::{FOREVER, Part};

/// Values of named timelines are counted in thousandths, so that a rate for each
/// second is a whole number for each ms.
pub(crate) const FINE: i128 = 1_000;

/// Impacts and constraints of something that has no start yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Claim {
    pub(crate) id: Option<ActivityId>,
    pub(crate) order: usize,
    pub(crate) length: i64,
    pub(crate) bits: u128,
    pub(crate) engines: u32,
    pub(crate) peak: u64,
    pub(crate) data: i64,
    pub(crate) limited: bool,
    pub(crate) named: Vec<Touch>,
}

/// What it does to one named timeline.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Touch {
    /// Which one, by its place in the parameters.
    pub(crate) line: usize,
    /// What it adds.
    pub(crate) parts: Vec<Part>,
    /// Whether it holds a unit.
    pub(crate) holds: bool,
    /// What it sets the value to at its start and at its end.
    pub(crate) sets: [Option<i64>; 2],
    /// What it asks for while it runs: the smallest and the largest value.
    pub(crate) keep: Option<(i64, i64)>,
}

impl Touch {
    /// What it adds while it runs, from its start on, and each ms.
    pub(super) fn during(&self) -> (i128, i128) {
        let part = self.parts.iter().find(|part| part.to != FOREVER);
        part.map_or((0, 0), |part| (part.value, part.slope))
    }

    /// What stays of it.
    pub(super) fn stays(&self) -> i128 {
        self.parts.iter().find(|part| part.to == FOREVER).map_or(0, |part| part.value)
    }

    /// What it goes on to do when so much of its time has passed: what it holds,
    /// it holds on; what it has added, and set at its start, is there.
    fn left(&self, passed: i64) -> Self {
        let (value, slope) = self.during();
        let there = if self.holds { 0 } else { value + slope * i128::from(passed) };
        let end =
            self.parts.iter().map(|part| if part.to == FOREVER { part.from } else { part.to });
        let left = end.max().map_or(0, |end| end - passed);
        let during = Part { from: 0, to: left, value: if self.holds { value } else { 0 }, slope };
        let after = Part { from: left, to: FOREVER, value: self.stays() - there, slope: 0 };
        let parts = [during, after].into_iter().filter(Part::is_something).collect();
        Self { parts, sets: [None, self.sets[1]], ..self.clone() }
    }
}

/// An activity names a timeline that the parameters have not got.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownTimeline(pub String);

impl fmt::Display for UnknownTimeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the parameters have no timeline {:?}", self.0)
    }
}

impl core::error::Error for UnknownTimeline {}

impl Claim {
    /// An activity of this length; `order` is its place in the plan.
    ///
    /// # Errors
    ///
    /// [`UnknownTimeline`].
    pub fn of(
        activity: &Activity,
        order: usize,
        length: Span,
        parameters: &Parameters,
    ) -> Result<Self, UnknownTimeline> {
        let effects = effects(activity, parameters)?;
        let sums = effects.iter().map(|(line, all)| (*line, Sum::whole(all)));
        Self::with(activity, order, length, parameters, sums.collect())
    }

    /// What is left at `now` of an activity that runs until `until`: a claim
    /// whose start is `now`.
    ///
    /// # Errors
    ///
    /// [`UnknownTimeline`].
    pub fn rest(
        activity: &Activity,
        order: usize,
        running: &Running,
        (now, until): (Time, Time),
        parameters: &Parameters,
    ) -> Result<Self, UnknownTimeline> {
        let effects = effects(activity, parameters)?;
        let sums = effects.iter().map(|(line, all)| {
            // What it did at its start, the state's values have in them.
            let sum = Sum::whole(all);
            let rate = if running.paused.is_some() { 0 } else { sum.rate };
            (*line, Sum { start: 0, rate, sets: [None, sum.sets[1]], ..sum })
        });
        let mut claim = Self::with(activity, order, until.since(now), parameters, sums.collect())?;
        // What it has on board counts from now on. A downlink frees the rest of
        // what it was to send at its end.
        let rest = activity.data.get() - activity.data.get().max(running.data.get());
        claim.data = if activity.data.get() < 0 { rest } else { 0 };
        claim.limited = false;
        Ok(claim)
    }

    /// What is left of it when so much of its time has passed, and less than all.
    pub(super) fn left(&self, passed: i64) -> Self {
        let named = self.named.iter().map(|touch| touch.left(passed)).collect();
        Self { length: self.length - passed, named, ..self.clone() }
    }

    /// A communication window. `order` is any number that no activity has.
    #[must_use]
    pub fn window(window: &Window, order: usize) -> Self {
        Self {
            id: None,
            order,
            length: window.end.since(window.start).get(),
            bits: window.resources.mask(),
            engines: window.engines,
            peak: window.peak.get(),
            data: window.data.get(),
            limited: false,
            named: Vec::new(),
        }
    }

    /// How long it lasts.
    #[must_use]
    pub const fn length(&self) -> Span {
        Span::new(self.length)
    }

    fn with(
        activity: &Activity,
        order: usize,
        length: Span,
        parameters: &Parameters,
        sums: Vec<(usize, Sum)>,
    ) -> Result<Self, UnknownTimeline> {
        let mut claim = Self {
            id: Some(activity.id),
            order,
            length: length.get(),
            bits: activity.resources.mask(),
            engines: activity.engines,
            peak: activity.peak.get(),
            data: activity.data.get(),
            limited: activity.priority < parameters.mandatory_from && activity.data.get() > 0,
            named: sums.into_iter().map(|(line, sum)| sum.touch(line, length.get())).collect(),
        };
        for constraint in &activity.constraints {
            claim.keep(find(&constraint.timeline, parameters)?.0, constraint);
        }
        Ok(claim)
    }

    /// Asks for other values of a named timeline, if it asks for any.
    pub(crate) fn ask(&mut self, line: usize, range: (i64, i64)) {
        for touch in self.named.iter_mut().filter(|touch| touch.line == line) {
            touch.keep = touch.keep.map(|_| range);
        }
    }

    /// Takes nothing of a named timeline of which it only ever takes a part.
    pub(crate) fn hold_nothing(&mut self, line: usize) {
        for touch in self.named.iter_mut().filter(|touch| touch.line == line) {
            *touch = Touch { line, keep: touch.keep, ..Touch::default() };
        }
    }

    fn keep(&mut self, line: usize, constraint: &Constraint) {
        let place = self.named.iter().position(|touch| touch.line == line);
        let place = place.unwrap_or_else(|| {
            self.named.push(Touch { line, ..Touch::default() });
            self.named.len() - 1
        });
        let keep = &mut self.named[place].keep;
        let (min, max) = keep.unwrap_or((i64::MIN, i64::MAX));
        *keep = Some((min.max(constraint.min), max.min(constraint.max)));
    }

    /// What it adds to something that it holds from its start to its end.
    pub(crate) fn over(&self, amount: i128) -> Option<Part> {
        let part = Part { from: 0, to: self.length, value: amount, slope: 0 };
        (self.length > 0 && amount != 0).then_some(part)
    }

    /// What it adds to the data on board: a downlink frees them at its end.
    pub(crate) fn volume(&self) -> Option<Part> {
        let from = if self.data < 0 { self.length } else { 0 };
        let part = Part { from, to: FOREVER, value: self.data.into(), slope: 0 };
        (self.data != 0).then_some(part)
    }
}

/// All effects on one timeline together.
#[derive(Clone, Copy, Default)]
struct Sum {
    hold: i128,
    start: i128,
    end: i128,
    rate: i128,
    holds: bool,
    sets: [Option<i64>; 2],
}

impl Sum {
    fn whole(effects: &[Effect]) -> Self {
        let mut sum = Self::default();
        for effect in effects {
            match *effect {
                Effect::SetAtStart(value) => sum.sets[0] = Some(value),
                Effect::SetAtEnd(value) => sum.sets[1] = Some(value),
                Effect::AddAtStart(amount) => sum.start += i128::from(amount),
                Effect::AddAtEnd(amount) => sum.end += i128::from(amount),
                Effect::Rate(amount) => sum.rate += i128::from(amount),
                Effect::Hold(amount) => {
                    sum.hold += i128::from(amount);
                    sum.holds = true;
                }
            }
        }
        sum
    }

    fn touch(self, line: usize, length: i64) -> Touch {
        let during =
            Part { from: 0, to: length, value: (self.hold + self.start) * FINE, slope: self.rate };
        let value = (self.start + self.end) * FINE + self.rate * i128::from(length);
        let after = Part { from: length, to: FOREVER, value, slope: 0 };
        let parts = [during, after].into_iter();
        let some = |part: &Part| part.from < part.to && part.is_something();
        let (holds, sets) = (self.holds && length > 0, self.sets);
        Touch { line, parts: parts.filter(some).collect(), holds, sets, keep: None }
    }
}

/// A timeline's place in the parameters, and what is done to it.
type Effects = Vec<(usize, Vec<Effect>)>;

fn effects(activity: &Activity, parameters: &Parameters) -> Result<Effects, UnknownTimeline> {
    let mut all: Effects = Vec::new();
    for impact in &activity.impacts {
        let (line, kind) = find(&impact.timeline, parameters)?;
        if !fits(kind, impact.effect) {
            continue;
        }
        match all.iter_mut().find(|(known, _)| *known == line) {
            Some((_, effects)) => effects.push(impact.effect),
            None => all.push((line, vec![impact.effect])),
        }
    }
    Ok(all)
}

/// Whether timelines of this kind know the effect. Others have none: a check of
/// the plan tells of them.
const fn fits(kind: TimelineKind, effect: Effect) -> bool {
    match effect {
        Effect::SetAtStart(_) | Effect::SetAtEnd(_) => matches!(kind, TimelineKind::State),
        Effect::Hold(_) => matches!(kind, TimelineKind::Unit | TimelineKind::Renewable),
        Effect::AddAtStart(_) | Effect::AddAtEnd(_) | Effect::Rate(_) => {
            matches!(kind, TimelineKind::Consumable)
        }
    }
}

fn find(name: &str, parameters: &Parameters) -> Result<(usize, TimelineKind), UnknownTimeline> {
    let place = parameters.timelines.iter().position(|spec| spec.name == name);
    let found = place.map(|line| (line, parameters.timelines[line].kind));
    found.ok_or_else(|| UnknownTimeline(name.to_owned()))
}
