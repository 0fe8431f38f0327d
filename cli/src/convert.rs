//! `convert`: a schedule in another format.

use faregate_scheduler::Mission;
use faregate_scheduler::format::{self, Against, Kind, NotHeld, Options};
use serde::Serialize;

use crate::args::{ConvertArgs, Format};
use crate::exit::{Exit, Failure};
use crate::schedule::Source;
use crate::{disk, out, report};

/// What became of it, for programs.
#[derive(Serialize)]
struct Converted<'a> {
    written: bool,
    tasks: usize,
    not_held: &'a [NotHeld],
}

pub(crate) fn convert(args: &ConvertArgs) -> Result<Exit, Failure> {
    let Some(kind) = Kind::of(&args.to.to_string_lossy()) else {
        return Err(Failure::Because(
            Exit::Usage,
            format!("{} does not end in .csv, .txt or .toml", args.to.display()),
        ));
    };
    disk::are_two(&args.from, &args.to)?;
    let mission = args.mission.as_deref().map(|path| mission(&Source::open(path)?)).transpose()?;
    let source = Source::open(&args.from)?;
    let options = Options {
        conflict: args.conflict.into(),
        // What a mission lacks does not keep a schedule from being written.
        against: mission.as_ref().map_or(Against::Nothing, Against::Mission),
        ..Options::default()
    };
    let read = format::read_with(options, &source.name, &source.bytes);
    let loaded = match read {
        Ok(loaded) => loaded,
        Err(wrong) => {
            report::complain(&wrong, &[source]);
            return Err(Failure::Said(Exit::Failed));
        }
    };
    let mission = loaded.mission.as_ref().or(mission.as_ref());
    let (text, not_held) = format::write(kind, &loaded.tasks, mission);
    let written = not_held.is_empty() || args.lossy;
    if written {
        disk::write(&args.to, text)?;
    }
    match args.format {
        Format::Json => {
            out::json(&Converted { written, tasks: loaded.tasks.len(), not_held: &not_held })?;
        }
        Format::Text => tell(args, written, loaded.tasks.len(), &not_held)?,
    }
    if written { Ok(Exit::Done) } else { Err(Failure::Said(Exit::Failed)) }
}

fn mission(source: &Source) -> Result<Mission, Failure> {
    source.mission().ok_or_else(|| {
        Failure::failed(format!(
            "{0} has no mission that can be read: see `faregate check {0}`",
            source.name
        ))
    })
}

fn tell(args: &ConvertArgs, written: bool, tasks: usize, lost: &[NotHeld]) -> std::io::Result<()> {
    for one in lost {
        out::complain(format_args!("{}: {one}", out::styled(out::ODD, "not held")));
    }
    let to = args.to.display();
    out::line(match (written, lost.len()) {
        (true, 0) => format!("{to}: {tasks} tasks"),
        (true, lost) => format!("{to}: {tasks} tasks, without the {lost} things above"),
        (false, lost) => {
            format!("{to}: not written; it cannot hold {lost} things. --lossy leaves them out")
        }
    })
}
