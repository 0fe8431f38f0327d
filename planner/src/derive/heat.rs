//! Heating of a thermal zone, as it follows from when the zone is used.
//!
//! A zone is heated before each use of it, for as long as the table says of the
//! time of day at which the use begins, but not before the last use ended: that
//! left it warm. Nothing is heated for a use that begins while another lasts.

use crate::problem::{Problem, ZoneModel};

use super::var::{Reach, Var};

/// An activity uses a zone. In the order in which they are heated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Use {
    pub(crate) start: i64,
    pub(crate) item: usize,
    pub(crate) end: i64,
}

/// Heating for an activity, from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heat {
    pub(crate) from: i64,
    pub(crate) to: i64,
    pub(crate) item: usize,
    /// By how much earlier than now it should have begun.
    pub(crate) late: i64,
}

/// The same, where it depends on a candidate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VarHeat {
    pub(crate) from: Var,
    pub(crate) to: Var,
    pub(crate) item: usize,
    pub(crate) late: i64,
}

/// What a candidate changes of a zone's heating.
#[derive(Debug, Default)]
pub(crate) struct Changed {
    pub(crate) gone: Vec<Heat>,
    pub(crate) new: Vec<VarHeat>,
}

/// The uses of a zone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ZoneLine {
    uses: Vec<Use>,
    /// For each: until when a use lasts at most that begins before it or at it.
    until: Vec<i64>,
    /// For each: its heating.
    pub(crate) heats: Vec<Option<Heat>>,
    /// Heating never takes longer.
    longest: i64,
}

impl ZoneLine {
    pub(crate) fn new(zone: &ZoneModel) -> Self {
        let longest = zone.table.iter().map(|row| row.duration.get()).max();
        Self {
            uses: Vec::new(),
            until: Vec::new(),
            heats: Vec::new(),
            longest: longest.unwrap_or(0),
        }
    }

    /// What changes: heating that is gone (`false`) or new.
    pub(crate) fn insert(
        &mut self,
        problem: &Problem,
        zone: &ZoneModel,
        new: Use,
    ) -> Vec<(Heat, bool)> {
        let over = zone.cold && new.end <= problem.now;
        if over || new.start >= new.end {
            return Vec::new();
        }
        let at = self.uses.partition_point(|old| *old < new);
        self.uses.insert(at, new);
        self.heats.insert(at, None);
        self.again(problem, zone, at)
    }

    /// What changes: heating that is gone (`false`) or new.
    pub(crate) fn remove(
        &mut self,
        problem: &Problem,
        zone: &ZoneModel,
        old: Use,
    ) -> Vec<(Heat, bool)> {
        let Ok(at) = self.uses.binary_search(&old) else { return Vec::new() };
        self.uses.remove(at);
        let gone = self.heats.remove(at);
        let mut changed = self.again(problem, zone, at);
        changed.extend(gone.map(|heat| (heat, false)));
        changed
    }

    /// Heating from the use `at` on, once more.
    fn again(&mut self, problem: &Problem, zone: &ZoneModel, at: usize) -> Vec<(Heat, bool)> {
        let mut changed = Vec::new();
        let mut until = at.checked_sub(1).map_or(i64::MIN, |before| self.until[before]);
        self.until.truncate(at);
        for (used, kept) in self.uses[at..].iter().zip(&mut self.heats[at..]) {
            let mut reach = Reach::ALL;
            let warm = Var::fixed(until);
            let heat = heat(problem, zone, (Var::fixed(used.start), used.item), warm, &mut reach);
            let heat = heat.map(VarHeat::now);
            if heat != *kept {
                changed.extend(kept.map(|old| (old, false)));
                changed.extend(heat.map(|new| (new, true)));
                *kept = heat;
            }
            until = until.max(used.end);
            self.until.push(until);
        }
        changed
    }

    /// What changes where a candidate uses it, too.
    pub(crate) fn with(
        &self,
        problem: &Problem,
        zone: &ZoneModel,
        (item, start, end): (usize, Var, Var),
        reach: &mut Reach,
    ) -> Changed {
        let mut changed = Changed::default();
        let at = self.place(item, start, reach);
        let warm = at.checked_sub(1).map_or(i64::MIN, |before| self.until[before]);
        changed.new.extend(heat(problem, zone, (start, item), Var::fixed(warm), reach));
        for later in at..self.uses.len() {
            let used = self.uses[later];
            let warm = later.checked_sub(1).map_or(i64::MIN, |before| self.until[before]);
            let far = Var::fixed(warm.max(used.start - self.longest));
            if reach.le(end, far) {
                break;
            }
            let Some(old) = self.heats[later] else { continue };
            let new = heat(problem, zone, (Var::fixed(used.start), used.item), end, reach);
            if !new.is_some_and(|new| new.from.is_fixed() && new.now() == old) {
                changed.gone.push(old);
                changed.new.extend(new);
            }
        }
        changed
    }

    /// How many uses begin before it.
    fn place(&self, item: usize, start: Var, reach: &mut Reach) -> usize {
        let at = self.uses.partition_point(|used| (used.start, used.item) < (start.at, item));
        if let Some(before) = at.checked_sub(1).map(|before| self.uses[before]) {
            let _ = reach.le(Var::fixed(before.start), start);
        }
        if let Some(after) = self.uses.get(at) {
            let _ = reach.le(start, Var::fixed(after.start));
        }
        at
    }
}

impl VarHeat {
    fn now(self) -> Heat {
        Heat { from: self.from.at, to: self.to.at, item: self.item, late: self.late }
    }
}

/// Heating for a use, where the last one before it ended at `warm`. Empty where
/// it is late and the use begins now.
fn heat(
    problem: &Problem,
    zone: &ZoneModel,
    (start, item): (Var, usize),
    warm: Var,
    reach: &mut Reach,
) -> Option<VarHeat> {
    let now = Var::fixed(problem.now);
    if reach.lt(start, now) || warm.at != i64::MIN && reach.lt(start, warm) {
        return None;
    }
    let (duration, until) = zone.preheat(start.at);
    if !start.is_fixed() {
        reach.limit(until - 1 - start.at);
    }
    let mut from = start.later(-duration);
    if warm.at != i64::MIN && reach.lt(from, warm) {
        from = warm;
    }
    if reach.le(start, from) {
        return None;
    }
    let mut late = 0;
    if reach.lt(from, now) {
        let heated = zone.heating.is_some_and(|since| reach.le(Var::fixed(since), from));
        late = if heated { 0 } else { now.at - from.at };
        from = now;
    }
    Some(VarHeat { from, to: start, item, late })
}
