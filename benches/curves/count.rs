//! Counts instructions, by single-stepping a child process of the bench itself.
//!
//! A time on a shared machine says how fast; whether something is *constant*,
//! only a count says. Hardware counters are often not to be had in a virtual
//! machine, and no other tool has to be installed for this.
//!
//! The child brackets each operation with two signals, at which the kernel
//! stops it for its parent. What the brackets themselves take is counted
//! around nothing, and subtracted.

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, ExitCode, Stdio};

use faregate_runtime::realtime::RealTime;
use nix::sys::ptrace::{self, Options};
use nix::sys::signal::{Signal, raise};
use nix::sys::wait::{WaitStatus, waitpid};
use nix::unistd::Pid;

type Failure = Box<dyn Error + Send + Sync>;

/// What tells a process that it is the child.
const ROLE: &str = "count-instructions";
/// What stops the child for its parent. Without one it ends the child.
const BRACKET: Signal = Signal::SIGUSR1;
/// The case that does nothing.
const NOTHING: &str = "nothing";
/// How often a case is counted, unless it says otherwise.
const TIMES: usize = 3;
/// More than this is no operation of ours: something waits or has gone wrong.
const STEPS_MAX: u64 = 20_000_000;

/// An operation to be counted, and what comes before each time.
pub(crate) struct Case {
    name: String,
    times: usize,
    before: Box<dyn FnMut()>,
    run: Box<dyn FnMut()>,
}

impl Case {
    pub(crate) fn new(name: impl Into<String>, run: impl FnMut() + 'static) -> Self {
        let before = Box::new(|| ());
        Self { name: name.into(), times: TIMES, before, run: Box::new(run) }
    }

    /// The same, counted once: a step takes microseconds, and it takes many.
    pub(crate) fn once(self) -> Self {
        self.times(1)
    }

    /// The same, counted so often, where it is not the same each time.
    pub(crate) fn times(mut self, times: usize) -> Self {
        self.times = times;
        self
    }

    /// The same, where something has to be undone or prepared each time.
    pub(crate) fn after(mut self, before: impl FnMut() + 'static) -> Self {
        self.before = Box::new(before);
        self
    }
}

/// How many instructions each case took at most, by the cases' names.
#[derive(Debug)]
pub(crate) struct Counts(BTreeMap<String, u64>);

impl Counts {
    pub(crate) fn of(&self, name: &str) -> Option<u64> {
        self.0.get(name).copied()
    }
}

/// In the child: does what is to be counted, and says how the process ends. In
/// the bench itself: nothing.
pub(crate) fn as_child(cases: impl FnOnce() -> Vec<Case>) -> Option<ExitCode> {
    if std::env::args().nth(1).as_deref() != Some(ROLE) {
        return None;
    }
    let mut cases = cases();
    cases.insert(0, Case::new(NOTHING, || ()));
    // Once before anybody counts: what is first used is looked up then.
    for case in &mut cases {
        perform(case);
        println!("{} {}", case.times, case.name);
    }
    println!();
    Some(perform_traced(&mut cases).map_or_else(refused, |()| ExitCode::SUCCESS))
}

fn refused(errno: nix::Error) -> ExitCode {
    eprintln!("this host permits no process to trace another (ptrace): {errno}");
    ExitCode::FAILURE
}

fn perform(case: &mut Case) {
    (case.before)();
    (case.run)();
}

fn perform_traced(cases: &mut [Case]) -> nix::Result<()> {
    ptrace::traceme()?;
    for case in cases {
        for _ in 0..case.times {
            (case.before)();
            bracketed(&mut *case.run)?;
        }
    }
    Ok(())
}

/// Out of the loop, of which each turn can be compiled to something else.
#[inline(never)]
fn bracketed(run: &mut dyn FnMut()) -> nix::Result<()> {
    raise(BRACKET)?;
    run();
    raise(BRACKET)
}

/// Starts the child and counts its instructions.
///
/// On a thread of its own, which shares a CPU with the child: it sleeps while
/// the child takes a step, and the other way round.
pub(crate) fn count() -> Result<Counts, Failure> {
    let counting = std::thread::spawn(|| {
        let report = RealTime::request().cpu(0).apply();
        report.refusals().for_each(|refusal| eprintln!("counting will be slow: {refusal}"));
        count_here()
    });
    counting.join().unwrap_or_else(|_| Err("the thread that counts has panicked".into()))
}

fn count_here() -> Result<Counts, Failure> {
    let mut child = Command::new(std::env::current_exe()?)
        .arg(ROLE)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()?;
    let counted = count_in(&mut child);
    // Both fail where the child has ended and been waited for already.
    let _ = (child.kill(), child.wait());
    counted
}

fn count_in(child: &mut Child) -> Result<Counts, Failure> {
    let names = names(child)?;
    let tracee = Tracee(Pid::from_raw(i32::try_from(child.id())?));
    let mut counted = Vec::new();
    for (times, name) in names {
        let mut steps = Vec::new();
        for _ in 0..times {
            tracee.run_to_bracket(&name)?;
            // Its parent's death is to be its own.
            ptrace::setoptions(tracee.0, Options::PTRACE_O_EXITKILL)?;
            steps.push(tracee.count_to_bracket(&name)?);
            ptrace::cont(tracee.0, None)?;
        }
        let ends = steps.iter().min().zip(steps.iter().max());
        counted.extend(ends.map(|(least, most)| (name, (*least, *most))));
    }
    without_brackets(counted)
}

/// How often what is counted, as the child says.
fn names(child: &mut Child) -> Result<Vec<(usize, String)>, Failure> {
    let output = child.stdout.take().ok_or("the child has no output")?;
    let mut names = Vec::new();
    for line in BufReader::new(output).lines() {
        let line = line?;
        let Some((times, name)) = line.split_once(' ') else { break };
        names.push((times.parse()?, name.to_owned()));
    }
    Ok(names)
}

fn without_brackets(counted: Vec<(String, (u64, u64))>) -> Result<Counts, Failure> {
    let brackets = counted.iter().find(|(name, _)| name == NOTHING).map(|(_, steps)| *steps);
    match brackets {
        Some((least, most)) if least == most => {
            let counts = counted.into_iter();
            let own = counts.map(|(name, (_, steps))| (name, steps.saturating_sub(most)));
            Ok(Counts(own.collect()))
        }
        other => Err(format!("nothing does not always take the same: {other:?}").into()),
    }
}

/// The child, stopped or running.
struct Tracee(Pid);

impl Tracee {
    /// Waits until the child, which runs, comes to its next bracket.
    fn run_to_bracket(&self, case: &str) -> Result<(), Failure> {
        match waitpid(self.0, None)? {
            WaitStatus::Stopped(_, BRACKET) => Ok(()),
            other => Err(format!("before {case}: {other:?}").into()),
        }
    }

    /// Steps the child, which stands at a bracket, to the next one.
    fn count_to_bracket(&self, case: &str) -> Result<u64, Failure> {
        for steps in 0..STEPS_MAX {
            ptrace::step(self.0, None)?;
            match waitpid(self.0, None)? {
                WaitStatus::Stopped(_, Signal::SIGTRAP) => {}
                WaitStatus::Stopped(_, BRACKET) => return Ok(steps),
                other => return Err(format!("in {case}: {other:?}").into()),
            }
        }
        Err(format!("{case} does not end within {STEPS_MAX} instructions").into())
    }
}
