//! Radio windows: when a ground station can hear the transmitter.

use faregate_tickets::clock::{Duration, Instant};

/// Spans of time, sorted and apart.
#[derive(Clone, Debug)]
pub(crate) struct RadioWindows(Vec<(Instant, Instant)>);

impl RadioWindows {
    /// Always open.
    pub(crate) fn always() -> Self {
        Self(vec![(Instant::START, Instant::START.after(Duration::from_micros(u64::MAX)))])
    }

    /// Open in these spans, counted from when the payload was made; those that
    /// overlap are one.
    pub(crate) fn new(mut spans: Vec<(Duration, Duration)>) -> Self {
        spans.sort_unstable();
        let mut windows: Vec<(Instant, Instant)> = Vec::new();
        for (from, to) in
            spans.iter().map(|(a, b)| (Instant::START.after(*a), Instant::START.after(*b)))
        {
            match windows.last_mut() {
                Some(last) if from <= last.1 => last.1 = last.1.max(to),
                _ => windows.push((from, to)),
            }
        }
        Self(windows)
    }

    pub(crate) fn is_open(&self, now: Instant) -> bool {
        self.0.iter().any(|(from, to)| *from <= now && now < *to)
    }

    /// When one opens or closes, after `now`.
    pub(crate) fn next_change(&self, now: Instant) -> Option<Instant> {
        self.0.iter().flat_map(|(from, to)| [*from, *to]).find(|at| *at > now)
    }
}
