//! Timelines: what is used when, and where else something fits.
//!
//! Three words, after the slides. An *impact* changes a value, or its rate, at
//! an instant; the *result* is the value that follows, for each instant; a
//! *constraint* is a smallest and a largest value over a time. Kinds: state,
//! unit resource (usage bits), renewable (engines, peak power), consumable
//! (data; energy has an [own place](crate), since much of it is derived).
//!
//! What is inserted is only ever what somebody decided: activities and
//! windows. What follows from them (awake time, heating) is not in here, so
//! [`Timelines::valid_starts`] is exact for bits, engines, data and named
//! timelines, and for peak power a condition that must hold among others.

mod alone;
mod claim;
mod conflict;
mod intervals;
mod line;
mod longer;
mod named;
mod settings;
mod shown;
mod starts;

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::parameters::Parameters;
use crate::plan::Plan;
use crate::state::State;
use crate::timed::Limit;
use crate::units::Time;

pub use claim::{Claim, UnknownTimeline};
pub use conflict::Conflict;
pub use intervals::Intervals;
pub use shown::{Shown, Total};

use line::{Line, Ramp};
use named::Named;
use starts::{Bad, Keep, Part, Within, worse};

/// Everything that is used, from the present to the plan's end.
///
/// Equal by what it says, whatever was inserted and removed in between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Timelines {
    now: i64,
    /// The first instant that no limit is asked at.
    end: i64,
    bits: BTreeMap<u8, Line>,
    engines: Limited,
    peak: Limited,
    data: Limited,
    named: Vec<Named>,
    placed: BTreeMap<(i64, usize), Claim>,
    longest: Longest,
}

/// No claim lasts longer. It says nothing of what is used: two are equal,
/// whatever was removed again.
#[derive(Clone, Copy, Debug, Default)]
struct Longest(i64);

impl PartialEq for Longest {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Longest {}

/// A result with its largest value.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Limited {
    line: Line,
    max: i128,
}

impl Limited {
    fn add(&mut self, part: Option<Part>, start: i64, sign: i128) {
        if let Some(part) = part {
            add(&mut self.line, part, start, sign);
        }
    }

    fn bad(&self, part: Option<Part>, within: Within, bad: &mut Bad) {
        let part = part.as_slice();
        worse(&self.line, part, at_most(self.max), within, bad);
    }
}

/// Never more.
const fn at_most(max: i128) -> Keep {
    Keep { from: i64::MIN, to: i64::MAX, min: i128::MIN, max }
}

/// Adds a part of something that starts then. What lies before the line's
/// begin has happened: only its effect on what comes counts.
fn add(line: &mut Line, part: Part, start: i64, sign: i128) {
    let (from, to) = (start.saturating_add(part.from), start.saturating_add(part.to));
    let ramp = Ramp { value: part.value * sign, slope: part.slope * sign };
    line.add(from, from, to, ramp);
}

impl Timelines {
    /// With nothing in them but what the state says of now.
    #[must_use]
    pub fn new(plan: &Plan, parameters: &Parameters, state: &State) -> Self {
        // The limits hold at the plan's last instant, too.
        let (now, end) = (state.now.get(), plan.end.get().saturating_add(1));
        let line = |value| Line::new(now, end.max(now + 1), value);
        let zero = |max| Limited { line: line(0), max };
        let named = parameters.timelines.iter();
        Self {
            now,
            end,
            bits: BTreeMap::new(),
            engines: zero(parameters.engines.into()),
            peak: zero(parameters.peak_limit.get().into()),
            data: Limited {
                line: line(on_board(plan, state)),
                max: plan.max_delta_data.get().into(),
            },
            named: named
                .map(|spec| Named::new(spec, plan, state, (now, end.max(now + 1))))
                .collect(),
            placed: BTreeMap::new(),
            longest: Longest::default(),
        }
    }

    /// Something happens then. Of what has begun before now, what it did so far
    /// is in the state's values: what is left of it happens from now on.
    ///
    /// # Timing
    ///
    /// About the root of the number of changes that there are, for each
    /// timeline that it touches.
    pub fn insert(&mut self, claim: &Claim, start: Time) {
        let Some((claim, start)) = self.ahead(claim, start) else { return };
        self.change(&claim, start, 1);
        self.longest.0 = self.longest.0.max(claim.length);
        self.placed.insert((start, claim.order), claim.into_owned());
    }

    /// It does not happen then after all. Nothing where it was not inserted.
    pub fn remove(&mut self, claim: &Claim, start: Time) {
        let Some((claim, start)) = self.ahead(claim, start) else { return };
        if self.placed.get(&(start, claim.order)) == Some(&*claim) {
            self.placed.remove(&(start, claim.order));
            self.change(&claim, start, -1);
        }
    }

