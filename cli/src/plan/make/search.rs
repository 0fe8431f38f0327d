//! The search for a better plan, and for what would let more in. Either may take
//! a while: it shows how far it is after a second, and an interrupt ends the
//! first with what was found by then.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use faregate_planner::explain::explain_all;
use faregate_planner::timed::Fate;
use faregate_planner::words::Words;
use faregate_planner::{
    ActivityId, Budget, Improved, Problem, TimedPlan, Worth, improve, schedule,
};
use indicatif::{ProgressBar, ProgressStyle};
use signal_hook::consts::SIGINT;

use crate::args::PlanMakeArgs;
use crate::exit::Failure;

/// A timed plan, and what the search made of it.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) timed: TimedPlan,
    /// None, where nothing better was looked for.
    pub(super) search: Option<Search>,
}

/// What came of a search.
#[derive(Debug)]
pub(super) struct Search {
    /// What the plan of one pass was worth.
    before: Worth,
    after: Worth,
    rounds: u64,
    evaluations: u64,
    /// Whether it was ended by hand.
    interrupted: bool,
}

/// The plan of one pass, or a better one where that is asked for.
pub(super) fn best(
    problem: &Problem,
    incumbent: Option<&TimedPlan>,
    args: &PlanMakeArgs,
) -> Result<Found, Failure> {
    let timed = schedule(problem, incumbent);
    let Some(evaluations) = args.improve else { return Ok(Found { timed, search: None }) };
    let before = Worth::of(problem, &timed);
    let interrupt = Arc::new(AtomicBool::new(false));
    let heard = signal_hook::flag::register(SIGINT, Arc::clone(&interrupt))
        .map_err(|error| Failure::failed(format!("interrupts cannot be heard: {error}")))?;
    let mut patience = Patience::new(evaluations, "evaluations");
    let budget = Budget { evaluations, seed: args.seed };
    let Improved { timed, worth, evaluations, rounds } =
        improve(problem, incumbent, budget, &mut || {
            patience.step();
            interrupt.load(Ordering::Relaxed)
        });
    patience.bar.finish_and_clear();
    // From here on an interrupt ends the program again.
    signal_hook::low_level::unregister(heard);
    let interrupted = interrupt.load(Ordering::Relaxed);
    let search = Search { before, after: worth, rounds, evaluations, interrupted };
    Ok(Found { timed, search: Some(search) })
}

/// Of each activity that is left out, what would let it in.
pub(super) type Explanations = Vec<(ActivityId, Vec<String>)>;

/// Each limit by itself that would let a left-out activity in at its turn.
pub(super) fn explanations(
    problem: &Problem,
    incumbent: Option<&TimedPlan>,
    timed: &TimedPlan,
    words: &Words<'_>,
) -> Explanations {
    let out = timed.rows.iter().filter(|row| matches!(row.fate, Fate::Out(_)));
    let out: BTreeSet<ActivityId> = out.map(|row| row.id).collect();
    let turns = u64::try_from(problem.order().len()).unwrap_or(u64::MAX);
    let mut patience = Patience::new(turns, "activities");
    let explained = explain_all(problem, incumbent, |id| {
        patience.step();
        out.contains(&id)
    });
    patience.bar.finish_and_clear();
    let said = explained.iter().map(|one| (one.id, words.relaxations(&one.relaxations)));
    said.filter(|(_, said)| !said.is_empty()).collect()
}

impl Search {
    /// In a line.
    pub(super) fn said(&self) -> String {
        let ended = if self.interrupted { "interrupted after" } else { "in" };
        let work = format!("{} rounds, {} evaluations", self.rounds, self.evaluations);
        if self.after == self.before {
            return format!("Nothing better than the one pass was found {ended} {work}.");
        }
        let (before, after) = (&self.before, &self.after);
        let mut better = Vec::new();
        if after.mandatory() != before.mandatory() {
            let counts = (after.mandatory(), before.mandatory());
            better.push(format!("{} instead of {} mandatory activities", counts.0, counts.1));
        }
        if after.optional() != before.optional() {
            let (now, then) = (after.optional(), before.optional());
            better.push(format!("optional activities worth {now} instead of {then}"));
        }
        if better.is_empty() {
            better.push("what counts more, or starts earlier".into());
        }
        format!("Better than the one pass, {ended} {work}: {}.", better.join(", "))
    }
}

/// Shows how far it is, after a second.
struct Patience {
    began: Instant,
    steps: u64,
    of: u64,
    what: &'static str,
    bar: ProgressBar,
}

impl Patience {
    fn new(of: u64, what: &'static str) -> Self {
        Self { began: Instant::now(), steps: 0, of, what, bar: ProgressBar::hidden() }
    }

    fn step(&mut self) {
        self.steps = self.steps.saturating_add(1);
        if self.bar.is_hidden() && self.began.elapsed() > Duration::from_secs(1) {
            self.bar = ProgressBar::new(self.of);
            let template = format!("{{bar:30}} {{pos}} of {{len}} {}, {{eta}} left", self.what);
            if let Ok(style) = ProgressStyle::with_template(&template) {
                self.bar.set_style(style);
            }
        }
        self.bar.set_position(self.steps);
    }
}
