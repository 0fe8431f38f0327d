use std::fs;
use std::path::PathBuf;

use super::{Disagreement, compare, promises};
use crate::rows::Rows;

const SOURCE: &str = "
//! A module.
pub struct Gate;
impl Gate {
    /// # Timing
    /// Constant: one store. A second sentence.
    pub fn shut(&self) {}
    /// # Timing
    /// As [`Gate::shut`].
    pub fn shut_too(&self) {}
    /// # Timing
    /// Not constant: it looks at each.
    pub fn look(&self) {}
    wrapped! {
        /// # Timing
        /// A constant number of loads.
        pub fn new() -> Self { Self }
    }
}
/// # Timing
/// One step for each. The name is a constant.
pub trait Port {
    /// # Timing
    /// Constant.
    fn call(&self);
}
";

fn project(source: &str) -> (tempfile::TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().expect("a folder");
    let src = folder.path().join("src");
    fs::create_dir_all(src.join("inner")).expect("a folder");
    fs::write(folder.path().join("Cargo.toml"), "[package]\nname = \"a-crate\"\n").expect("a file");
    fs::write(src.join("lib.rs"), "//! Nothing here.").expect("a file");
    fs::write(src.join("inner/deep.rs"), source).expect("a file");
    (folder, vec![src])
}

fn rows(items: &str) -> Rows {
    Rows::parse(&format!("[[row]]\nsymbol = \"s\"\nname = \"n\"\nitems = [{items}]")).expect("rows")
}

#[test]
fn every_item_that_says_constant_is_listed() {
    let (_folder, sources) = project(SOURCE);
    let found = promises(&sources).expect("promises");
    let items: Vec<_> = found.iter().map(|promise| &*promise.item).collect();
    assert_eq!(
        items,
        [
            "a_crate::inner::deep::Gate::new",
            "a_crate::inner::deep::Gate::shut",
            "a_crate::inner::deep::Gate::shut_too",
            "a_crate::inner::deep::Port::call",
        ]
    );
}

#[test]
fn an_item_without_a_row_and_a_row_without_an_item_disagree() {
    let (_folder, sources) = project("/// # Timing\n/// Constant.\npub fn shut() {}");
    let found = promises(&sources).expect("promises");
    assert_eq!(compare(&rows("\"a_crate::inner::deep::shut\""), &found), []);
    let disagreements = compare(&rows("\"a_crate::inner::deep::open\""), &found);
    assert!(matches!(
        disagreements.as_slice(),
        [Disagreement::NoRow { .. }, Disagreement::NoPromise { .. }]
    ));
}

#[test]
fn a_section_that_cannot_be_read_is_an_error() {
    let (_folder, sources) =
        project("odd! { =>\n    /// # Timing\n    /// Constant.\n    fn shut() {}\n}");
    let error = promises(&sources).expect_err("a section in a macro");
    assert!(error.to_string().contains("has 1 `# Timing` sections, of which 0"), "{error}");
}
