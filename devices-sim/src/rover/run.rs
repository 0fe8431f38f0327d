//! Sequences that run: what they really take.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

/// A sequence's number: whoever starts it chooses it.
pub type RunKey = u32;

/// What a sequence really takes. Whoever plans does not see it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunSpec {
    /// The place in which it runs.
    pub place: usize,
    /// How long it runs by itself.
    pub length: Duration,
    /// How long it goes on after it was told to end.
    pub ending: Duration,
    /// Whether it does its work.
    pub succeeds: bool,
    /// Average draw.
    pub average: Milliwatts,
    /// Largest draw.
    pub peak: Milliwatts,
    /// Sequence engines that it occupies.
    pub engines: u32,
    /// What it adds to the data on board, if it runs to its end by itself; less
    /// in proportion otherwise.
    pub data: i64,
    /// The zones that it uses.
    pub zones: Vec<usize>,
}

/// A sequence, as it is.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) spec: RunSpec,
    /// How long it has run.
    done: Duration,
    /// At how much of that it ends.
    end: Duration,
    /// Whether it stands still.
    pub(super) stopped: bool,
    told: bool,
}

impl Run {
    pub(super) fn new(spec: RunSpec) -> Self {
        let end = spec.length;
        Self { spec, done: Duration::ZERO, end, stopped: false, told: false }
    }

    pub(super) fn pass(&mut self, time: Duration) {
        if !self.stopped {
            self.done = self.done.saturating_add(time);
        }
    }

    /// When it ends, if nobody stops it.
    pub(super) fn ends(&self, now: Instant) -> Option<Instant> {
        (!self.stopped).then(|| now.after(self.end.saturating_sub(self.done)))
    }

    pub(super) fn is_over(&self) -> bool {
        !self.stopped && self.done >= self.end
    }

    pub(super) fn tell_to_end(&mut self) {
        self.told = true;
        self.end = self.end.min(self.done.saturating_add(self.spec.ending));
    }

    /// Who was told to end and did has done what it was to do.
    pub(super) fn succeeded(&self) -> bool {
        self.spec.succeeds || self.told && self.end < self.spec.length
    }

    /// In proportion to how long it ran, rounded towards nothing.
    pub(super) fn data(&self) -> i64 {
        let (done, length) = (self.done.as_micros(), self.spec.length.as_micros().max(1));
        let made = i128::from(self.spec.data) * i128::from(done) / i128::from(length);
        i64::try_from(made).unwrap_or(self.spec.data)
    }

    pub(super) fn average(&self) -> Milliwatts {
        if self.stopped { Milliwatts::ZERO } else { self.spec.average }
    }

    pub(super) fn peak(&self) -> Milliwatts {
        if self.stopped { Milliwatts::ZERO } else { self.spec.peak }
    }
}
