//! What an execution leaves for the ground, as files: what was planned, from
//! what and why, and what happened.
//!
//! | file | what |
//! |---|---|
//! | `versions.json` | of the program and of the forms; checksums of plan and parameters |
//! | `parameters.xml` | the parameters |
//! | `plan.xml` | the plan; `plan-2.xml` is the one that took over, and so on |
//! | `rounds.json` | each timed plan: when and why it was made, and for which plan |
//! | `0001/state.xml` | what the first timed plan was made from |
//! | `0001/schedule.json` | the timed plan |
//! | `0001/schedule.txt` | the same in words: when each activity runs, or why it does not |
//! | `0001/timelines.json` | what every timeline will be, if all goes as planned |
//! | `happened.json` | everything that happened |
//!
//! All of it can be read again: XML as plans, parameters and states are, the
//! rest as JSON of [`TimedPlan`], [`Projection`](crate::timed::Projection) and
//! [`Trace`].

use core::fmt;

use serde::Serialize;

use crate::file::{self, Document, binary};
use crate::parameters::Parameters;
use crate::plan::Plan;
use crate::project::project;
use crate::state::State;
use crate::timed::{Fate, Row, TimedPlan};
use crate::timeline::UnknownTimeline;
use crate::trace::{Happened, Trace, Why};
use crate::units::Time;
use crate::words::{Words, became};

/// The version of all of these files together.
pub const VERSION: u16 = 1;

/// A file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Product {
    /// Its path, with `/`, below the folder of the execution.
    pub name: String,
    /// What is in it.
    pub content: String,
}

/// Why there are no products.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoProducts {
    /// A plan names a timeline that the parameters have not got.
    Timeline(UnknownTimeline),
    /// This cannot be said in JSON.
    Json(String),
}

impl fmt::Display for NoProducts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Timeline(unknown) => unknown.fmt(f),
            Self::Json(why) => write!(f, "this cannot be said in JSON: {why}"),
        }
    }
}

impl core::error::Error for NoProducts {}

/// The products of an execution of this plan. `program` says who executed it,
/// with its version.
///
/// # Errors
///
/// [`NoProducts`], where the trace is none of this plan and these parameters.
pub fn of(
    plan: &Plan,
    parameters: &Parameters,
    trace: &Trace,
    program: &str,
) -> Result<Vec<Product>, NoProducts> {
    let mut products = Products { parameters, plans: Vec::new(), rounds: Vec::new(), all: vec![] };
    products.xml("parameters.xml", &Document::Parameters(parameters.clone()));
    products.takes_over(plan);
    for entry in &trace.entries {
        match &entry.what {
            Happened::Planned { why, state, timed } => {
                products.round(entry.at, why, state, timed)?;
            }
            Happened::HandedOver(next) => products.takes_over(next),
            _ => {}
        }
    }
    products.json("happened.json", trace)?;
    products.end(program)
}

/// A timed plan was made.
#[derive(Debug, Serialize)]
struct Round {
    folder: String,
    at: Time,
    why: Vec<Why>,
    plan: String,
}

/// What somebody needs to know before reading the rest.
#[derive(Debug, Serialize)]
struct Versions<'a> {
    program: &'a str,
    planner: &'a str,
    products: u16,
    files: u16,
    checksums: Vec<(String, String)>,
}

/// As far as they are made.
struct Products<'a> {
    parameters: &'a Parameters,
    /// By the names of their files; the last one is executed.
    plans: Vec<(String, Plan)>,
    rounds: Vec<Round>,
    all: Vec<Product>,
}

