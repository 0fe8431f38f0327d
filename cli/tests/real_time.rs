//! SMAARTE's cases in real time, with the processes that the files name.
//!
//! They are let run side by side: they sleep. Times are looked at from below
//! only, since a host may be slow; the order of starts is what it is.

#[expect(dead_code, reason = "each test uses a part of it")]
mod support;

use std::thread;

use serde_json::Value;
use support::call_on;

/// What a run of the case told.
struct Ran {
    notes: Vec<(f64, Value)>,
}

fn run(case: &str, more: &[&str]) -> Ran {
    let said = call_on(case, &[&["run", "{}", "--format", "json"], more].concat());
    assert_eq!(said.code, 0, "{case}: {said:?}");
    let lines = said.json_lines().into_iter();
    let notes = lines.filter(|line| line["note"].is_object());
    let seconds = |line: &Value| line["at_us"].as_f64().expect("an instant") / 1e6;
    Ran { notes: notes.map(|line| (seconds(&line), line["note"].clone())).collect() }
}

impl Ran {
    fn starts(&self) -> Vec<u64> {
        let started = |note: &Value| note["Started"]["occurrence"]["task"].as_u64();
        self.notes.iter().filter_map(|(_, note)| started(note)).collect()
    }

    /// Sorted in groups of so many, which start at one instant in any order.
    fn groups(&self, of: usize) -> Vec<Vec<u64>> {
        let starts = self.starts();
        let groups = starts.chunks(of).map(|group| {
            let mut group = group.to_vec();
            group.sort_unstable();
            group
        });
        groups.collect()
    }

    fn over(&self) -> f64 {
        let ends = self.notes.iter().filter(|(_, note)| note["Over"].is_object());
        ends.map(|(at, _)| *at).fold(0.0, f64::max)
    }

    fn succeeded(&self) -> usize {
        let succeeded = |note: &Value| note["Ended"]["outcome"] == "Succeeded";
        self.notes.iter().filter(|(_, note)| succeeded(note)).count()
    }
}

#[test]
fn the_cases_come_out_in_real_time_as_they_are_foretold() {
    thread::scope(|scope| {
        for case in ["smaarte_fig4.csv", "smaarte_fig4.txt"] {
            scope.spawn(move || {
                let ran = run(case, &[]);
                assert_eq!(ran.groups(2), [[13, 16], [12, 15], [11, 14]], "{case}");
                assert!(ran.over() >= 9.0 && ran.succeeded() == 6, "{case}: {}", ran.over());
            });
        }
        scope.spawn(|| {
            let ran = run("smaarte_2018_priority.txt", &[]);
            assert_eq!(ran.starts(), [23, 22, 21]);
            assert!(ran.over() >= 9.0, "{}", ran.over());
        });
        scope.spawn(|| {
            let ran = run("smaarte_nine_tasks.csv", &[]);
            assert_eq!(ran.groups(3), [[1, 4, 7], [2, 5, 8], [3, 6, 9]]);
            assert!(ran.over() >= 45.0 && ran.succeeded() == 9, "{}", ran.over());
        });
        scope.spawn(|| {
            let ran = run("smaarte_nine_tasks_gap.csv", &[]);
            assert_eq!(ran.groups(3), [[1, 4, 7], [2, 5, 8], [3, 6, 9]]);
            assert!(ran.over() >= 55.0 && ran.succeeded() == 9, "{}", ran.over());
        });
        scope.spawn(|| {
            // `sleep` counts the time for which it is stopped: it ends earlier
            // than a program that works. One attempt all the same.
            let ran = run("smaarte_preempt.csv", &["--for", "30"]);
            assert_eq!(ran.starts(), [31, 32]);
            let is = |what: &str, (_, note): &&(f64, Value)| {
                let attempt = if what == "Over" { &note[what]["attempt"] } else { &note[what] };
                attempt["occurrence"]["task"] == 31
            };
            let at = |what: &str| ran.notes.iter().find(|note| is(what, note)).map(|(at, _)| *at);
            let (paused, resumed) =
                (at("Paused").expect("a pause"), at("Resumed").expect("a resumption"));
            assert!(paused >= 5.0 && resumed >= 11.0 && at("Over") > Some(resumed));
        });
    });
}

#[test]
fn a_schedule_with_mistakes_does_not_run() {
    let said = call_on("bad_schedule.csv", &["run", "{}"]);
    assert_ne!(said.code, 0);
    assert!(said.out.is_empty(), "nothing ran: {}", said.out);
    assert!(said.err.contains("there is no program"), "{}", said.err);
}
