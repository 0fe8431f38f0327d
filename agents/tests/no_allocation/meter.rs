//! Measures operations, each on a thread of its own: so each is its thread's
//! first, and what a thread-local allocates at its first use is seen.

use std::collections::BTreeSet;
use std::thread;

/// What was measured.
#[derive(Default)]
pub(crate) struct Meter(BTreeSet<&'static str>);

impl Meter {
    /// Runs an operation on a fresh thread, which must not call the allocator.
    /// `names` are the public methods that it is a measurement of, as
    /// `file::method`.
    pub(crate) fn op<R: Send>(
        &mut self,
        names: &[&'static str],
        operation: impl FnOnce() -> R + Send,
    ) -> R {
        self.0.extend(names);
        let (result, calls) = counted(operation);
        assert_eq!(calls, 0, "{names:?} calls the allocator");
        result
    }

    /// Fails for a public method of these source files that was not measured,
    /// and for a measured one that is not there.
    pub(crate) fn assert_complete(&self, sources: &[&str], exempt: &[&'static str]) {
        let methods: BTreeSet<String> = sources.iter().flat_map(|path| methods(path)).collect();
        assert!(!methods.is_empty());
        let known: BTreeSet<String> =
            self.0.iter().chain(exempt).map(|name| (*name).to_owned()).collect();
        let missing: Vec<_> = methods.difference(&known).collect();
        assert!(missing.is_empty(), "not measured: {missing:?}");
        let gone: Vec<_> = known.difference(&methods).collect();
        assert!(gone.is_empty(), "measured, and no public method: {gone:?}");
    }
}

/// What an operation answers on a fresh thread, and how often it called the
/// allocator.
pub(crate) fn counted<R: Send>(operation: impl FnOnce() -> R + Send) -> (R, usize) {
    thread::scope(|scope| {
        let thread = scope.spawn(|| {
            let before = crate::sys::calls();
            let result = operation();
            let calls = crate::sys::calls() - before;
            (result, calls)
        });
        thread.join().expect("the operation comes to its end")
    })
}

/// The public methods of a source file, as `file::method`.
fn methods(path: &str) -> Vec<String> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../");
    let text = std::fs::read_to_string(format!("{root}{path}")).expect("the source file is there");
    let file = path.rsplit('/').next().and_then(|name| name.strip_suffix(".rs"));
    let file = file.expect("a source file");
    text.lines()
        .filter_map(|line| {
            let line = line.strip_prefix("    ")?.trim_start();
            let line = line.strip_prefix("pub ")?;
            let line = line.strip_prefix("const ").unwrap_or(line).strip_prefix("fn ")?;
            let name = line.split(['(', '<']).next()?;
            Some(format!("{file}::{name}"))
        })
        .collect()
}
