//! Where threads run: on real threads and real time, or interleaved by a seed
//! in virtual time. The bodies are the same.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use faregate::runtime::wake::Wakeup;
use faregate::tickets::clock::{Clock, Duration, Instant};
use faregate::tickets::id::Priority;
use faregate_devices_sim::SimClock;
use faregate_devices_sim::interleave::{Interleaver, WakeFlag};

/// A thread body: its name, its priority, what it does.
pub(crate) type Body<'env> = (&'static str, Priority, Box<dyn FnOnce() + Send + 'env>);

/// Time, and whether the run goes on.
pub(crate) struct Stage {
    pub(crate) clock: SimClock,
    is_virtual: bool,
    ends_at: Instant,
    over: AtomicBool,
    story: Story,
}

/// The story of a run, if anybody wants it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Story(Option<Arc<Mutex<Vec<Line>>>>);

impl Story {
    pub(crate) fn tell(&self, at: Instant, who: &'static str, what: impl FnOnce() -> String) {
        if let Some(lines) = &self.0 {
            lines.lock().expect("no teller panics").push(Line { at, who, what: what() });
        }
    }
}

/// A line of the timeline.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) at: Instant,
    pub(crate) who: &'static str,
    pub(crate) what: String,
}

impl Stage {
    pub(crate) fn virtual_time(ends_at: Instant) -> Self {
        Self::new(SimClock::virtual_time(), true, ends_at)
    }

    pub(crate) fn real_time(ends_at: Instant) -> Self {
        Self::new(SimClock::real_time(), false, ends_at)
    }

    fn new(clock: SimClock, is_virtual: bool, ends_at: Instant) -> Self {
        Self { clock, is_virtual, ends_at, over: AtomicBool::new(false), story: Story::default() }
    }

    /// The same stage, on which the story is written down.
    pub(crate) fn telling(mut self) -> Self {
        self.story = Story(Some(Arc::default()));
        self
    }

    /// Whether bodies go on: until somebody ends the run, or the time is up.
    pub(crate) fn goes_on(&self) -> bool {
        // Relaxed: it says nothing about other memory.
        !self.over.load(Ordering::Relaxed) && self.clock.now() < self.ends_at
    }

    pub(crate) fn end(&self) {
        self.over.store(true, Ordering::Relaxed);
    }

    pub(crate) fn wait(&self, time: Duration) {
        self.clock.wait_until(self.clock.now().after(time));
    }

    pub(crate) fn tell(&self, who: &'static str, what: impl FnOnce() -> String) {
        self.story.tell(self.clock.now(), who, what);
    }

    /// Where lanes tell what they see.
    pub(crate) fn teller(&self) -> Story {
        self.story.clone()
    }

    /// All that was told, in the order of time.
    pub(crate) fn story(&self) -> Vec<Line> {
        let lines = |story: &Mutex<Vec<Line>>| story.lock().expect("no teller panics").clone();
        let mut lines = self.story.0.as_deref().map(lines).unwrap_or_default();
        lines.sort_by_key(|line| line.at);
        lines
    }

    pub(crate) fn bell(&self) -> Bell {
        if self.is_virtual {
            Bell::Virtual(WakeFlag::new())
        } else {
            Bell::Real(Wakeup::new().expect("the host has a file descriptor left"))
        }
    }

    /// Runs the bodies to their ends.
    pub(crate) fn perform(&self, seed: u64, bodies: Vec<Body<'_>>) {
        if self.is_virtual {
            let mut threads = Interleaver::new(&self.clock, seed);
            for (name, priority, body) in bodies {
                threads.spawn(name, priority, body);
            }
            threads.run(self.ends_at);
            return;
        }
        std::thread::scope(|scope| {
            for (name, _, body) in bodies {
                let thread = std::thread::Builder::new().name(name.into());
                thread.spawn_scoped(scope, body).expect("the host has a thread left");
            }
        });
    }
}

/// Wakes one waiting thread.
pub(crate) enum Bell {
    Virtual(WakeFlag),
    Real(Wakeup),
}

impl Bell {
    pub(crate) fn ring(&self) {
        match self {
            Self::Virtual(flag) => flag.wake(),
            Self::Real(wakeup) => wakeup.notify(),
        }
    }

    /// Waits until it rings, or until `at` by the stage's clock.
    pub(crate) fn wait_until(&self, stage: &Stage, at: Instant) {
        match self {
            Self::Virtual(flag) => {
                flag.wait_until(at);
            }
            Self::Real(wakeup) => {
                let time = at.since(stage.clock.now());
                let host = faregate::runtime::clock::MonotonicClock::new();
                // An early end makes the caller look once more.
                let _ = wakeup.wait_until(Some(host.now().after(time)));
            }
        }
    }
}
