//! What the compiler refuses, and how little it is short of what it accepts.
//!
//! Each case in `compile/fail` has a twin of the same name in `compile/pass`
//! that differs from it in one line, is accepted, and runs, assertions included:
//! so nothing but that line can be what the compiler refuses. The line itself
//! says what the compiler has to complain about: after `//~` the error's code,
//! and words that name what is missing or private. The rest of the message is
//! the compiler's own affair, and may change with it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

#[test]
fn twins_differ_in_one_line() {
    for case in Case::all() {
        let differences = case.differences();
        assert_eq!(differences.len(), 1, "{}: {differences:#?}", case.name);
        assert!(case.expected().is_some(), "{}: its line says what to expect", case.name);
    }
}

#[test]
fn each_case_is_refused_for_what_it_lacks_and_its_twin_runs() {
    let cases = Case::all();
    let package = Package::with(&cases);
    let complaints: Vec<String> = cases.iter().flat_map(|case| package.judge(case)).collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// Two programs with the same name: one to be refused, one to run.
struct Case {
    name: String,
    fail: String,
    pass: String,
}

/// What the compiler has to say about a case.
struct Expected<'a> {
    code: &'a str,
    words: Vec<&'a str>,
}

impl Case {
    fn all() -> Vec<Self> {
        let names = names_in("fail");
        assert!(!names.is_empty(), "there are cases");
        assert_eq!(names, names_in("pass"), "each case has its twin, and each twin its case");
        names.into_iter().map(Self::read).collect()
    }

    fn read(name: String) -> Self {
        let read = |side| fs::read_to_string(path(side, &name)).expect("the case is readable");
        Self { fail: read("fail"), pass: read("pass"), name }
    }

    /// The lines in which the twins differ; a line that only one of them has is
    /// one.
    fn differences(&self) -> Vec<(Option<&str>, Option<&str>)> {
        let (mut fail, mut pass) = (self.fail.lines(), self.pass.lines());
        let pairs = std::iter::from_fn(|| match (fail.next(), pass.next()) {
            (None, None) => None,
            pair => Some(pair),
        });
        pairs.filter(|(fail, pass)| fail != pass).collect()
    }

    fn expected(&self) -> Option<Expected<'_>> {
        let (Some(line), _) = *self.differences().first()? else { return None };
        let (code, words) = line.split_once("//~ ")?.1.split_once(": ")?;
        Some(Expected { code, words: words.split(", ").collect() })
    }
}

impl Expected<'_> {
    /// Whether this is what the compiler said, and no other error with it.
    fn is_what_was_said(&self, stderr: &str) -> bool {
        let said = without_quotations(stderr);
        let code = format!("error[{}]", self.code);
        let mut errors = said.lines().filter(|line| line.starts_with("error[")).peekable();
        errors.peek().is_some()
            && errors.all(|error| error.starts_with(&code))
            && self.words.iter().all(|word| said.contains(word))
    }
}

/// The compiler's own words. The lines that it quotes begin with their numbers,
/// and contain whatever word the case itself contains.
fn without_quotations(stderr: &str) -> String {
    let own = |line: &&str| !line.trim_start().starts_with(|first: char| first.is_ascii_digit());
    stderr.lines().filter(own).collect::<Vec<_>>().join("\n")
}

/// A package of all cases outside the workspace, which they would break. It
/// takes its dependencies in the versions that the workspace has.
struct Package {
    folder: PathBuf,
}

impl Package {
    fn with(cases: &[Case]) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("compile");
        fs::create_dir_all(&folder).expect("the folder for temporary files is writable");
        let manifest: String = cases.iter().map(binaries).collect();
        fs::write(folder.join("Cargo.toml"), header() + &manifest).expect("the folder is writable");
        let lock = root().join("../Cargo.lock");
        fs::copy(lock, folder.join("Cargo.lock")).expect("the workspace has a lock file");
        Self { folder }
    }

    /// What is wrong with a case.
    fn judge(&self, case: &Case) -> Vec<String> {
        let mut complaints = Vec::new();
        let refused = self.cargo("build", &format!("fail-{}", case.name));
        let stderr = String::from_utf8_lossy(&refused.stderr);
        let as_expected = case.expected().is_some_and(|line| line.is_what_was_said(&stderr));
        if refused.status.success() {
            complaints.push(format!("{}: the compiler accepts it", case.name));
        } else if !as_expected {
            complaints.push(format!("{}: refused for another reason:\n{stderr}", case.name));
        }
        let twin = self.cargo("run", &format!("pass-{}", case.name));
        if !twin.status.success() {
            let stderr = String::from_utf8_lossy(&twin.stderr);
            complaints.push(format!("{}: its twin does not run:\n{stderr}", case.name));
        }
        complaints
    }

    fn cargo(&self, verb: &str, binary: &str) -> Output {
        Command::new(env!("CARGO"))
            .args([verb, "--bin", binary, "--target-dir=target"])
            .args(["--offline", "--quiet", "--color=never"])
            .current_dir(&self.folder)
            .output()
            .expect("cargo starts")
    }
}

/// Twins leave unused what only the refused line needs; that is no finding.
fn header() -> String {
    let (root, bench) = (root(), root().join("tests/compile/bench.rs"));
    format!(
        r#"
[package]
name = "bench"
version = "0.0.0"
edition = "2024"

[workspace]

[lints.rust]
unused = "allow"

[profile.dev]
debug = false

[dependencies]
faregate-agents = {{ path = {root:?} }}
faregate-tickets = {{ path = {tickets:?}, features = ["lock-api"] }}
parking_lot = "0.13"

[lib]
path = {bench:?}
"#,
        tickets = root.join("../tickets"),
    )
}

fn binaries(case: &Case) -> String {
    let binary = |side| {
        let (name, path) = (&case.name, path(side, &case.name));
        format!("\n[[bin]]\nname = \"{side}-{name}\"\npath = {path:?}\n")
    };
    binary("fail") + &binary("pass")
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn folder(side: &str) -> PathBuf {
    root().join("tests/compile").join(side)
}

fn path(side: &str, name: &str) -> PathBuf {
    folder(side).join(name).with_extension("rs")
}

fn names_in(side: &str) -> Vec<String> {
    let files = fs::read_dir(folder(side)).expect("the cases are there");
    let name = |file: &Path| Some(file.file_stem()?.to_str()?.to_owned());
    let mut names: Vec<_> = files.flatten().filter_map(|file| name(&file.path())).collect();
    names.sort();
    names
}
