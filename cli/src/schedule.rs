//! Schedules and their mission, read from files.

use std::path::Path;

use faregate_scheduler::Mission;
use faregate_scheduler::control;
use faregate_scheduler::executive::LoadedFile;
use faregate_scheduler::format::{self, Against, Conflict, Diagnostic, Kind, Options};
use faregate_scheduler::task::Task;

use crate::args::{ConflictColumn, FilesArgs};
use crate::exit::{Exit, Failure};
use crate::{disk, report, simulation};

/// What was read.
#[derive(Debug)]
pub(crate) struct Schedule {
    /// The tasks, in the order of the files.
    pub(crate) tasks: Vec<Task>,
    /// What they run on.
    pub(crate) mission: Mission,
    /// How more files are read.
    pub(crate) loader: Loader,
    names: Vec<String>,
    /// The plan that brings the tasks, where one does.
    plan: Option<String>,
}

/// Reads further files of the same schedule.
#[derive(Clone, Debug)]
pub(crate) struct Loader {
    conflict: Conflict,
    mission: Mission,
}

/// A file's name, as it was given, and what is in it.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) name: String,
    pub(crate) bytes: Vec<u8>,
}

/// What files came to: what was read, and everything there is to say of it.
#[derive(Debug)]
pub(crate) struct Examined {
    /// None, if there was an error.
    pub(crate) schedule: Option<Schedule>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    pub(crate) sources: Vec<Source>,
}

impl From<ConflictColumn> for Conflict {
    fn from(column: ConflictColumn) -> Self {
        match column {
            ConflictColumn::Mask => Self::Mask,
            ConflictColumn::Number => Self::Number,
        }
    }
}

impl Source {
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let bytes = disk::read(path).map_err(Failure::failed)?;
        Ok(Self { name, bytes })
    }

    /// The mission in it, if it has one that can be read.
    pub(crate) fn mission(&self) -> Option<Mission> {
        (Kind::of(&self.name) == Some(Kind::Toml)).then_some(())?;
        format::read(&self.name, &self.bytes).ok()?.mission
    }
}

/// Reads the files; errors are told, and end the program. So are warnings, and
/// do not.
pub(crate) fn read(args: &FilesArgs) -> Result<Schedule, Failure> {
    let Examined { schedule, diagnostics, sources } = examine(args)?;
    report::complain(&diagnostics, &sources);
    schedule.ok_or(Failure::Said(Exit::Failed))
}

/// Reads the files, and gathers everything that is to be said of them.
pub(crate) fn examine(args: &FilesArgs) -> Result<Examined, Failure> {
    let sources =
        args.files.iter().map(|path| Source::open(path)).collect::<Result<Vec<_>, _>>()?;
    let mut examined = Examined { schedule: None, diagnostics: Vec::new(), sources };
    let brought = mission(args, &mut examined)?;
    let conflict = args.conflict.into();
    let files = examined.sources.iter().take(args.files.len());
    let mut read = Vec::new();
    for (index, source) in files.clone().enumerate() {
        let options = Options {
            conflict,
            against: brought.against(index),
            whole: args.files.len() == 1,
            ..Options::default()
        };
        match format::read_with(options, &source.name, &source.bytes) {
            Ok(mut loaded) => {
                examined.diagnostics.append(&mut loaded.warnings);
                read.push((source.name.as_str(), loaded));
            }
            Err(mut wrong) => examined.diagnostics.append(&mut wrong),
        }
    }
    let together: Vec<_> = read.iter().map(|(name, loaded)| (*name, loaded)).collect();
    // What is missed may be in a file that could not be read.
    let whole = read.len() == args.files.len();
    examined.diagnostics.extend(format::together(&together, whole));
    let tasks = read.into_iter().flat_map(|(_, loaded)| loaded.tasks).collect();
    if !examined.diagnostics.iter().any(Diagnostic::is_error) {
        let names = files.map(|source| source.name.clone()).collect();
        let mut mission = brought.mission;
        simulation::complete(&mut mission);
        let loader = Loader { conflict, mission: mission.clone() };
        examined.schedule = Some(Schedule { tasks, mission, loader, names, plan: None });
    }
    Ok(examined)
}

