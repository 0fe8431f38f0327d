//! Two executives, one manager: what the virtual clock foretells happens on the
//! host's clock, event for event, with real bodies and the tickets of a broker.
//!
//! Each schedule is run by a process of its own, because the program that runs
//! bodies adopts all orphans of its process.
#![cfg(target_os = "linux")]

#[path = "real_time/diary.rs"]
mod diary;
#[path = "support/mod.rs"]
mod support;

use std::collections::VecDeque;
use std::process::{Child, Command, Stdio};

use faregate_scheduler::manager::Note;
use faregate_scheduler::mission::Mission;
use faregate_scheduler::task::{Body, Preemption, Task};
use faregate_scheduler::time::{Duration, Instant};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use diary::Diary;
use support::generate;

/// So many schedules are compared.
const SCHEDULES: usize = 200;
/// So many processes at a time: they mostly wait.
const AT_A_TIME: usize = 6;
/// Everything that happens is so far apart that a host which is less than half
/// of it late cannot mix it up.
const APART: Duration = Duration::from_millis(24);
const UNTIL: Instant = Instant::from_micros(2_000_000);
/// A schedule that did not come out alike is tried so often.
const TRIES: u32 = 6;

/// A host that was late three times has less to do at the next ones.
const fn beside(attempt: u32) -> usize {
    if attempt <= TRIES / 2 { AT_A_TIME } else { 2 }
}

/// The schedules are the same in each run.
const SEED: [u8; 32] = *b"two executives, one step functio";

/// Names the schedule that a child is to run.
const CHILD: &str = "FAREGATE_TEST_SCHEDULE";

type Told = Vec<(Instant, Note)>;

/// What a child told, and how late a thread of it woke at the worst that did
/// nothing else.
type Ran = (Told, Duration);

fn schedules() -> impl Iterator<Item = Vec<Task>> {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &SEED);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let strategy = generate::schedule(5);
    let mission = Mission::default();
    std::iter::repeat_with(move || strategy.new_tree(&mut runner).unwrap().current())
        .map(some_hold)
        .filter(move |tasks| generate::is_clear(tasks, &mission, UNTIL, APART))
}

/// Two in three bodies need no process: the host is the less late. And `sleep`
/// counts the time for which it is stopped, so none is a process that can be
/// paused.
fn some_hold(mut tasks: Vec<Task>) -> Vec<Task> {
    for task in &mut tasks {
        if task.id.get() % 3 != 0 || task.preemption == Preemption::Pause {
            task.body = Body::Hold;
        }
    }
    tasks
}

/// The part of a child: runs one schedule, and prints what the manager told.
#[test]
#[ignore = "the part of a child process"]
fn child() {
    let Ok(number) = std::env::var(CHILD) else { return };
    let tasks = schedules().nth(number.parse().unwrap()).unwrap();
    let told = diary::run(tasks, UNTIL);
    println!("\n{CHILD} {}", serde_json::to_string(&told).unwrap());
}

fn spawn(number: usize) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "child", "--ignored", "--nocapture", "--test-threads=1"]);
    command.env(CHILD, number.to_string()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().unwrap()
}

fn told_by(child: Child) -> Ran {
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix(CHILD));
    let line = line.unwrap_or_else(|| {
        panic!("a child told nothing: {text}{}", String::from_utf8_lossy(&output.stderr))
    });
    serde_json::from_str(line.trim()).unwrap()
}

/// What came of one try.
#[derive(Debug, PartialEq, Eq)]
enum Compared {
    Equal,
    /// They differ from this event on, and the host was in time.
    Differ(usize),
    /// They differ, and the host was too late for the order to mean anything.
    Late,
}

/// What is told of waiting is told when somebody looks: a decision more or less
/// tells it at another one.
fn happened(told: &Told, until: Instant) -> Vec<(Instant, &Note)> {
    let happened = told.iter().filter(|(at, note)| {
        *at < until && !matches!(note, Note::Waits { .. } | Note::Accepted(_))
    });
    happened.map(|(at, note)| (*at, note)).collect()
}

