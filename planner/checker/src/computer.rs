//! When the computer is up, derived from what needs it: from left to right, as
//! one would with a pencil.

use core::fmt::{self, Display, Formatter};

use faregate_planner::units::Time;

use crate::flow::Flow;
use crate::needs::components;

/// What the derivation is told.
#[derive(Debug)]
pub(crate) struct Rules {
    pub(crate) now: i64,
    pub(crate) end: i64,
    pub(crate) wakeup: i64,
    pub(crate) shutdown: i64,
    pub(crate) min_awake: i64,
    pub(crate) min_sleep: i64,
    /// What waking up, being up and shutting down draw.
    pub(crate) loads: [i128; 3],
    /// The charge that no sleep goes past.
    pub(crate) most: i128,
    /// What a sleep brings at most in a millisecond.
    pub(crate) surplus: i128,
    /// Manual blocks, in order.
    pub(crate) blocks: Vec<(i64, i64)>,
}

/// What the computer does when the plan begins.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Begin {
    /// Up; it may go down from `floor` on.
    Up { floor: i64 },
    /// Up from `up` on.
    Waking { up: i64 },
    /// Asleep since, or from then on.
    Asleep { since: i64 },
    /// In a manual block.
    Block,
}

/// The computer is up: as in a timed plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Phase {
    pub(crate) wakeup: i64,
    pub(crate) up: i64,
    pub(crate) down: i64,
    pub(crate) asleep: i64,
}

impl Display for Phase {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [wakeup, up, down, asleep] =
            [self.wakeup, self.up, self.down, self.asleep].map(Time::new);
        write!(f, "waking up at {wakeup}, awake from {up} to {down}, asleep at {asleep}")
    }
}

/// The time left for a wakeup or a sleep is too short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Short {
    pub(crate) at: i64,
    pub(crate) by: i64,
}

/// Where the walk has come to.
#[derive(Clone, Copy, Debug)]
enum Place {
    Up { wakeup: i64, up: i64, floor: i64 },
    Asleep { since: i64, first: bool },
    Over,
}

struct Walk<'a> {
    rules: &'a Rules,
    flow: &'a Flow,
    /// Components: [start, end), merged, in order.
    needs: Vec<(i64, i64)>,
    next: usize,
    /// The charge at `at`.
    charge: i128,
    at: i64,
    phases: Vec<Phase>,
    short: Vec<Short>,
}

/// All phases, and what came too late for one.
pub(crate) fn phases(
    rules: &Rules,
    flow: &Flow,
    begin: Begin,
    needs: Vec<(i64, i64)>,
    charge: i128,
) -> (Vec<Phase>, Vec<Short>) {
    let needs = components(rules, begin, needs);
    let (phases, short) = (Vec::new(), Vec::new());
    let mut walk = Walk { rules, flow, needs, next: 0, charge, at: rules.now, phases, short };
    let mut place = walk.first(begin);
    loop {
        place = match place {
            Place::Up { wakeup, up, floor } => walk.stay(wakeup, up, floor),
            Place::Asleep { since, first } => walk.sleep(since, first),
            Place::Over => return (walk.phases, walk.short),
        };
    }
}

