//! What came of an execution.

use std::collections::{BTreeMap, BTreeSet};

use faregate_planner::plan::{Kind, Outcome};
use faregate_planner::state::Mode;
use faregate_planner::trace::{Cause, Happened, Trace, Unstarted};
use faregate_planner::units::{Span, Time};
use faregate_planner::{ActivityId, Plan};
use serde::{Deserialize, Serialize};

/// Counts of one execution, or sums over many.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Summary {
    /// Executions.
    pub executions: u64,
    /// Activities that did their work.
    pub succeeded: u64,
    /// Activities that ended in a malfunction.
    pub failed: u64,
    /// Activities that were aborted, by cause.
    pub aborted: BTreeMap<Cause, u64>,
    /// Activities that never started.
    pub not_started: u64,
    /// Of these, those that were vetoed.
    pub vetoed: u64,
    /// Cleanups that were started.
    pub cleanups: u64,
    /// Starts before the planned one.
    pub early_starts: u64,
    /// Times that an activity was paused.
    pub paused: u64,
    /// Plans that were made, the first one not counted.
    pub replans: u64,
    /// Next plans that took over.
    pub handovers: u64,
    /// Next plans that could not: the plan went on.
    pub went_on: u64,
    /// How long the computer was up.
    pub awake_ms: i64,
    /// What was drawn beside the base load, in uJ.
    pub drawn_uj: u64,
    /// What the battery held at the end, in uJ.
    pub charge_uj: u64,
}

/// What executing flexibly has won against the first timed plan as it stood.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Won {
    /// Activities that succeeded here and not there, less those that succeeded
    /// there and not here.
    pub activities: i64,
    /// How much earlier those that succeeded in both ended, in sum.
    pub earlier_ms: i64,
    /// How much less the computer was up.
    pub awake_ms: i64,
    /// How much less was drawn, in uJ. What the battery holds at the end says
    /// less: one that is full sooner takes no more.
    pub energy_uj: i64,
}

impl Summary {
    /// Of one trace.
    #[must_use]
    pub fn of(plan: &Plan, trace: &Trace) -> Self {
        let mut summary = Self { executions: 1, ..Self::default() };
        let mut cleanups = cleanups(plan);
        for entry in &trace.entries {
            if let Happened::HandedOver(next) = &entry.what {
                cleanups = self::cleanups(next);
            }
            summary.count(&entry.what, &cleanups);
        }
        summary.replans = summary.replans.saturating_sub(1);
        summary.awake_ms = awake(trace).get();
        summary.drawn_uj = drawn(trace);
        summary
    }

    fn count(&mut self, what: &Happened, cleanups: &BTreeSet<ActivityId>) {
        match what {
            Happened::Planned { .. } => self.replans += 1,
            Happened::Dispatched(dispatch) => {
                self.early_starts += u64::from(dispatch.early);
                self.cleanups += u64::from(cleanups.contains(&dispatch.id));
            }
            Happened::Ended { outcome: Outcome::Succeeded, .. } => self.succeeded += 1,
            Happened::Ended { .. } => self.failed += 1,
            Happened::Aborted { cause, .. } => *self.aborted.entry(*cause).or_default() += 1,
            Happened::NotStarted { why, .. } => {
                self.not_started += 1;
                self.vetoed += u64::from(*why == Unstarted::Vetoed);
            }
            Happened::HandedOver(_) => self.handovers += 1,
            Happened::NoNextPlan(_) => self.went_on += 1,
            Happened::Paused(_) => self.paused += 1,
            Happened::Truth(truth) => self.charge_uj = truth.charge.get(),
            _ => {}
        }
    }

