//! Schedules as others wrote them: read without harm, and with so many mistakes
//! told as somebody can use.

use std::panic::{AssertUnwindSafe, catch_unwind};

use faregate_client::{Problem, RefusalKind, Refused};

use crate::control::ReadSchedule;
use crate::task::Task;

/// The tasks of a schedule.
///
/// A reader that panics has failed with this schedule, and reads the next one:
/// without its thread nobody could command the manager any more.
///
/// # Errors
/// What is wrong with it, in at most about `room` bytes.
pub(super) fn read(
    schedules: &dyn ReadSchedule,
    name: &str,
    text: &str,
    room: usize,
) -> Result<Vec<Task>, Refused> {
    let read = catch_unwind(AssertUnwindSafe(|| schedules.read(name, text)));
    let read = read.unwrap_or_else(|_| {
        let why = "its reader panicked: a defect of the manager";
        Err(Refused::new(RefusalKind::NotDone, why))
    });
    read.map_err(|refused| cut(refused, room))
}

/// The same with the first of its problems, as many as there is room for, and
/// how many more there are. A file that is no schedule at all has one in each
/// line, and who asked takes no answer of that length.
fn cut(mut refused: Refused, mut room: usize) -> Refused {
    let mut fits = |problem: &Problem| {
        let field = problem.field.as_ref().map_or(0, String::len);
        room = room.saturating_sub(problem.message.len() + field + AROUND);
        room > 0
    };
    let told = refused.problems.iter().take_while(|problem| fits(problem)).count();
    let more = refused.problems.len() - told;
    if more > 0 {
        refused.problems.truncate(told);
        let message = format!("{more} more mistakes are not told");
        refused.problems.push(Problem { message, ..Problem::default() });
    }
    refused
}

/// What a problem takes beside its words.
const AROUND: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_that_panics_fails_and_says_so() {
        let panics = |_: &str, _: &str| panic!("as it is to");
        let refused = read(&panics, "a.csv", "", 1000).unwrap_err();
        assert_eq!(refused.kind, RefusalKind::NotDone);
        assert!(refused.reason.contains("its reader panicked"), "{refused}");
    }

    #[test]
    fn as_many_mistakes_are_told_as_there_is_room_for_and_the_rest_is_counted() {
        let problem =
            |line| Problem { line: Some(line), message: "x".repeat(36), ..Problem::default() };
        let wrong = |_: &str, _: &str| {
            let refused = Refused::new(RefusalKind::Invalid, "it is not loaded");
            Err(refused.with_problems((1..=1000).map(problem).collect()))
        };
        let all = read(&wrong, "a.csv", "", 1_000_000).unwrap_err();
        assert_eq!(all.problems.len(), 1000, "what fits is told whole");
        let some = read(&wrong, "a.csv", "", 1001).unwrap_err();
        assert_eq!(some.problems.len(), 11);
        assert_eq!(some.problems[9], problem(10));
        assert_eq!(some.problems[10].message, "990 more mistakes are not told");
    }
}
