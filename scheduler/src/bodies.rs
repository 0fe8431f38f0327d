//! What tasks do, for real: processes, functions, sequences and holds.
//!
//! | part | what |
//! |---|---|
//! | `processes`, `process` | programs, each with everything that it starts |
//! | `family`, `cgroup`, `procfs` | which process belongs to whom |
//! | `launch`, `children`, `sys` | fork, exec, reap |
//! | `output` | what programs print |
//! | `settings` | what can be set |

mod cgroup;
mod children;
mod family;
mod launch;
mod output;
mod process;
mod processes;
mod procfs;
mod run;
mod settings;
mod sys;

pub use output::{Output, Printed};
pub use run::RealBodies;
pub use settings::{Moment, Probe, Settings};
