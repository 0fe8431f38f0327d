//! `plan check`: everything that is wrong with plans, parameters and states.

use faregate_planner::file::{self, Document, Loaded};
use faregate_planner::{Parameters, Plan, State};
use faregate_scheduler::format::Diagnostic;
use serde::Serialize;

use crate::args::{Format, PlanCheckArgs};
use crate::exit::{Exit, Failure};
use crate::plan::{files, mission};
use crate::schedule::Source;
use crate::{out, report};

/// What was found, for programs.
#[derive(Serialize)]
struct Findings<'a> {
    errors: usize,
    warnings: usize,
    files: Vec<File<'a>>,
    diagnostics: &'a [Diagnostic],
}

/// A file, and what it is where it could be read.
#[derive(Serialize)]
struct File<'a> {
    file: &'a str,
    is: Option<&'static str>,
    activities: Option<usize>,
}

pub(crate) fn check(args: &PlanCheckArgs) -> Result<Exit, Failure> {
    let mut sources =
        args.files.iter().map(|path| Source::open(path)).collect::<Result<Vec<_>, _>>()?;
    let mission = args.mission.as_deref().map(Source::open).transpose()?;
    let mut found = Vec::new();
    let parameters = sources.iter().find_map(parameters);
    let documents: Vec<Option<Document>> = (sources.iter())
        .map(|source| match file::read(&source.name, &source.bytes, parameters.as_ref()) {
            Ok(Loaded { value, warnings }) => {
                found.extend(warnings);
                Some(value)
            }
            Err(wrong) => {
                found.extend(wrong);
                None
            }
        })
        .collect();
    if let Some(parameters) = &parameters {
        found.extend(together(&sources, &documents, parameters));
    }
    if let Some(mission) = mission {
        let plans = documents.iter().flatten().filter_map(plan);
        found.extend(mission::fits(parameters.as_ref(), plans, &mission)?);
        // It is shown with the others, and is none of them.
        sources.push(mission);
    }
    let errors = found.iter().filter(|one| one.is_error()).count();
    let warnings = found.len() - errors;
    match args.format {
        Format::Json => {
            let files =
                sources.iter().zip(&documents).map(|(source, is)| told(source, is.as_ref()));
            let files = files.collect();
            out::json(&Findings { errors, warnings, files, diagnostics: &found })?;
        }
        Format::Text => {
            let sources: Vec<_> = sources.into_iter().map(files::shown).collect();
            report::complain(&found, &sources);
            out::line(verdict(errors, warnings, &documents))?;
        }
    }
    if errors == 0 { Ok(Exit::Done) } else { Err(Failure::Said(Exit::Failed)) }
}

/// The parameters in it, if it has some that can be read.
fn parameters(source: &Source) -> Option<Parameters> {
    file::parameters(&source.name, &source.bytes).ok().map(|loaded| loaded.value)
}

/// Each plan with each state.
fn together(
    sources: &[Source],
    documents: &[Option<Document>],
    parameters: &Parameters,
) -> Vec<Diagnostic> {
    let plans = documents.iter().flatten().filter_map(plan);
    let states = || {
        sources
            .iter()
            .zip(documents)
            .filter_map(|(source, one)| Some((source, state(one.as_ref()?)?)))
    };
    plans
        .flat_map(|plan| states().map(move |(source, state)| (plan, source, state)))
        .flat_map(|(plan, source, state)| {
            file::together(plan, parameters, state, (&source.name, &source.bytes))
        })
        .collect()
}

const fn plan(document: &Document) -> Option<&Plan> {
    match document {
        Document::Plan(plan) => Some(plan),
        Document::Parameters(_) | Document::State(_) => None,
    }
}

const fn state(document: &Document) -> Option<&State> {
    match document {
        Document::State(state) => Some(state),
        Document::Parameters(_) | Document::Plan(_) => None,
    }
}

fn told<'a>(source: &'a Source, document: Option<&Document>) -> File<'a> {
    let activities = document.and_then(plan).map(|plan| plan.activities.len());
    File { file: &source.name, is: document.map(Document::what), activities }
}

fn verdict(errors: usize, warnings: usize, documents: &[Option<Document>]) -> String {
    let warned = match warnings {
        0 => String::new(),
        _ => format!(", {}", number(warnings, "warning")),
    };
    if errors > 0 {
        return out::styled(out::BAD, number(errors, "error")) + &warned;
    }
    let what = documents.iter().flatten().map(|document| match plan(document) {
        Some(plan) => format!(
            "a plan of {}",
            match plan.activities.len() {
                1 => "1 activity".to_owned(),
                activities => format!("{activities} activities"),
            }
        ),
        None => document.what().to_owned(),
    });
    let what = what.collect::<Vec<_>>().join(", ");
    out::styled(out::GOOD, "good") + &format!(": {what}{warned}")
}

fn number(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