    /// What of it is not over, and when that begins.
    fn ahead<'c>(&self, claim: &'c Claim, start: Time) -> Option<(Cow<'c, Claim>, i64)> {
        let passed = self.now.saturating_sub(start.get());
        match passed {
            ..=0 => Some((Cow::Borrowed(claim), start.get())),
            _ if passed < claim.length => Some((Cow::Owned(claim.left(passed)), self.now)),
            _ => None,
        }
    }

    fn change(&mut self, claim: &Claim, start: i64, sign: i128) {
        for bit in bits(claim) {
            self.occupy(bit, claim, start, sign);
        }
        self.engines.add(claim.over(claim.engines.into()), start, sign);
        self.peak.add(claim.over(claim.peak.into()), start, sign);
        self.data.add(claim.volume(), start, sign);
        for touch in &claim.named {
            self.named[touch.line].change(touch, claim, start, sign);
        }
    }

    fn occupy(&mut self, bit: u8, claim: &Claim, start: i64, sign: i128) {
        let unused = || Line::new(self.now, self.end.max(self.now + 1), 0);
        let line = self.bits.entry(bit).or_insert_with(unused);
        if let Some(part) = claim.over(1) {
            add(line, part, start, sign);
        }
        // Also what is held from now to the end is flat.
        if line.is_flat() && *line == unused() {
            self.bits.remove(&bit);
        }
    }

    /// The starts, both ends of `within` included, at which nothing is used
    /// twice, no limit is exceeded or exceeded further, and every constraint is
    /// kept: its own, and those of what is inserted.
    ///
    /// # Timing
    ///
    /// For each timeline that it touches, in proportion to the changes that lie
    /// under the claim at one of these starts; for a consumable, to those after
    /// them, of which most are passed over where the limit is far.
    #[must_use]
    pub fn valid_starts(&self, claim: &Claim, within: (Time, Time)) -> Intervals {
        let within = (within.0.get().max(self.now), within.1.get().min(self.end));
        let mut bad = Bad::new();
        if within.0 <= within.1 {
            self.bad(claim, within, &mut bad);
        }
        let all = Intervals::between(Time::new(within.0), Time::new(within.1));
        all.without(&Intervals::united(&mut bad))
    }

    fn bad(&self, claim: &Claim, within: Within, bad: &mut Bad) {
        let one = claim.over(1);
        for line in bits(claim).filter_map(|bit| self.bits.get(&bit)) {
            worse(line, one.as_slice(), at_most(1), within, bad);
        }
        self.engines.bad(claim.over(claim.engines.into()), within, bad);
        self.peak.bad(claim.over(claim.peak.into()), within, bad);
        if claim.limited {
            self.data.bad(claim.volume(), within, bad);
        }
        for touch in &claim.named {
            self.named[touch.line].bad(touch, claim, within, bad);
        }
    }

    /// The peak power of activities and windows in [from, to), in mW, in order
    /// and without gaps: from when, and how much.
    pub fn peaks(&self, from: Time, to: Time) -> impl Iterator<Item = (Time, i64)> + '_ {
        let pieces = self.peak.line.pieces(from.get(), to.get(), |_, _| true);
        pieces.map(|piece| (Time::new(piece.from), narrow(piece.value)))
    }

    /// The data on board from an instant on, in bytes: since when, and how much.
    pub fn volumes(&self, from: Time) -> impl Iterator<Item = (Time, i64)> + '_ {
        let pieces = self.data.line.pieces(from.get(), i64::MAX, |_, _| true);
        pieces.map(|piece| (Time::new(piece.from), narrow(piece.value)))
    }

    /// The same with a higher limit of data, peak power or engines.
    pub(crate) fn raised(mut self, limit: &Limit, by: i64) -> Self {
        let raised = match limit {
            Limit::Data => &mut self.data,
            Limit::Peak => &mut self.peak,
            Limit::Engines => &mut self.engines,
            _ => return self,
        };
        raised.max += i128::from(by);
        self
    }

    /// Other values of a named timeline are allowed.
    pub(crate) fn allow(&mut self, line: usize, (min, max): (i64, i64)) {
        (self.named[line].min, self.named[line].max) = (min, max);
    }

    /// Something that is placed asks for other values of a named timeline, if
    /// it asks for any.
    pub(crate) fn ask(&mut self, line: usize, order: usize, range: (i64, i64)) {
        self.named[line].ask(order, range);
    }

    /// Whether a named timeline has one user at a time.
    pub(crate) fn is_unit(&self, line: usize) -> bool {
        self.named[line].holders.is_some()
    }

    /// The same from nothing: everything that is inserted, once more. What
    /// [`insert`](Self::insert) and [`remove`](Self::remove) made is equal to
    /// it.
    #[must_use]
    pub fn full(&self, plan: &Plan, parameters: &Parameters, state: &State) -> Self {
        let mut full = Self::new(plan, parameters, state);
        for (&(start, _), claim) in &self.placed {
            full.insert(claim, Time::new(start));
        }
        full
    }
}

/// What is on board now: what ended ones made, less what was sent in windows that
/// are over, and of a running one what it will have made, if that is more than
/// what it has. What a running downlink has not sent yet is on board until its
/// end.
fn on_board(plan: &Plan, state: &State) -> i128 {
    let ended = state.ended.iter().map(|ended| i128::from(ended.data.get()));
    let running = state.running.iter().map(|running| {
        let activity = plan.activities.iter().find(|activity| activity.id == running.id);
        let modelled = activity.map_or(i64::MIN, |activity| activity.data.get());
        i128::from(modelled.max(running.data.get()))
    });
    state.exchanged() + ended.chain(running).sum::<i128>()
}

fn bits(claim: &Claim) -> impl Iterator<Item = u8> + use<> {
    let mask = claim.bits;
    (0..128).filter(move |bit| mask >> bit & 1 == 1)
}

fn narrow(wide: i128) -> i64 {
    i64::try_from(wide).unwrap_or(if wide < 0 { i64::MIN } else { i64::MAX })
}