impl Products<'_> {
    fn add(&mut self, name: impl Into<String>, content: String) {
        self.all.push(Product { name: name.into(), content });
    }

    fn xml(&mut self, name: &str, document: &Document) {
        self.add(name, file::to_xml(document, Some(self.parameters)));
    }

    fn json(&mut self, name: &str, value: &impl Serialize) -> Result<(), NoProducts> {
        let text = serde_json::to_string(value);
        let text = text.map_err(|error| NoProducts::Json(error.to_string()))?;
        self.add(name, format!("{text}\n"));
        Ok(())
    }

    fn takes_over(&mut self, plan: &Plan) {
        let name = match self.plans.len() {
            0 => "plan.xml".to_owned(),
            before => format!("plan-{}.xml", before + 1),
        };
        self.xml(&name, &Document::Plan(plan.clone()));
        self.plans.push((name, plan.clone()));
    }

    fn round(
        &mut self,
        at: Time,
        why: &[Why],
        state: &State,
        timed: &TimedPlan,
    ) -> Result<(), NoProducts> {
        let Some((name, plan)) = self.plans.last().cloned() else { return Ok(()) };
        let folder = format!("{:04}", self.rounds.len() + 1);
        self.xml(&format!("{folder}/state.xml"), &Document::State(state.clone()));
        self.json(&format!("{folder}/schedule.json"), timed)?;
        let said = said(&plan, self.parameters, timed);
        self.add(format!("{folder}/schedule.txt"), said);
        let projection = project(&plan, self.parameters, state, timed);
        let projection = projection.map_err(NoProducts::Timeline)?;
        self.json(&format!("{folder}/timelines.json"), &projection)?;
        self.rounds.push(Round { folder, at, why: why.to_vec(), plan: name });
        Ok(())
    }

    fn end(mut self, program: &str) -> Result<Vec<Product>, NoProducts> {
        let rounds = core::mem::take(&mut self.rounds);
        self.json("rounds.json", &rounds)?;
        let plans = self.plans.iter().map(|(name, plan)| (name.clone(), checksum(plan)));
        let parameters = ("parameters.xml".to_owned(), checksum(self.parameters));
        let checksums = core::iter::once(parameters).chain(plans).collect();
        let planner = env!("CARGO_PKG_VERSION");
        let (products, files) = (VERSION, file::VERSION);
        self.json("versions.json", &Versions { program, planner, products, files, checksums })?;
        self.all.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(self.all)
    }
}

/// The one at the end of the compact form, so that a file on board can be told.
fn checksum(value: &impl binary::Compact) -> String {
    let compact = binary::write(value);
    let sum = compact.last_chunk().copied().map_or(0, u32::from_le_bytes);
    format!("{sum:08x}")
}

/// A line for each activity, for each time in which the computer is up or a
/// zone is heated, and for each limit that is exceeded.
fn said(plan: &Plan, parameters: &Parameters, timed: &TimedPlan) -> String {
    let words = Words::new(plan, parameters);
    let between = |from, to| format!("{} to {}", words.time(from), words.time(to));
    let rows = timed.rows.iter().map(|row| activity(&words, row));
    let awake = timed.awake.iter();
    let awake = awake.map(|phase| format!("awake: {}", between(phase.wakeup, phase.asleep)));
    let heats = timed.preheats.iter();
    let heats = heats.map(|it| format!("heating of {}: {}", it.zone, between(it.start, it.end)));
    let excess = timed.excess.iter().map(|it| format!("exceeded: {}", words.excess(it)));
    let given = timed.unavoidable.iter().map(|it| format!("unavoidable: {}", words.excess(it)));
    let lines = rows.chain(awake).chain(heats).chain(excess).chain(given);
    lines.map(|line| line + "\n").collect()
}

fn activity(words: &Words<'_>, row: &Row) -> String {
    let fate = match &row.fate {
        Fate::Scheduled(slot) => {
            format!("{} to {}", words.time(slot.start), words.time(slot.end))
        }
        Fate::Running(slot) => {
            format!("runs, {} to {}", words.time(slot.start), words.time(slot.end))
        }
        Fate::Ended(outcome) => became(*outcome).to_owned(),
        Fate::Out(reason) => format!("left out: {}", words.reason(reason)),
    };
    format!("{} {}: {fate}", row.id.get(), words.activity(row.id))
}
