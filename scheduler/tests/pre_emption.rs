//! The pre-emption case with a real tree of processes that work, and a device
//! that the pre-empted task goes on commanding.
//!
//! A routine task works for 20 s. After 5 s a more important one takes its
//! category, for 6 s. (2018 paper, "Priority Overrides"; thesis, section 5.3.)
#![cfg(target_os = "linux")]

#[path = "pre_emption/stage.rs"]
mod stage;
#[path = "pre_emption/work.rs"]
mod work;

use std::sync::atomic::Ordering::SeqCst;

use faregate_scheduler::manager::Note;

use stage::{Seen, play};

/// How far a host may be off what is foretold in seconds before this test
/// looks at nothing but the order.
const NEAR: f64 = 0.5;

/// The part of the processes: a leader and its child, both busy.
#[test]
#[ignore = "the part of a child process"]
fn works() {
    work::work();
}

fn is_of(note: &Note, task: u32) -> bool {
    match note {
        Note::Started(attempt)
        | Note::Paused(attempt)
        | Note::Resumed(attempt)
        | Note::Stopping { attempt, .. }
        | Note::Over { attempt, .. } => attempt.occurrence.task.get() == task,
        _ => false,
    }
}

fn told(seen: &Seen, task: u32) -> Vec<&'static str> {
    let word = |note: &Note| match note {
        Note::Started(_) => "started",
        Note::Stopping { .. } => "stopping",
        Note::Paused(_) => "paused",
        Note::Resumed(_) => "resumed",
        Note::Over { .. } => "over",
        _ => "",
    };
    seen.notes.iter().filter(|(_, note)| is_of(note, task)).map(|(_, note)| word(note)).collect()
}

fn at(seen: &Seen, task: u32, is: impl Fn(&Note) -> bool) -> f64 {
    let found = seen.notes.iter().find(|(_, note)| is_of(note, task) && is(note));
    found.expect("it happened").0
}

#[test]
fn a_paused_tree_uses_no_processor_and_its_commands_name_the_taker() {
    let seen = play();
    // One attempt, which goes on where it was.
    assert_eq!(told(&seen, 31), ["started", "stopping", "paused", "resumed", "over"]);
    assert_eq!(told(&seen, 32), ["started", "over"]);
    let paused = at(&seen, 31, |note| matches!(note, Note::Paused(_)));
    let resumed = at(&seen, 31, |note| matches!(note, Note::Resumed(_)));
    let taken_by = at(&seen, 32, |note| matches!(note, Note::Started(_)));
    let over = at(&seen, 31, |note| matches!(note, Note::Over { .. }));
    assert!(paused <= taken_by && taken_by < resumed, "{:?}", seen.notes);
    println!("segments 0-{paused:.3} and {resumed:.3}-{over:.3} s");
    let foretold = [(paused, 5.0), (resumed, 11.0), (over, 26.0)];
    if foretold.iter().any(|(real, foretold)| (real - foretold).abs() > NEAR) {
        println!("the host was late: {foretold:?}");
    }
    assert!(paused >= 5.0 && resumed >= 11.0 && over >= 26.0, "{foretold:?}");
    // The same processes before and after, and no processor time between.
    assert_eq!(seen.before.len(), 2, "a leader and its child: {:?}", seen.before);
    assert_eq!(seen.before.keys().collect::<Vec<_>>(), seen.after.keys().collect::<Vec<_>>());
    assert_eq!(seen.at_pause, seen.at_resumption, "clock ticks of each process");
    assert!(seen.before.iter().all(|(pid, ticks)| *ticks < seen.after[pid]), "it worked again");
    // Its commands were refused meanwhile, each with the name of the taker.
    let refused: Vec<_> =
        seen.commands.iter().filter(|(at, _)| (paused..taken_by + 5.0).contains(at)).collect();
    assert!(refused.len() > 100, "{} commands were tried", refused.len());
    for (at, answer) in refused {
        let reason = answer.as_ref().expect_err("its tickets were taken");
        assert!(reason.contains("taken by task 32"), "at {at}: {reason}");
    }
    let issued = |from: f64, to: f64| {
        seen.commands
            .iter()
            .filter(|(at, answer)| (from..to).contains(at) && answer.is_ok())
            .count()
    };
    assert!(issued(1.0, 4.5) > 100, "its commands were issued while it ran");
    assert!(issued(resumed + 1.0, over) > 100, "and when it went on");
    assert!(!seen.truth.on.load(SeqCst), "no device is left on");
}
