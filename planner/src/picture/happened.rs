//! What happened to an activity, from a trace.

use crate::picture::lane::{Bar, Ending, Lane, Stretch};
use crate::plan::{ActivityId, Outcome};
use crate::state::Mode;
use crate::timed::{AwakePhase, Fate, Reason, TimedPlan};
use crate::trace::{Cause, Entry, Happened, Trace, Unstarted};
use crate::units::Time;
use crate::words::Words;

/// A run, while the trace is read.
#[derive(Default)]
struct Run {
    since: Option<Time>,
    paused: Option<Time>,
    early: bool,
    ends: Time,
    bars: Vec<Bar>,
    pauses: Vec<Stretch>,
}

/// Puts the activity's pieces, pauses and end into its row.
pub(super) fn put(trace: &Trace, id: ActivityId, words: &Words<'_>, lane: &mut Lane) {
    let mut run = Run::default();
    for Entry { at, what } in &trace.entries {
        match what {
            Happened::Dispatched(how) if how.id == id => {
                run.since = Some(*at);
                run.early = how.early;
                run.ends = how.ends;
            }
            Happened::Paused(other) if *other == id => {
                run.piece(*at, lane.mandatory, Ending::Quiet, "");
                run.paused = Some(*at);
            }
            Happened::Resumed(other) if *other == id => {
                run.pauses.extend(run.paused.take().map(|from| (from, *at)));
                run.since = Some(*at);
            }
            Happened::Ended { id: other, outcome, .. } if *other == id => {
                let ending = if *outcome == Outcome::Failed {
                    Ending::Failed
                } else if *at < run.ends {
                    Ending::Early
                } else {
                    Ending::Quiet
                };
                run.end(
                    *at,
                    lane.mandatory,
                    ending,
                    if ending == Ending::Failed { "failed" } else { "" },
                );
            }
            Happened::Aborted { id: other, cause, .. } if *other == id => {
                run.end(*at, lane.mandatory, Ending::Aborted, because(*cause));
            }
            Happened::Planned { timed, .. } => {
                // The last plan knows best why it could not be, unless its time
                // was over by then.
                let late = lane.out.is_some() && is_late(timed, id);
                let why = left_out(timed, id, words).filter(|_| !late);
                lane.out = why.or_else(|| lane.out.take());
            }
            Happened::NotStarted { id: other, why } if *other == id => {
                let known = lane.out.is_some() && *why == Unstarted::NotPlanned;
                if !known {
                    lane.out = Some((unstarted(*why).into(), Some(*at)));
                }
            }
            _ => {}
        }
    }
    if !run.bars.is_empty() || run.since.is_some() {
        lane.out = None;
    }
    run.end(trace.end, lane.mandatory, Ending::Quiet, "");
    for bar in &mut run.bars {
        bar.tip =
            format!("{}: {} to {}", lane.label, words.time(bar.span.0), words.time(bar.span.1));
    }
    lane.bars = run.bars;
    lane.pauses = run.pauses;
}

/// When the ground's own shutdown was over, if it came to that: nobody starts it.
pub(super) fn block_over(trace: &Trace, id: ActivityId) -> Option<Time> {
    trace.entries.iter().find_map(|entry| match entry.what {
        Happened::Ended { id: other, .. } if other == id => Some(entry.at),
        _ => None,
    })
}

/// What became of an activity, if it started or was given up.
pub(super) fn outcome(trace: &Trace, id: ActivityId) -> Option<Outcome> {
    trace.entries.iter().rev().find_map(|entry| match entry.what {
        Happened::Ended { id: other, outcome, .. } if other == id => Some(outcome),
        Happened::Aborted { id: other, .. } if other == id => Some(Outcome::Aborted),
        Happened::NotStarted { id: other, .. } if other == id => Some(Outcome::NotStarted),
        _ => None,
    })
}

/// Why a timed plan leaves it out, if it does.
pub(super) fn left_out(
    timed: &TimedPlan,
    id: ActivityId,
    words: &Words<'_>,
) -> Option<(String, Option<Time>)> {
    let row = timed.rows.iter().find(|row| row.id == id)?;
    let Fate::Out(reason) = &row.fate else { return None };
    let at = match reason {
        Reason::Limit { at, .. } => Some(*at),
        _ => None,
    };
    Some((words.reason(reason), at))
}