fn compare(foretold: &Told, (real, late): &Ran) -> Compared {
    // What is foretold for the last moment a host may do after it.
    let (foretold, real) = (happened(foretold, before(UNTIL)), happened(real, UNTIL));
    let (mut place, mut rest) = (0, &real[..]);
    // What is foretold for one instant comes in any order.
    for instant in foretold.chunk_by(|one, next| one.0 == next.0) {
        let (now, later) = rest.split_at(instant.len().min(rest.len()));
        if !same(instant, now) {
            let in_time = *late < half(APART);
            return if in_time { Compared::Differ(place) } else { Compared::Late };
        }
        (place, rest) = (place + instant.len(), later);
    }
    Compared::Equal
}

fn same(one: &[(Instant, &Note)], other: &[(Instant, &Note)]) -> bool {
    let sorted = |all: &[(Instant, &Note)]| {
        let mut all: Vec<_> = all.iter().map(|(_, note)| format!("{note:?}")).collect();
        all.sort_unstable();
        all
    };
    sorted(one) == sorted(other)
}

fn lines(told: &Told) -> String {
    let line = |(at, note): &(Instant, Note)| format!("{:>8} {note}\n", at.as_micros() / 1_000);
    told.iter().map(line).collect()
}

fn half(duration: Duration) -> Duration {
    Duration::from_micros(duration.as_micros() / 2)
}

fn before(instant: Instant) -> Instant {
    Instant::from_micros(instant.as_micros() - APART.as_micros())
}

#[test]
fn what_is_foretold_happens_event_for_event() {
    let all: Vec<_> = schedules().take(SCHEDULES).collect();
    let mission = Mission::default();
    let foretold: Vec<_> = all.iter().map(|tasks| generate::told(tasks, &mission, UNTIL)).collect();
    let mut waiting: VecDeque<_> = (0..all.len()).map(|number| (number, 1)).collect();
    let mut running = VecDeque::new();
    let (mut equal, mut events, mut never_in_time) = (0, 0, 0);
    while !(waiting.is_empty() && running.is_empty()) {
        while let Some((number, attempt)) =
            waiting.pop_front_if(|(_, attempt)| running.len() < beside(*attempt))
        {
            running.push_back((number, attempt, spawn(number)));
        }
        let Some((number, attempt, child)) = running.pop_front() else { break };
        let real = told_by(child);
        match compare(&foretold[number], &real) {
            Compared::Equal => {
                equal += 1;
                events += happened(&real.0, UNTIL).len();
            }
            // What the manager does wrong it does wrong each time.
            Compared::Late | Compared::Differ(_) if attempt < TRIES => {
                waiting.push_back((number, attempt + 1));
            }
            Compared::Late => never_in_time += 1,
            Compared::Differ(place) => panic!(
                "schedule {number} differs at event {place}:\n{:?}\nforetold\n{}real\n{}",
                all[number],
                lines(&foretold[number]),
                lines(&real.0),
            ),
        }
    }
    println!(
        "{equal} schedules, {events} events alike; the host was never in time for {never_in_time}"
    );
    assert!(equal >= SCHEDULES * 3 / 4, "the host was in time for {equal} of {SCHEDULES} only");
}

#[test]
fn a_comparison_finds_what_differs() {
    let mission = Mission::default();
    let tasks = schedules().find(|tasks| tasks.len() > 3).unwrap();
    let foretold = generate::told(&tasks, &mission, UNTIL);
    let (mut less, in_time) = (foretold.clone(), Duration::ZERO);
    assert_eq!(compare(&foretold, &(foretold.clone(), in_time)), Compared::Equal);
    let is_start = |(_, note): &(Instant, Note)| matches!(note, Note::Started(_));
    let start = less.iter().position(is_start).unwrap();
    less.remove(start);
    assert!(matches!(compare(&foretold, &(less.clone(), in_time)), Compared::Differ(_)));
    assert_eq!(compare(&foretold, &(less, APART)), Compared::Late);
}

#[test]
fn a_diary_begins_when_the_schedule_is_loaded() {
    let diary = Diary::default();
    assert!(diary.told().is_empty());
}
