//! The driver that all executives share, and the virtual one.

mod support;

use std::io;
use std::sync::{Arc, Mutex};

use faregate_scheduler::executive::{
    Conduct, JournalSink, LoadedFile, Outside, Stuck, VirtualBodies, VirtualExecutive,
};
use faregate_scheduler::manager::{
    Addition, Attempt, Event, Exit, Note, Record, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::mission::Mission;
use faregate_scheduler::task::{Body, BuiltIn, Outcome, Task};
use faregate_scheduler::time::{Duration, Instant, Now, UnixTime};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

use support::generate::{UNIT, is_clear, schedule, told};
use support::{Told, due, id, s, task};

fn add(tasks: Vec<Task>) -> Event {
    let additions = tasks.into_iter().map(|task| Addition { task }).collect();
    Event::Telecommand { id: TelecommandId(0), telecommand: Telecommand::Add(additions) }
}

fn executive(tasks: Vec<Task>, bodies: VirtualBodies) -> VirtualExecutive<Told> {
    let at = UnixTime::from_secs(1_000);
    let mut executive = VirtualExecutive::new(Mission::default(), at, bodies, Told::default());
    executive.tell(add(tasks));
    executive
}

const fn at(seconds: u64) -> Instant {
    Instant::from_micros(seconds * 1_000_000)
}

#[test]
fn the_clock_jumps_to_what_is_due_next_and_the_time_of_day_with_it() {
    let mut executive = executive(vec![due(task(1, 5, 1, 1), 9)], VirtualBodies::as_expected());
    executive.advance_to(Instant::START).unwrap();
    assert_eq!(executive.next_due(), Some(at(9)));
    executive.advance_to(at(10)).unwrap();
    assert_eq!(executive.next_due(), Some(at(14)));
    assert_eq!(executive.now(), Now { elapsed: at(10), wall: UnixTime::from_secs(1_010) });
    executive.advance_to(at(20)).unwrap();
    assert_eq!(executive.next_due(), None);
    assert!(executive.manager().is_over());
}

#[test]
fn a_body_ends_as_its_script_says() {
    let bodies = VirtualBodies::new(|_, _| Conduct { takes: s(2), exit: Exit::Code(3) });
    let mut executive = executive(vec![task(1, 5, 1, 1)], bodies);
    executive.advance_to(at(10)).unwrap();
    let over = executive.into_outside().notes.into_iter().find_map(|(at, note)| match note {
        Note::Over { exit, outcome, .. } => Some((at, exit, outcome)),
        _ => None,
    });
    assert_eq!(over, Some((at(2), Exit::Code(3), Outcome::Failed)));
}

/// What was written, until it is full.
#[derive(Clone, Debug, Default)]
struct Paper {
    written: Arc<Mutex<Vec<Record>>>,
    room: usize,
}

impl JournalSink for Paper {
    fn append(&mut self, record: &Record) -> io::Result<()> {
        let mut written = self.written.lock().unwrap();
        if written.len() == self.room {
            return Err(io::Error::other("the paper is full"));
        }
        written.push(record.clone());
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Wherever the journal fails, no attempt starts that it does not know.
#[test]
fn what_is_not_in_the_journal_does_not_happen() {
    let run = |room| {
        let paper = Paper { room, ..Paper::default() };
        let started: Arc<Mutex<Vec<Attempt>>> = Arc::default();
        let starts = Arc::clone(&started);
        let bodies = VirtualBodies::new(move |attempt, _| {
            starts.lock().unwrap().push(attempt);
            Conduct::succeeds_after(s(1))
        });
        let (mission, outside) = (Mission::default(), Told::default());
        let mut executive = VirtualExecutive::with_journal(
            mission,
            UnixTime::default(),
            bodies,
            outside,
            paper.clone(),
        );
        executive.tell(add(vec![task(1, 5, 1, 1), task(2, 5, 1, 2)]));
        let ran = executive.advance_to(at(100));
        let started = started.lock().unwrap().clone();
        let written = paper.written.lock().unwrap().clone();
        (ran, started, written)
    };
    let (ran, started, written) = run(usize::MAX);
    assert!(ran.is_ok());
    assert_eq!(started.len(), 2);
    for room in 0..written.len() {
        let (ran, started, written) = run(room);
        assert!(matches!(ran, Err(Stuck::Journal(_))), "{room}: {ran:?}");
        for attempt in started {
            assert!(written.contains(&Record::Starting { attempt }), "{room}: {attempt}");
        }
    }
}

/// Knows one file, and tells of it later.
#[derive(Debug, Default)]
struct Library {
    told: Told,
    answers: Vec<Reply>,
}

impl Outside for Library {
    fn note(&mut self, now: Now, note: &Note) {
        self.told.note(now, note);
    }

    fn answer(&mut self, _: Now, _: TelecommandId, reply: Reply) {
        self.answers.push(reply);
    }

    fn load(&mut self, _: Attempt, path: &str) -> Option<LoadedFile> {
        Some(match path {
            "good" => Ok(vec![task(7, 3, 1, 1)]),
            "twice" => Ok(vec![task(1, 3, 1, 1)]),
            _ => Err("no such file".into()),
        })
    }
}

fn loading(path: &str) -> (Vec<(Instant, Note)>, Vec<Reply>) {
    let outside = Library::default();
    let bodies = VirtualBodies::as_expected();
    let mut executive =
        VirtualExecutive::new(Mission::default(), UnixTime::default(), bodies, outside);
    let load = Task::new(id(1), Body::BuiltIn(BuiltIn::Load(path.into())));
    executive.tell(add(vec![due(load, 10)]));
    executive.advance_to(at(100)).unwrap();
    let library = executive.into_outside();
    (library.told.notes, library.answers)
}

fn outcome_of_load(notes: &[(Instant, Note)]) -> Option<(Instant, Outcome)> {
    notes.iter().find_map(|(at, note)| match note {
        Note::Over { attempt, outcome, .. } if attempt.occurrence.task == id(1) => {
            Some((*at, *outcome))
        }
        _ => None,
    })
}

#[test]
fn a_file_that_is_loaded_in_flight_is_one_event_and_ends_the_task_that_loads_it() {
    let (notes, answers) = loading("good");
    assert_eq!(outcome_of_load(&notes), Some((at(10), Outcome::Succeeded)));
    assert!(notes.contains(&(at(10), Note::Accepted(id(7)))), "{notes:?}");
    // The one from outside; that of the file is the driver's own.
    assert_eq!(answers, [Reply::Done]);
}

#[test]
fn a_file_that_cannot_be_loaded_fails_the_task_and_changes_nothing() {
    for path in ["missing", "twice"] {
        let (notes, answers) = loading(path);
        assert_eq!(outcome_of_load(&notes), Some((at(10), Outcome::Failed)), "{path}");
        let accepted = notes.iter().filter(|(_, note)| matches!(note, Note::Accepted(_)));
        assert_eq!(accepted.count(), 1, "{path}");
        assert_eq!(answers, [Reply::Done], "{path}");
    }
}

/// What a schedule may never do, whatever it is.
fn check(tasks: &[Task], notes: &[(Instant, Note)]) -> Result<(), TestCaseError> {
    let mut running: Vec<Attempt> = Vec::new();
    let mask = |attempt: &Attempt| {
        let task = tasks.iter().find(|task| task.id == attempt.occurrence.task);
        task.map_or(0, |task| task.categories.mask())
    };
    let mut last = Instant::START;
    for (at, note) in notes {
        prop_assert!(*at >= last, "time goes back at {}", at);
        last = *at;
        match note {
            Note::Started(attempt) | Note::Resumed(attempt) => {
                for other in &running {
                    prop_assert!(mask(other) & mask(attempt) == 0, "{} beside {}", attempt, other);
                }
                running.push(*attempt);
            }
            Note::Paused(attempt) | Note::Preempted(attempt) | Note::Over { attempt, .. } => {
                running.retain(|other| other != attempt);
            }
            _ => {}
        }
    }
    Ok(())
}

proptest! {
    // A failure is found again by its seed; there is no file to keep it in.
    #![proptest_config(ProptestConfig {
        cases: 300,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn no_two_tasks_of_one_category_ever_run_side_by_side(tasks in schedule(8)) {
        let notes = told(&tasks, &Mission::default(), at(10));
        check(&tasks, &notes)?;
        // And the same again, to the last note.
        prop_assert_eq!(notes, told(&tasks, &Mission::default(), at(10)));
    }
}

/// Two executives are to be compared on those that are clear: there must be
/// enough of them, and they must be worth it.
#[test]
fn enough_of_the_generated_schedules_are_clear_and_some_of_each_kind_happen() {
    let mut runner = TestRunner::deterministic();
    let (mut clear, mut paused, mut killed, mut missed) = (0, 0, 0, 0);
    let until = Instant::START.after(UNIT.saturating_mul(60));
    for _ in 0..300 {
        let tasks = schedule(6).new_tree(&mut runner).unwrap().current();
        if !is_clear(&tasks, &Mission::default(), until, Duration::from_millis(5)) {
            continue;
        }
        clear += 1;
        let notes = told(&tasks, &Mission::default(), until);
        let count =
            |wanted: fn(&Note) -> bool| usize::from(notes.iter().any(|(_, note)| wanted(note)));
        paused += count(|note| matches!(note, Note::Paused(_)));
        killed += count(|note| matches!(note, Note::Preempted(_)));
        missed += count(|note| matches!(note, Note::Missed { .. }));
    }
    assert!(
        clear >= 60 && paused >= 10 && killed >= 5 && missed >= 5,
        "{clear} clear, {paused} with pauses, {killed} with kills, {missed} with misses"
    );
}
