//! Calls the program as a person would.

#[cfg(target_os = "linux")]
pub(crate) mod run;

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// The program, with nothing of the host's environment that would change what
/// it says.
pub(crate) fn faregate() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_faregate"));
    command.env_remove("FAREGATE_SOCKET").env_remove("FAREGATE_PORT").env("XDG_RUNTIME_DIR", "");
    command.stdin(Stdio::null());
    command
}

/// What came of a call.
#[derive(Debug)]
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the program writes UTF-8");
        let code = output.status.code().expect("the program exits, and dies of no signal");
        Self { code, out: text(output.stdout), err: text(output.stderr) }
    }
}

impl Said {
    /// The document on standard output.
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error} in: {self:?}"))
    }

    /// The documents on standard output, one on each line.
    pub(crate) fn json_lines(&self) -> Vec<serde_json::Value> {
        self.out.lines().map(|line| serde_json::from_str(line).expect("a document")).collect()
    }
}

/// Calls the program with these arguments.
pub(crate) fn call<A: AsRef<OsStr>>(arguments: &[A]) -> Said {
    faregate().args(arguments).output().expect("the program starts").into()
}

/// The same with one of SMAARTE's cases in the place of `{}`.
pub(crate) fn call_on(case: &str, arguments: &[&str]) -> Said {
    let path = case_file(case);
    let arguments: Vec<&OsStr> = arguments
        .iter()
        .map(|argument| if *argument == "{}" { path.as_os_str() } else { OsStr::new(argument) })
        .collect();
    call(&arguments)
}

/// A file with a known result.
pub(crate) fn case_file(name: &str) -> PathBuf {
    root().join("scheduler/tests/cases").join(name)
}

/// The project.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crate is in the project")
}

/// A file that goes away.
pub(crate) struct Scratch {
    directory: tempfile::TempDir,
}

impl Scratch {
    pub(crate) fn new() -> Self {
        Self { directory: tempfile::tempdir().expect("a directory") }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    pub(crate) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        let mut file = std::fs::File::create(&path).expect("a file");
        file.write_all(content.as_ref()).expect("it is written");
        path
    }
}
