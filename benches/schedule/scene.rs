//! Schedules that really run, with a journal, for the rows of time.

use std::path::Path;
use std::sync::{Arc, Mutex};

use faregate_scheduler::bodies::{Moment, Probe, Settings};
use faregate_scheduler::executive::{Correspondent, HostClock, LoadedFile, Outside, Watched};
use faregate_scheduler::manager::{Attempt, Event, Manager, Note, Reply, TelecommandId};
use faregate_scheduler::task::{Body, Task, When, Window};
use faregate_scheduler::time::{Duration, Instant, Now};
use faregate_scheduler::{Mission, Onboard};

use crate::support::Failure;
use crate::world::id;

/// When what happened to which task.
pub(crate) type Moments = Arc<Mutex<Vec<(Moment, u32, Instant)>>>;

/// Writes down when tasks were over.
#[derive(Debug, Default)]
pub(crate) struct Ends {
    pub(crate) loaded: Option<Instant>,
    pub(crate) over: Vec<(u32, Instant)>,
}

impl Outside for Ends {
    fn note(&mut self, now: Now, note: &Note) {
        match note {
            Note::Accepted(_) => self.loaded = self.loaded.or(Some(now.elapsed)),
            Note::Over { attempt, .. } => {
                self.over.push((attempt.occurrence.task.get(), now.elapsed));
            }
            _ => {}
        }
    }

    fn answer(&mut self, _: Now, _: TelecommandId, _: Reply) {}

    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        None
    }
}

impl Watched for Ends {}

impl Correspondent for Ends {
    fn poll(&mut self, _: Now, _: &Manager, _: &mut Vec<Event>) {}
}

/// A program that ends at once, and need not be looked for.
pub(crate) fn brief(number: u32, due: Duration) -> Task {
    let body = Body::Process { program: "/bin/true".into(), arguments: Vec::new() };
    let mut task = Task::new(id(number), body);
    task.windows = vec![Window { opens: When::AfterLoad(due), closes: When::Unrestricted }];
    task
}

/// A directory that goes away, on a disk: where the build is, since `/tmp` may
/// be memory.
pub(crate) fn place() -> Result<tempfile::TempDir, Failure> {
    let directory = crate::support::directory();
    let target = directory.parent().ok_or("no target directory")?;
    std::fs::create_dir_all(target)?;
    Ok(tempfile::tempdir_in(target)?)
}

/// A manager whose journal is in this directory, and what is seen of its forks.
pub(crate) fn manager(directory: &Path) -> Result<(Onboard<Ends>, Moments), Failure> {
    let builder = Onboard::builder(Mission::default())?;
    let (moments, clock) = (Moments::default(), builder.clock());
    let settings = Settings { probe: probe(Arc::clone(&moments), clock), ..Settings::default() };
    let builder = builder.bodies(settings).journal(directory)?;
    Ok((builder.start_with(|_, _, _| Ok(Ends::default()))?, moments))
}

fn probe(moments: Moments, clock: HostClock) -> Probe {
    Probe::new(move |moment, attempt: Attempt| {
        let at = clock.now().elapsed;
        if let Ok(mut moments) = moments.lock() {
            moments.push((moment, attempt.occurrence.task.get(), at));
        }
    })
}
