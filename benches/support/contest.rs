//! Contests: entrants that are sampled in turn, within one run.
//!
//! On a shared machine the clock rate, the caches and the neighbours change
//! from one second to the next. Two things that are measured one after the
//! other differ for that reason alone. So each round samples every entrant
//! once, in an order drawn anew, and what is quoted is a ratio between entrants
//! of the same rounds.

use std::hint::black_box;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::Peer;

/// A sample takes at least this long, so that reading the clock twice is less
/// than a hundredth of it.
const SAMPLE: Duration = Duration::from_micros(20);

/// The orders of rounds are the same in each run.
const SEED: u64 = 0x0fa2_e6a7_e000_0001;

/// What does so many operations, and says how long they took.
type Work<'a> = Box<dyn FnMut(u64) -> Duration + 'a>;

/// One entrant of a contest; to be asked of its own contest's times only.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entrant(usize);

struct Lane<'a> {
    name: String,
    work: Work<'a>,
    operations: u64,
    /// Nanoseconds per operation, one for each round.
    samples: Vec<f64>,
}

impl Lane<'_> {
    /// Finds how many operations fill a sample.
    fn calibrate(&mut self) {
        // Warm: the first call pays for page faults and lazy linking.
        (self.work)(1);
        while (self.work)(self.operations) < SAMPLE {
            self.operations = self.operations.saturating_mul(2);
        }
    }

    fn sample(&mut self, clock: Duration) {
        let took = (self.work)(self.operations).saturating_sub(clock);
        self.samples.push(took.as_secs_f64() * 1e9 / self.operations as f64);
    }
}

/// A contest while its entrants come in.
pub(crate) struct Contest<'a> {
    name: String,
    rounds: u32,
    lanes: Vec<Lane<'a>>,
}

impl<'a> Contest<'a> {
    pub(super) fn new(name: &str, rounds: u32) -> Self {
        Self { name: name.into(), rounds, lanes: Vec::new() }
    }

    /// The same with so many rounds, where an operation is slow.
    pub(crate) fn rounds(mut self, rounds: u32) -> Self {
        self.rounds = rounds;
        self
    }

    /// An entrant that does so many operations when called.
    pub(crate) fn enter(
        &mut self,
        name: impl Into<String>,
        mut work: impl FnMut(u64) + 'a,
    ) -> Entrant {
        self.enter_timed(name, move |n| {
            let start = Instant::now();
            work(n);
            start.elapsed()
        })
    }

    /// An entrant that times its operations itself, because something around
    /// them must not count.
    pub(crate) fn enter_timed(
        &mut self,
        name: impl Into<String>,
        work: impl FnMut(u64) -> Duration + 'a,
    ) -> Entrant {
        let lane =
            Lane { name: name.into(), work: Box::new(work), operations: 1, samples: Vec::new() };
        self.lanes.push(lane);
        Entrant(self.lanes.len() - 1)
    }

    /// Runs all rounds.
    pub(crate) fn run(mut self) -> Times {
        let bar = bar(&self.name, self.rounds);
        self.lanes.iter_mut().for_each(Lane::calibrate);
        let clock = cost_of_the_clock();
        let mut random = fastrand::Rng::with_seed(SEED);
        let mut order: Vec<usize> = (0..self.lanes.len()).collect();
        for _ in 0..self.rounds {
            random.shuffle(&mut order);
            for &lane in &order {
                self.lanes[lane].sample(clock);
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        let entrants =
            self.lanes.into_iter().map(|lane| (lane.name, Quantiles::of(lane.samples))).collect();
        Times { contest: self.name, entrants }
    }
}

fn bar(name: &str, rounds: u32) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:24} {wide_bar} {pos}/{len} rounds, {eta} left");
    let bar = ProgressBar::new(rounds.into()).with_message(name.to_owned());
    // The template is fixed: should it be wrong, the default style does.
    style.map(|style| bar.clone().with_style(style)).unwrap_or(bar)
}

/// What timing nothing seems to take: the least of many.
fn cost_of_the_clock() -> Duration {
    let nothing = || {
        let start = Instant::now();
        black_box(start).elapsed()
    };
    (0..10_000).map(|_| nothing()).min().unwrap_or_default()
}

/// What a contest came to.
#[derive(Debug)]
pub(crate) struct Times {
    contest: String,
    entrants: Vec<(String, Quantiles)>,
}

impl Times {
    /// The times of one entrant.
    pub(crate) fn of(&self, entrant: Entrant) -> Quantiles {
        self.entrants[entrant.0].1
    }

    pub(super) fn peers(&self) -> impl Iterator<Item = Peer> {
        self.entrants.iter().map(|(name, times)| Peer {
            contest: self.contest.clone(),
            name: name.clone(),
            p5_ns: times.p5,
            median_ns: times.median,
        })
    }
}

/// Nanoseconds per operation, over the samples of one entrant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantiles {
    pub(crate) p5: f64,
    pub(crate) median: f64,
    pub(crate) p99: f64,
    pub(crate) p999: f64,
}

impl Quantiles {
    /// Of at least one sample.
    pub(crate) fn of(mut samples: Vec<f64>) -> Self {
        samples.sort_by(f64::total_cmp);
        let last = samples.len() - 1;
        let at = |per_mille: usize| samples[last * per_mille / 1_000];
        Self { p5: at(50), median: at(500), p99: at(990), p999: at(999) }
    }
}