fn is_late(timed: &TimedPlan, id: ActivityId) -> bool {
    let row = timed.rows.iter().find(|row| row.id == id);
    let late = |fate: &Fate| matches!(fate, Fate::Out(Reason::Committed | Reason::NoRangeLeft));
    row.is_some_and(|row| late(&row.fate))
}

impl Run {
    fn piece(&mut self, until: Time, mandatory: bool, ending: Ending, words: &str) {
        let Some(from) = self.since.take() else { return };
        let early = self.early && self.bars.is_empty();
        let (span, words) = ((from, until), words.to_owned());
        self.bars.push(Bar {
            span,
            minimum: None,
            mandatory,
            ending,
            early,
            words,
            tip: String::new(),
        });
    }

    /// The last piece, or the mark at the end of a pause.
    fn end(&mut self, at: Time, mandatory: bool, ending: Ending, words: &str) {
        if let Some(from) = self.paused.take() {
            self.pauses.push((from, at));
            self.since = Some(at);
        }
        self.piece(at, mandatory, ending, words);
    }
}

const fn because(cause: Cause) -> &'static str {
    match cause {
        Cause::Cutoff => "aborted: cutoff",
        Cause::HardLimit => "aborted: hard limit of charge",
        Cause::SoftLimit => "aborted: optional, below the soft minimum",
        Cause::Duration => "aborted: optional, past its duration",
        Cause::ChargeUnknown => "aborted: nobody knew the charge",
        Cause::TicketsTaken => "aborted: its tickets were taken",
        Cause::Ordered => "aborted: ordered",
    }
}

const fn unstarted(why: Unstarted) -> &'static str {
    match why {
        Unstarted::RangeClosed => "not started: its last start range closed",
        Unstarted::Vetoed => "not started: vetoed",
        Unstarted::NotPlanned => "not planned",
        Unstarted::HandedOver => "handed over to the next plan",
    }
}

/// When the computer was up.
pub(super) fn awake(trace: &Trace) -> Vec<AwakePhase> {
    let mut phases: Vec<AwakePhase> = Vec::new();
    let mut is_open = false;
    for (at, mode) in modes(trace) {
        match (mode, phases.last_mut().filter(|_| is_open)) {
            (Mode::WakingUp | Mode::Awake, None) => {
                phases.push(AwakePhase { wakeup: at, up: at, down: trace.end, asleep: trace.end });
                is_open = true;
            }
            (Mode::Awake, Some(phase)) if phase.up == phase.wakeup => phase.up = at,
            (Mode::ShuttingDown, Some(phase)) => phase.down = at,
            (Mode::Asleep, Some(phase)) => {
                phase.down = phase.down.min(at);
                phase.asleep = at;
                is_open = false;
            }
            _ => {}
        }
    }
    phases
}

/// The mode that the first plan was made in, then every change.
fn modes(trace: &Trace) -> impl Iterator<Item = (Time, Mode)> + '_ {
    let first = trace.entries.iter().find_map(|entry| match &entry.what {
        Happened::Planned { state, .. } => Some((entry.at, state.mode)),
        _ => None,
    });
    let changes = trace.entries.iter().filter_map(|entry| match entry.what {
        Happened::Mode(mode) => Some((entry.at, mode)),
        _ => None,
    });
    first.into_iter().chain(changes)
}

/// What was heated for a run that began then: the last heating of each of its
/// zones, until it began.
pub(super) fn heated_for(trace: &Trace, zones: &[String], start: Time) -> Vec<Stretch> {
    let all = heated(trace);
    let last = zones.iter().filter_map(|zone| {
        let mine = all.iter().filter(|(name, (from, _))| name == zone && *from < start);
        mine.map(|(_, span)| *span).max()
    });
    last.map(|(from, until)| (from, until.min(start))).collect()
}

/// When zones were heated.
fn heated(trace: &Trace) -> Vec<(String, Stretch)> {
    let mut open: Vec<(String, Time)> = Vec::new();
    let mut heated = Vec::new();
    for entry in &trace.entries {
        let Happened::Heater { zone, on } = &entry.what else { continue };
        let place = open.iter().position(|(name, _)| name == zone);
        match (on, place) {
            (true, None) => open.push((zone.clone(), entry.at)),
            (false, Some(place)) => {
                let (name, since) = open.swap_remove(place);
                heated.push((name, (since, entry.at)));
            }
            _ => {}
        }
    }
    heated.extend(open.into_iter().map(|(name, since)| (name, (since, trace.end))));
    heated
}