/// The mission, and which file brought it.
struct Brought {
    mission: Mission,
    by: Bringer,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Bringer {
    /// No file: it is the default one.
    Nobody,
    /// One of the schedules. The others are judged against its mission.
    File(usize),
    /// A file of its own.
    Itself,
}

impl Brought {
    /// What a schedule is judged against.
    fn against(&self, index: usize) -> Against<'_> {
        match self.by {
            Bringer::Nobody => Against::Own,
            Bringer::File(owner) if owner == index => Against::Own,
            Bringer::File(_) | Bringer::Itself => Against::Mission(&self.mission),
        }
    }
}

/// Looks for the mission, and judges its devices.
fn mission(args: &FilesArgs, examined: &mut Examined) -> Result<Brought, Failure> {
    let brought = match &args.mission {
        Some(path) => given(path, examined)?,
        None => found(&examined.sources),
    };
    let file = match brought.by {
        Bringer::Nobody => None,
        Bringer::File(owner) => examined.sources.get(owner),
        Bringer::Itself => examined.sources.last(),
    };
    if let Some(file) = file {
        examined.diagnostics.extend(simulation::doubts(&brought.mission, &file.name));
    }
    Ok(brought)
}

/// The mission in one of the schedules.
fn found(sources: &[Source]) -> Brought {
    let missions = sources.iter().enumerate();
    let first = missions.filter_map(|(index, source)| Some((index, source.mission()?))).next();
    match first {
        Some((owner, mission)) => Brought { mission, by: Bringer::File(owner) },
        None => Brought { mission: Mission::default(), by: Bringer::Nobody },
    }
}

/// The mission that was given by itself.
fn given(path: &Path, examined: &mut Examined) -> Result<Brought, Failure> {
    let source = Source::open(path)?;
    let read = format::read(&source.name, &source.bytes);
    let name = source.name.clone();
    examined.sources.push(source);
    let loaded = match read {
        Ok(loaded) => loaded,
        Err(mut wrong) => {
            examined.diagnostics.append(&mut wrong);
            return Ok(Brought { mission: Mission::default(), by: Bringer::Itself });
        }
    };
    examined.diagnostics.extend(loaded.warnings);
    if !loaded.tasks.is_empty() {
        return Err(Failure::failed(format!(
            "{name} has tasks, too: name it among the schedules, without --mission"
        )));
    }
    match loaded.mission {
        Some(mission) => Ok(Brought { mission, by: Bringer::Itself }),
        None => Err(Failure::failed(format!("{name} has no [mission]"))),
    }
}

impl Schedule {
    /// What is shown of it, in a line.
    pub(crate) fn title(&self) -> String {
        let files: Vec<&str> = self.names.iter().map(|name| base(name)).collect();
        match &self.mission.name {
            Some(mission) => format!("{} on {mission}", files.join(", ")),
            None => files.join(", "),
        }
    }

    /// Its tasks are those of a plan of this name.
    pub(crate) fn is_for(&mut self, plan: &str) {
        self.plan = Some(plan.to_owned());
    }

    /// The same with its size.
    pub(crate) fn summary(&self) -> String {
        if let Some(plan) = &self.plan {
            return format!("{plan}: {}", self.title());
        }
        let plural = if self.tasks.len() == 1 { "task" } else { "tasks" };
        format!("{}: {} {plural}", self.title(), self.tasks.len())
    }
}

fn base(name: &str) -> &str {
    Path::new(name).file_name().and_then(|name| name.to_str()).unwrap_or(name)
}

impl Loader {
    /// Reads the tasks of a file that a task loads, or that an operator sends.
    pub(crate) fn read(&self, name: &str, bytes: &[u8]) -> Result<Vec<Task>, Vec<Diagnostic>> {
        let options = Options {
            conflict: self.conflict,
            against: Against::Mission(&self.mission),
            whole: false,
            ..Options::default()
        };
        format::read_with(options, name, bytes).map(|loaded| loaded.tasks)
    }

    /// Reads a file that a task loads.
    pub(crate) fn load(&self, path: &str) -> LoadedFile {
        let text = control::schedule_text(path).map_err(|why| format!("{path}: {why}"))?;
        self.read(path, text.as_bytes()).map_err(|wrong| {
            let errors = wrong.iter().filter(|wrong| wrong.is_error());
            errors.map(ToString::to_string).collect::<Vec<_>>().join("; ")
        })
    }
}
