//! A timed plan for programs.

use std::collections::BTreeMap;

use faregate_planner::plan::Outcome;
use faregate_planner::timed::{Excess, Fate, Projection, Row};
use faregate_planner::units::Time;
use faregate_planner::words::Words;
use serde::{Serialize, Serializer};

use super::Made;

/// The whole of it.
#[derive(Debug, Serialize)]
pub(super) struct Document {
    activities: Vec<Activity>,
    awake: Vec<(Seconds, Seconds)>,
    timelines: BTreeMap<String, Vec<(Seconds, i64)>>,
    violations: Vec<String>,
    excess: Vec<Exceeded>,
    unavoidable: Vec<Exceeded>,
    /// Where it is asked for alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    explanations: Option<BTreeMap<u32, Vec<String>>>,
}

#[derive(Debug, Serialize)]
struct Activity {
    id: u32,
    status: &'static str,
    start_s: Option<Seconds>,
    end_s: Option<Seconds>,
    reason: Option<String>,
}

#[derive(Debug, Serialize)]
struct Exceeded {
    by: Option<u32>,
    limit: String,
    amount: i64,
}

/// Seconds since the origin; a fraction only where there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seconds(Time);

impl Serialize for Seconds {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.get() {
            ms if ms % 1_000 == 0 => serializer.serialize_i64(ms / 1_000),
            ms => serializer.serialize_f64(fraction(ms)),
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "a plan is not 285 000 years long")]
fn fraction(ms: i64) -> f64 {
    ms as f64 / 1_000.0
}

pub(super) fn document(made: &Made) -> Document {
    let words = made.words();
    Document {
        activities: made.timed.rows.iter().map(|row| activity(made, row, &words)).collect(),
        awake: made
            .timed
            .awake
            .iter()
            .map(|phase| (Seconds(phase.wakeup), Seconds(phase.asleep)))
            .collect(),
        timelines: timelines(&made.projection),
        violations: made.violations.clone(),
        excess: exceeded(&made.timed.excess, &words),
        unavoidable: exceeded(&made.timed.unavoidable, &words),
        explanations: made
            .explanations
            .as_ref()
            .map(|all| all.iter().map(|(id, said)| (id.get(), said.clone())).collect()),
    }
}

fn activity(made: &Made, row: &Row, words: &Words<'_>) -> Activity {
    let slot = made.timed.slot(row.id);
    let ended = made.state.ended.iter().find(|ended| ended.id == row.id);
    let past = ended.and_then(|ended| Some((ended.started?, ended.ended)));
    let (start, end) = slot.map(|slot| (slot.start, slot.end)).or(past).unzip();
    let reason = match &row.fate {
        Fate::Out(reason) => Some(words.reason(reason)),
        _ => None,
    };
    Activity {
        id: row.id.get(),
        status: status(&row.fate),
        start_s: start.map(Seconds),
        end_s: end.map(Seconds),
        reason,
    }
}

/// One word.
pub(super) const fn status(fate: &Fate) -> &'static str {
    match fate {
        Fate::Scheduled(_) => "scheduled",
        Fate::Running(_) => "running",
        Fate::Ended(Outcome::Succeeded) => "succeeded",
        Fate::Ended(Outcome::Failed) => "failed",
        Fate::Ended(Outcome::Aborted) => "aborted",
        Fate::Ended(Outcome::NotStarted) => "not_started",
        Fate::Out(_) => "left_out",
    }
}

fn timelines(projection: &Projection) -> BTreeMap<String, Vec<(Seconds, i64)>> {
    let lines = projection.lines.iter();
    lines
        .map(|line| {
            let points = line.points.iter().map(|(at, value)| (Seconds(*at), *value));
            (line.name.clone(), points.collect())
        })
        .collect()
}

fn exceeded(all: &[Excess], words: &Words<'_>) -> Vec<Exceeded> {
    let all = all.iter().map(|one| Exceeded {
        by: one.by.map(|id| id.get()),
        limit: words.limit(&one.limit),
        amount: one.amount,
    });
    all.collect()
}
