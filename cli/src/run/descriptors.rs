//! How many files a run may have open: each attempt takes some.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Lets this program have as many files open as the host allows it. Answers how
/// many it could have before: what its tasks get, since programs that close all
/// that could be open, or that call `select`, mind the larger number.
///
/// Where the host refuses, the run goes on with what it has: an attempt for
/// which there is no descriptor fails and says so.
pub(super) fn raise() -> Option<u64> {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let _ = setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum });
    current
}
