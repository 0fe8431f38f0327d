//! A run on the virtual clock: nothing is executed.

use std::time::{Duration as StdDuration, Instant as StdInstant};

use faregate_scheduler::executive::{LoadedFile, Outside, Stuck, VirtualBodies, VirtualExecutive};
use faregate_scheduler::manager::{
    Addition, Attempt, Event, Note, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::time::{Duration, Instant, Now};

use super::teller::Teller;
use crate::exit::Failure;
use crate::schedule::{Loader, Schedule};
use crate::times;

/// How a virtual clock goes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pace {
    /// As fast as can be.
    Free,
    /// So many times faster than the host's clock.
    Times(f64),
}

/// Who hears of a virtual run.
struct Audience {
    teller: Teller,
    refused: Option<String>,
    loader: Loader,
}

impl Outside for Audience {
    fn note(&mut self, now: Now, note: &Note) {
        self.teller.tell(now, note);
        self.teller.tally.count(note);
    }

    fn answer(&mut self, _: Now, _: TelecommandId, reply: Reply) {
        if let Reply::Refused(why) = reply {
            self.refused = Some(why);
        }
    }

    fn load(&mut self, _: Attempt, path: &str) -> Option<LoadedFile> {
        let file = self.loader.load(path);
        file.iter().flatten().for_each(|task| self.teller.tally.learn(task));
        Some(file)
    }
}

/// Runs the schedule until nothing is left to do, or the time is over.
pub(crate) fn run(
    schedule: Schedule,
    pace: Pace,
    time: Option<Duration>,
    mut teller: Teller,
) -> Result<Teller, Failure> {
    let Schedule { tasks, mission, loader, .. } = schedule;
    tasks.iter().for_each(|task| teller.tally.learn(task));
    let audience = Audience { teller, refused: None, loader };
    let bodies = VirtualBodies::as_expected();
    let mut executive = VirtualExecutive::new(mission, times::now(), bodies, audience);
    let additions = tasks.into_iter().map(|task| Addition { task }).collect();
    let telecommand = Telecommand::Add(additions);
    executive.tell(Event::Telecommand { id: TelecommandId(0), telecommand });
    let began = StdInstant::now();
    executive.advance_to(Instant::START).map_err(|why| stuck(&why))?;
    if let Some(why) = executive.outside().refused.take() {
        return Err(Failure::failed(format!("the schedule is not accepted: {why}")));
    }
    let end = time.map(|time| Instant::START.after(time));
    while !executive.manager().is_over() {
        let Some(due) = executive.next_due() else {
            executive.outside().teller.say("Nothing that is left can ever happen.");
            break;
        };
        if end.is_some_and(|end| due > end) {
            break;
        }
        wait(pace, began, due);
        executive.advance_to(due).map_err(|why| stuck(&why))?;
    }
    if let Some(end) = end.filter(|_| !executive.manager().is_over()) {
        wait(pace, began, end);
    }
    Ok(executive.into_outside().teller)
}

/// The virtual clock does not go on.
pub(super) fn stuck(stuck: &Stuck) -> Failure {
    Failure::failed(stuck.to_string())
}

/// Waits until the virtual instant has come.
#[expect(clippy::disallowed_methods, reason = "the virtual clock is to be seen in real time")]
pub(super) fn wait(pace: Pace, began: StdInstant, instant: Instant) {
    let Pace::Times(times) = pace else { return };
    std::thread::sleep(real(instant, times).saturating_sub(began.elapsed()));
}

/// When a virtual instant comes on the host's clock; at a speed of nearly
/// nothing that is later than can be said.
fn real(instant: Instant, times: f64) -> StdDuration {
    let virtually = StdDuration::from_micros(instant.as_micros()).as_secs_f64();
    StdDuration::try_from_secs_f64(virtually / times).unwrap_or(StdDuration::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_of_nearly_nothing_waits_long_and_does_not_panic() {
        let second = Instant::from_micros(1_000_000);
        assert_eq!(real(second, 4.0), StdDuration::from_millis(250));
        assert_eq!(real(second, 1e-30), StdDuration::MAX);
        assert_eq!(real(second, f64::MIN_POSITIVE), StdDuration::MAX);
        assert_eq!(real(Instant::START, 1e-30), StdDuration::ZERO);
    }
}
