//! Tasks that only take their time.

use std::collections::BTreeMap;

use crate::bodies::sequences::Watch;
use crate::manager::{Attempt, Event, Exit, Stop};
use crate::time::{Duration, Instant};

/// How a body that is no process ends when it is ended: as a process does that
/// does not handle SIGTERM.
pub(super) const TERMINATED: Exit = Exit::Signal(15);

/// The holds that are not over.
#[derive(Debug, Default)]
pub(super) struct Holds {
    live: BTreeMap<Attempt, (Duration, Watch)>,
}

impl Holds {
    pub(super) fn start(&mut self, attempt: Attempt, duration: Duration, now: Instant) {
        self.live.insert(attempt, (duration, Watch::started(now)));
    }

    pub(super) fn stop(
        &mut self,
        attempt: Attempt,
        how: Stop,
        now: Instant,
        events: &mut Vec<Event>,
    ) {
        let Some((_, watch)) = self.live.get_mut(&attempt) else { return };
        if how == Stop::Pause {
            watch.halt(now);
            events.push(Event::Stopped { attempt });
        } else {
            self.live.remove(&attempt);
            events.push(Event::Exited { attempt, exit: TERMINATED });
        }
    }

    pub(super) fn resume(&mut self, attempt: Attempt, now: Instant) {
        if let Some((_, watch)) = self.live.get_mut(&attempt) {
            watch.go_on(now);
        }
    }

    pub(super) fn poll(&mut self, now: Instant, events: &mut Vec<Event>) {
        self.live.retain(|attempt, (duration, watch)| {
            let over = watch.comes_to(*duration).is_some_and(|end| end <= now);
            if over {
                events.push(Event::Exited { attempt: *attempt, exit: Exit::Code(0) });
            }
            !over
        });
    }

    pub(super) fn next_due(&self) -> Option<Instant> {
        self.live.values().filter_map(|(duration, watch)| watch.comes_to(*duration)).min()
    }
}
