//! A run in real time, and its operator.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{Said, Scratch, faregate};

/// How long anything may take that must come: a slow machine takes its time.
const PATIENCE: Duration = Duration::from_secs(60);

/// A run with a control socket.
pub(crate) struct Run {
    pub(crate) child: Child,
    lines: BufReader<ChildStdout>,
    seen: Vec<String>,
    pub(crate) socket: PathBuf,
}

impl Run {
    /// Of [`MISSION`] and these tasks.
    pub(crate) fn of(scratch: &Scratch, tasks: &str) -> Self {
        let mission = scratch.file("mission.toml", format!("{MISSION}{tasks}"));
        Self::start(scratch, &[mission.to_str().unwrap()])
    }

    pub(crate) fn start(scratch: &Scratch, words: &[&str]) -> Self {
        let socket = scratch.path("faregate.sock");
        let program = Path::new(env!("CARGO_BIN_EXE_faregate")).parent().unwrap();
        // Scripts inside tasks call the program by its name.
        let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
        let mut child = faregate()
            .arg("run")
            .args(words)
            .arg("--socket")
            .arg(&socket)
            .env("PATH", path)
            .current_dir(scratch.path(""))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap());
        let mut run = Self { child, lines, seen: Vec::new(), socket };
        wait_until("the socket is there", || {
            let over = run.child.try_wait().unwrap();
            assert!(over.is_none(), "{:?}", run.ended());
            run.socket.exists()
        });
        run
    }

    /// Calls the program as an operator does.
    pub(crate) fn operate(&self, words: &[&str]) -> Said {
        let output = faregate().args(words).arg("--socket").arg(&self.socket).output().unwrap();
        output.into()
    }

    pub(crate) fn must(&self, words: &[&str]) -> Said {
        let said = self.operate(words);
        assert_eq!(said.code, 0, "{words:?}: {said:?}");
        said
    }

    /// The state of a task, as an operator is told.
    pub(crate) fn state(&self, task: &str) -> Value {
        let said = self.must(&["status", task, "--format", "json"]);
        said.json()["tasks"][0].clone()
    }

    /// Reads lines until one tells this.
    pub(crate) fn until(&mut self, words: &str) -> &str {
        loop {
            let mut line = String::new();
            assert!(self.lines.read_line(&mut line).unwrap() > 0, "no {words} in {:#?}", self.seen);
            let told = line.split_whitespace().collect::<Vec<_>>().join(" ");
            self.seen.push(told);
            let last = self.seen.last().unwrap();
            if last.contains(words) {
                return self.seen.last().unwrap();
            }
        }
    }

    /// Ends it in order.
    pub(crate) fn end(mut self) -> Said {
        self.must(&["shutdown"]);
        self.ended()
    }

    /// What it said, when it has ended by itself.
    pub(crate) fn ended(&mut self) -> Said {
        let mut out = self.seen.join("\n");
        self.lines.read_to_string(&mut out).unwrap();
        let mut err = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        let code = self.child.wait().unwrap().code().expect("it dies of no signal");
        Said { code, out, err }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        // Only where a test has failed: it has ended else.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[expect(clippy::disallowed_methods, reason = "processes of the host take real time")]
pub(crate) fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < PATIENCE, "never: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A mission with a camera, a heater, and a mode that takes the heater.
pub(crate) const MISSION: &str = "
[mission]
name = 'test'
[mission.categories]
camera = 0
[[mission.agent]]
name = 'bus'
supply_w = 20
[[mission.device]]
name = 'camera'
kind = 'camera'
[[mission.device]]
name = 'heater'
kind = 'heater'
[[mission.mode]]
name = 'eclipse'
reserves = ['heater']
floor = 100
";