impl Walk<'_> {
    fn first(&mut self, begin: Begin) -> Place {
        let now = self.rules.now;
        match begin {
            Begin::Up { floor } => Place::Up { wakeup: now, up: now, floor },
            Begin::Waking { up } => {
                // A wakeup in progress is cut off by what ends every phase.
                let up = up.min(self.stop(now));
                if let Some((start, _)) = self.needs.first().filter(|(start, _)| *start < up) {
                    self.short.push(Short { at: *start, by: up - start });
                }
                Place::Up { wakeup: now, up, floor: up + self.rules.min_awake }
            }
            Begin::Asleep { since } => Place::Asleep { since, first: true },
            Begin::Block => self.over_block(now),
        }
    }

    /// The phase in which the computer comes up: until when.
    fn stay(&mut self, wakeup: i64, up: i64, floor: i64) -> Place {
        let [waking, awake, shutting] = self.rules.loads;
        self.charge = self.flow.run(self.charge, self.at, wakeup, 0);
        self.charge = self.flow.run(self.charge, wakeup, up, waking);
        let down = self.down(up, floor);
        let stop = self.stop(up);
        let asleep = if down >= stop { down } else { down + self.rules.shutdown };
        self.charge = self.flow.run(self.charge, up, down, awake);
        self.charge = self.flow.run(self.charge, down, asleep, shutting);
        self.at = asleep;
        self.phases.push(Phase { wakeup, up, down, asleep });
        match down {
            down if down >= self.rules.end => Place::Over,
            down if down >= stop => self.over_block(down),
            _ => Place::Asleep { since: asleep, first: false },
        }
    }

    /// When shutting down begins.
    fn down(&mut self, up: i64, floor: i64) -> i64 {
        let stop = self.stop(up);
        let mut down = floor;
        loop {
            while let Some(need) = self.need(stop) {
                if self.begins(need) > down + self.least_gap() {
                    break;
                }
                down = down.max(need.1);
                self.next += 1;
            }
            if down >= stop {
                return stop;
            }
            if stop == self.rules.end && down + self.rules.shutdown > stop {
                return stop;
            }
            let next = self.need(stop);
            let last = next.map_or(self.rules.end - self.rules.shutdown, |need| {
                self.begins(need) - self.least_gap() - 1
            });
            match (self.first_allowed(up, down, last), next) {
                (Some(down), _) => return down,
                (None, Some(need)) => {
                    down = down.max(need.1);
                    self.next += 1;
                }
                (None, None) => return stop,
            }
        }
    }

    /// The first instant in [from, to] at which shutting down may begin,
    /// because a sleep of the minimum length does not go past the maximum.
    fn first_allowed(&self, up: i64, from: i64, to: i64) -> Option<i64> {
        let [_, awake, shutting] = self.rules.loads;
        let (shutdown, end) = (self.rules.shutdown, self.rules.end);
        let allowed = |down: i64| {
            let charge = self.flow.run(self.charge, up, down, awake);
            let charge = self.flow.run(charge, down, down + shutdown, shutting);
            let sleep = self.rules.min_sleep.max(1).min(end - down - shutdown).max(0);
            let full = charge + i128::from(sleep) * self.rules.surplus;
            full.min(self.flow.capacity()) <= self.rules.most
        };
        let mut cuts: Vec<i64> = self.flow.instants().flat_map(|at| [at, at - shutdown]).collect();
        cuts.extend([from, to, end - shutdown - self.rules.min_sleep]);
        cuts.retain(|at| (from..=to).contains(at));
        cuts.sort_unstable();
        // Between two cuts the charge after the sleep is a minimum of straight
        // lines: where it is too high at the first cut, it comes down once.
        let pieces = cuts.iter().zip(cuts.iter().skip(1).chain(cuts.last()));
        pieces.into_iter().find_map(|(from, to)| first_true(*from, *to, allowed))
    }

    /// The sleep that begins at `since`: until when.
    fn sleep(&mut self, since: i64, first: bool) -> Place {
        let rules = self.rules;
        let from = since.max(rules.now);
        self.charge = self.flow.run(self.charge, self.at, from, 0);
        self.at = from;
        let need = self.needs.get(self.next).copied();
        let until = need.map_or(rules.end, |need| self.begins(need) - rules.wakeup);
        let full = self.flow.full(self.charge, from, until.max(from), rules.most);
        if let Some(full) = full.filter(|full| *full <= until) {
            return self.wake_full(full, from, first);
        }
        let Some(need) = need else { return Place::Over };
        let up = self.begins(need);
        if until < from || until - since < rules.min_sleep {
            let by = (from - until).max(rules.min_sleep - (until - since));
            self.short.push(Short { at: need.0, by });
        }
        let wakeup = until.max(from);
        let late = (wakeup + rules.wakeup).min(self.stop(wakeup));
        let up = if wakeup > until { late } else { up };
        Place::Up { wakeup, up, floor: up + rules.min_awake }
    }

    /// The battery is as full as it may be in a sleep.
    fn wake_full(&mut self, full: i64, since: i64, first: bool) -> Place {
        let rules = self.rules;
        let up = (full + rules.wakeup).min(rules.end - rules.min_awake);
        let wakeup = up - rules.wakeup;
        match self.phases.last_mut() {
            // No sleep is left: the phase before lasts until the end.
            Some(before) if !first && (wakeup - since < rules.min_sleep || wakeup == since) => {
                (before.down, before.asleep) = (rules.end, rules.end);
                Place::Over
            }
            _ => {
                let wakeup = wakeup.max(since);
                let up = (wakeup + rules.wakeup).min(rules.end);
                Place::Up { wakeup, up, floor: up + rules.min_awake }
            }
        }
    }

    /// A manual block brings its own shutdown and wakeup.
    fn over_block(&mut self, start: i64) -> Place {
        let block = self.rules.blocks.iter().find(|(from, to)| *from <= start && start < *to);
        let Some((_, end)) = block else { return Place::Over };
        if *end >= self.rules.end {
            return Place::Over;
        }
        self.charge = self.flow.run(self.charge, self.at, *end, 0);
        self.at = *end;
        self.next = self.needs.partition_point(|(from, _)| *from < *end);
        Place::Up { wakeup: *end, up: *end, floor: *end + self.rules.min_awake }
    }

    /// The next component, if it begins before what ends this phase.
    fn need(&self, stop: i64) -> Option<(i64, i64)> {
        self.needs.get(self.next).copied().filter(|(start, _)| *start <= stop)
    }

    /// When the computer must be up for a component: earlier where there is not
    /// enough time after it for the shortest awake phase.
    fn begins(&self, need: (i64, i64)) -> i64 {
        let after_block = self.rules.blocks.iter().any(|(_, end)| *end == need.0);
        if after_block { need.0 } else { need.0.min(self.stop(need.0) - self.rules.min_awake) }
    }

    /// A sleep between a phase that goes down and the next that is up has room
    /// if there is more than this: shutdown, sleep, wakeup.
    fn least_gap(&self) -> i64 {
        // Equality leaves exactly the shortest sleep.
        self.rules.shutdown + self.rules.min_sleep + self.rules.wakeup - 1
    }

    /// The next manual block's begin, or else the end.
    fn stop(&self, up: i64) -> i64 {
        let mut begins = self.rules.blocks.iter().map(|(start, _)| *start);
        begins.find(|start| *start >= up).unwrap_or(self.rules.end).min(self.rules.end)
    }
}

/// The first instant in [from, to] for which it is true, if it does not become
/// false again once it is true there.
fn first_true(from: i64, to: i64, what: impl Fn(i64) -> bool) -> Option<i64> {
    if what(from) {
        return Some(from);
    }
    if !what(to) {
        return None;
    }
    let (mut no, mut yes) = (from, to);
    while yes - no > 1 {
        let middle = no + (yes - no) / 2;
        if what(middle) { yes = middle } else { no = middle }
    }
    Some(yes)
}
