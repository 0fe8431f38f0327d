//! A line for each change.

use anstyle::Style;
use faregate_planner::plan::{Kind, Outcome};
use faregate_planner::state::{Mode, Window};
use faregate_planner::trace::{Cause, Entry, Happened, Unstarted, Why};
use faregate_planner::words::{Words, bytes, energy as energy_of, power};
use faregate_planner::{ActivityId, Plan};
use faregate_rehearsal::Setup;

use crate::out::{self, BAD, FAINT, GOOD, ODD};
use crate::plan::why;

/// Says what happened with the names of a plan.
pub(super) struct Lines<'a> {
    plan: &'a Plan,
    words: Words<'a>,
    windows: &'a [Window],
}

impl<'a> Lines<'a> {
    pub(super) fn new(setup: &'a Setup) -> Self {
        let Setup { plan, parameters, state, .. } = setup;
        Self { plan, words: Words::new(plan, parameters), windows: &state.windows }
    }

    /// What there is to say; nothing of what only checkers want to know.
    pub(super) fn line(&mut self, entry: &Entry) -> Option<String> {
        let (style, text) = self.said(&entry.what)?;
        let at = out::styled(FAINT, format_args!("{:>14}", self.words.time(entry.at)));
        Some(format!("{at}  {}", out::styled(style, text)))
    }

    fn said(&self, what: &Happened) -> Option<(Style, String)> {
        let plain = Style::new();
        let name = |id: &ActivityId| self.words.activity(*id);
        Some(match what {
            Happened::Planned { why, .. } => (FAINT, format!("planned: {}", self.whys(why))),
            Happened::Dispatched(one) => {
                let early = if one.early { " early" } else { "" };
                let until = self.words.time(one.ends);
                (GOOD, format!("{} starts{early}, until {until}", name(&one.id)))
            }
            Happened::ToldToEnd(id) => (plain, format!("{} is told to end", name(id))),
            Happened::Ended { id, outcome: Outcome::Succeeded, data } => {
                let data = if data.get() == 0 {
                    String::new()
                } else {
                    format!(": {}", bytes(data.get()))
                };
                (GOOD, format!("{} succeeded{data}", name(id)))
            }
            Happened::Ended { id, .. } => (BAD, format!("{} failed", name(id))),
            Happened::Aborted { id, cause, .. } => {
                (BAD, format!("{} is aborted: {}", name(id), because(*cause)))
            }
            Happened::Paused(id) => {
                (ODD, format!("{} is paused: its tickets were taken", name(id)))
            }
            Happened::Resumed(id) => (plain, format!("{} goes on", name(id))),
            Happened::NotStarted { id, why } => {
                // That nothing has to be cleaned up is no news.
                let activity = self.plan.activities.iter().find(|one| one.id == *id);
                if activity.is_some_and(|one| one.kind == Kind::Cleanup) {
                    return None;
                }
                (ODD, format!("{} did not start: {}", name(id), never(*why)))
            }
            Happened::Heater { zone, on } => {
                (FAINT, format!("heater of zone {zone} {}", if *on { "on" } else { "off" }))
            }
            Happened::Mode(mode) => (plain, mode_name(*mode).to_owned()),
            Happened::Window { index, open } => {
                let name = self.windows.get(*index).map_or("", |window| &window.name);
                let what = if *open { "opens" } else { "closes" };
                (plain, format!("window {} {what}: {name}", index + 1))
            }
            Happened::Variable { name, value: Some(value) } => {
                (plain, format!("{name} is {value}"))
            }
            Happened::Variable { name, value: None } => (plain, format!("{name} is unknown")),
            Happened::HandedOver(_) => (plain, "the next plan takes over".to_owned()),
            Happened::Leak(load) if load.is_zero() => (ODD, "the leak is over".to_owned()),
            Happened::Leak(load) => {
                let load = power(i64::try_from(load.get()).unwrap_or(i64::MAX));
                (ODD, format!("something draws {load} that nobody planned"))
            }
            Happened::Lost(energy) => {
                let energy = i64::try_from(energy.get()).unwrap_or(i64::MAX);
                (ODD, format!("the battery has lost {}", energy_of(energy)))
            }
            Happened::NoNextPlan(why) => (ODD, format!("this plan goes on: {why}")),
            Happened::Requested(_)
            | Happened::Pushed { .. }
            | Happened::Revoked(_)
            | Happened::Safed(_)
            | Happened::Estimate { .. }
            | Happened::Truth(_) => return None,
        })
    }

    fn whys(&self, whys: &[Why]) -> String {
        let all: Vec<_> = whys.iter().map(|one| why(&self.words, *one)).collect();
        all.join(", ")
    }
}

pub(super) const fn because(cause: Cause) -> &'static str {
    match cause {
        Cause::Cutoff => "its cutoff has come",
        Cause::HardLimit => "the charge is at the hard limit",
        Cause::SoftLimit => "it is optional, and the charge is below the soft limit",
        Cause::Duration => "it is optional, and past its duration",
        Cause::ChargeUnknown => "nobody knew the charge any more",
        Cause::TicketsTaken => "its tickets were taken",
        Cause::Ordered => "it was ordered to stop",
    }
}

const fn never(why: Unstarted) -> &'static str {
    match why {
        Unstarted::RangeClosed => "its last start range is over",
        Unstarted::Vetoed => "it was vetoed",
        Unstarted::NotPlanned => "it was not planned",
        Unstarted::HandedOver => "the next plan took over",
    }
}

const fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Asleep => "asleep",
        Mode::WakingUp => "waking up",
        Mode::Awake => "awake",
        Mode::ShuttingDown => "shutting down",
    }
}
