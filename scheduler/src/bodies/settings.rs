//! What can be set about bodies.

use core::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use crate::bodies::functions::Functions;
use crate::executive::{Commands, NoDevices, NoPorts, PortFactory};
use crate::manager::Attempt;

/// What can be set about bodies.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Where it is written which run of the manager this is, so that the next
    /// one finds what this one has left; none: nowhere.
    pub state: Option<PathBuf>,
    /// How many bytes are kept of each of an attempt's two outputs.
    pub output_kept: usize,
    /// Of how many attempts that are over the outputs are kept.
    pub outputs_kept: usize,
    /// How many functions and commands of sequences can run at a time. A body
    /// for which there is no worker is not started.
    pub workers: usize,
    /// How many of these workers are there from the beginning.
    pub workers_ready: usize,
    /// How many files a process may have open, until it asks for more itself
    /// (its soft limit); none: as many as this program.
    pub open_files: Option<u64>,
    /// Whether control groups are used where the host permits it.
    pub control_groups: bool,
    /// Called at moments that tests and benches want to see.
    pub probe: Probe,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            state: None,
            output_kept: 64 * 1024,
            outputs_kept: 64,
            workers: 64,
            workers_ready: 2,
            open_files: None,
            control_groups: true,
            probe: Probe::default(),
        }
    }
}

/// What bodies reach, and who reaches them.
pub struct Surroundings {
    /// Processes' way to the manager.
    pub ports: Box<dyn PortFactory>,
    /// What functions and sequences command.
    pub commands: Arc<dyn Commands>,
    /// The functions that tasks can be.
    pub functions: Functions,
}

impl Default for Surroundings {
    /// No ports, no devices, no functions: what a schedule of mere programs
    /// needs.
    fn default() -> Self {
        Self {
            ports: Box::new(NoPorts),
            commands: Arc::new(NoDevices),
            functions: Functions::new(),
        }
    }
}

impl fmt::Debug for Surroundings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Surroundings").field("functions", &self.functions).finish_non_exhaustive()
    }
}

/// A moment in the life of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Moment {
    /// A process is forked next.
    Fork,
    /// It was forked, or could not be.
    Forked,
    /// Nothing of a process lives any more; it is reaped next.
    Reap,
    /// It was reaped, and nobody has heard of its end.
    Reaped,
    /// A function is entered next, by its worker.
    Enter,
}

/// Who is told of moments: nobody, or a function. It runs in the thread
/// concerned, which waits for it.
#[derive(Clone, Default)]
pub struct Probe(Option<Arc<dyn Fn(Moment, Attempt) + Send + Sync>>);

impl Probe {
    /// Calls `probe` at each moment.
    #[must_use]
    pub fn new(probe: impl Fn(Moment, Attempt) + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(probe)))
    }

    pub(super) fn passes(&self, moment: Moment, attempt: Attempt) {
        if let Some(probe) = &self.0 {
            probe(moment, attempt);
        }
    }
}

impl fmt::Debug for Probe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Probe(a function)" } else { "Probe(nobody)" })
    }
}
