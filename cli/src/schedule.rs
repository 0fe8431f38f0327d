//! Schedules and their mission, read from files.

use std::fs;
use std::path::Path;

use faregate_scheduler::Mission;
use faregate_scheduler::executive::LoadedFile;
use faregate_scheduler::format::{self, Against, Conflict, Diagnostic, Kind, Options};
use faregate_scheduler::task::Task;

use crate::args::{ConflictColumn, FilesArgs};
use crate::exit::{Exit, Failure};
use crate::report;

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
}

/// Reads further files of the same schedule.
#[derive(Clone, Debug)]
pub(crate) struct Loader {
    conflict: Conflict,
    mission: Mission,
}

/// A file's name, as it was given, and what is in it.
#[derive(Debug)]
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
        match fs::read(path) {
            Ok(bytes) => Ok(Self { name, bytes }),
            Err(error) => Err(Failure::failed(format!("{name} cannot be read: {error}"))),
        }
    }

    /// The mission in it, if it has one that can be read.
    fn mission(&self) -> Option<Mission> {
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
    let mut sources =
        args.files.iter().map(|path| Source::open(path)).collect::<Result<Vec<_>, _>>()?;
    let (given, mut diagnostics) = match &args.mission {
        Some(path) => given(path, &mut sources)?,
        None => (None, Vec::new()),
    };
    // The mission may be in one of several files; the others are then judged
    // against it.
    let files = args.files.len();
    let owner =
        if given.is_some() { None } else { sources.iter().position(|it| it.mission().is_some()) };
    let found = owner.and_then(|owner| sources.get(owner)?.mission());
    let mission = given.or(found).unwrap_or_default();
    let mut tasks = Vec::new();
    for (index, source) in sources.iter().take(files).enumerate() {
        let against = if owner == Some(index) { Against::Own } else { Against::Mission(&mission) };
        let options = Options {
            conflict: args.conflict.into(),
            against: if args.mission.is_none() && owner.is_none() { Against::Own } else { against },
            whole: files == 1,
            ..Options::default()
        };
        match format::read_with(options, &source.name, &source.bytes) {
            Ok(mut loaded) => {
                diagnostics.append(&mut loaded.warnings);
                tasks.append(&mut loaded.tasks);
            }
            Err(mut wrong) => diagnostics.append(&mut wrong),
        }
    }
    let failed = diagnostics.iter().any(Diagnostic::is_error);
    let schedule = (!failed).then(|| Schedule {
        tasks,
        loader: Loader { conflict: args.conflict.into(), mission: mission.clone() },
        mission,
        names: sources.iter().take(files).map(|source| source.name.clone()).collect(),
    });
    Ok(Examined { schedule, diagnostics, sources })
}

/// The mission that was given by itself.
fn given(
    path: &Path,
    sources: &mut Vec<Source>,
) -> Result<(Option<Mission>, Vec<Diagnostic>), Failure> {
    let source = Source::open(path)?;
    let read = format::read(&source.name, &source.bytes);
    let read = match read {
        Ok(loaded) if loaded.mission.is_none() => {
            return Err(Failure::failed(format!("{} has no [mission]", source.name)));
        }
        Ok(loaded) if !loaded.tasks.is_empty() => {
            return Err(Failure::failed(format!(
                "{} has tasks, too: name it among the schedules, without --mission",
                source.name
            )));
        }
        Ok(loaded) => (loaded.mission, loaded.warnings),
        Err(wrong) => (Some(Mission::default()), wrong),
    };
    sources.push(source);
    Ok(read)
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

    /// The same with its size.
    pub(crate) fn summary(&self) -> String {
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
        let bytes = fs::read(path).map_err(|error| format!("{path} cannot be read: {error}"))?;
        self.read(path, &bytes).map_err(|wrong| {
            let errors = wrong.iter().filter(|wrong| wrong.is_error());
            errors.map(ToString::to_string).collect::<Vec<_>>().join("; ")
        })
    }
}