    /// What a campaign is for and never came up in it, in words: it shows nothing
    /// about that.
    #[must_use]
    pub fn never(&self) -> Vec<&'static str> {
        let aborts = |cause| self.aborted.get(&cause).copied().unwrap_or(0);
        let counts = [
            (self.succeeded, "success"),
            (self.failed, "failure"),
            (aborts(Cause::Cutoff), "abort at the cutoff"),
            (aborts(Cause::HardLimit), "abort at the hard limit"),
            (aborts(Cause::SoftLimit), "abort below the soft limit"),
            (aborts(Cause::Duration), "abort past its duration"),
            (aborts(Cause::TicketsTaken), "abort for want of tickets"),
            (aborts(Cause::ChargeUnknown), "abort while the charge was not known"),
            (self.cleanups, "cleanup"),
            (self.early_starts, "early start"),
            (self.paused, "pause"),
            (self.vetoed, "veto"),
            (self.handovers, "handover"),
            (self.went_on, "next plan that is not there"),
        ];
        counts.into_iter().filter(|(count, _)| *count == 0).map(|(_, name)| name).collect()
    }

    /// Adds another one.
    pub fn add(&mut self, other: &Self) {
        self.executions += other.executions;
        self.succeeded += other.succeeded;
        self.failed += other.failed;
        for (cause, count) in &other.aborted {
            *self.aborted.entry(*cause).or_default() += count;
        }
        self.not_started += other.not_started;
        self.vetoed += other.vetoed;
        self.handovers += other.handovers;
        self.went_on += other.went_on;
        self.cleanups += other.cleanups;
        self.early_starts += other.early_starts;
        self.paused += other.paused;
        self.replans += other.replans;
        self.awake_ms = self.awake_ms.saturating_add(other.awake_ms);
        self.drawn_uj = self.drawn_uj.saturating_add(other.drawn_uj);
        self.charge_uj = self.charge_uj.saturating_add(other.charge_uj);
    }
}

fn cleanups(plan: &Plan) -> BTreeSet<ActivityId> {
    let all = plan.activities.iter().filter(|activity| activity.kind == Kind::Cleanup);
    all.map(|activity| activity.id).collect()
}

impl Won {
    /// By the first of two executions of a plan, against the second.
    #[must_use]
    pub fn between(plan: &Plan, ours: &Trace, theirs: &Trace) -> Self {
        let (a, b) = (successes(ours), successes(theirs));
        let earlier = a.iter().filter_map(|(id, at)| Some(b.get(id)?.since(*at).get()));
        let (here, there) = (Summary::of(plan, ours), Summary::of(plan, theirs));
        let signed = |count: u64| i64::try_from(count).unwrap_or(i64::MAX);
        Self {
            activities: signed(here.succeeded) - signed(there.succeeded),
            earlier_ms: earlier.sum(),
            awake_ms: there.awake_ms - here.awake_ms,
            energy_uj: signed(there.drawn_uj) - signed(here.drawn_uj),
        }
    }
}

fn successes(trace: &Trace) -> BTreeMap<ActivityId, Time> {
    let ended = trace.entries.iter().filter_map(|entry| match entry.what {
        Happened::Ended { id, outcome: Outcome::Succeeded, .. } => Some((id, entry.at)),
        _ => None,
    });
    ended.collect()
}

/// Loads are constant from one entry about the truth to the next.
fn drawn(trace: &Trace) -> u64 {
    let truths = trace.entries.iter().filter_map(|entry| match entry.what {
        Happened::Truth(truth) => Some((entry.at, truth.load.get())),
        _ => None,
    });
    let (mut drawn, mut before) = (0_u64, None);
    for (at, load) in truths {
        if let Some((since, load)) = before.replace((at, load)) {
            let ms = u64::try_from(at.since(since).get()).unwrap_or(0);
            drawn = drawn.saturating_add(ms.saturating_mul(load));
        }
    }
    drawn
}

/// How long the computer was up.
fn awake(trace: &Trace) -> Span {
    let mut since = trace.entries.first().and_then(|entry| match &entry.what {
        Happened::Planned { state, .. } if state.mode == Mode::Awake => Some(trace.begin),
        _ => None,
    });
    let mut total = 0;
    for entry in &trace.entries {
        let Happened::Mode(mode) = entry.what else { continue };
        match (mode, since) {
            (Mode::Awake, None) => since = Some(entry.at),
            (Mode::ShuttingDown | Mode::Asleep, Some(up)) => {
                total += entry.at.since(up).get();
                since = None;
            }
            _ => {}
        }
    }
    Span::new(total + since.map_or(0, |up| trace.end.since(up).get()))
}
