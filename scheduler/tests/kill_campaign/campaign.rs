//! Histories until every point was died at often enough.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use clap::Args;
use faregate_scheduler::journal::points::Point;
use indicatif::{ProgressBar, ProgressStyle};
use parking_lot::Mutex;

use crate::history::{self, Death, Visits};
use crate::{Break, Failure};

/// What a campaign does.
#[derive(Debug, Args)]
pub(crate) struct Wishes {
    /// How often a manager dies at each point, at least.
    #[arg(long, default_value_t = 2, value_name = "N")]
    deaths: u64,
    /// Where the random numbers begin.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many histories run at a time.
    #[arg(long, value_name = "N")]
    at_a_time: Option<usize>,
    /// Breaks the manager, and wants that to be seen.
    #[arg(long = "break", value_name = "WHAT")]
    broken: Option<Break>,
    /// The flag of a test harness that wants to see what is printed.
    #[arg(long, hide = true)]
    nocapture: bool,
}

/// How many deaths a history has at most.
const DEATHS: usize = 6;
/// After so many histories for each death that is wanted, a point that was
/// never died at is one that nobody comes to.
const HISTORIES: u64 = 12;

struct Campaign {
    wanted: u64,
    broken: Option<Break>,
    usual: Visits,
    random: Mutex<fastrand::Rng>,
    tally: Mutex<Tally>,
    bar: ProgressBar,
    failed: AtomicBool,
}

#[derive(Default)]
struct Tally {
    deaths: BTreeMap<Point, u64>,
    histories: u64,
    failures: Vec<Failure>,
}

pub(crate) fn run(wishes: &Wishes) -> Result<ExitCode, Failure> {
    // A life that nobody ends tells how often each point is come to.
    adopt_orphans()?;
    let (_, usual) = history::run(&[], None)?;
    let points = u64::try_from(Point::ALL.len())?;
    let bar = ProgressBar::new(points * wishes.deaths);
    bar.set_style(ProgressStyle::with_template("{wide_bar} {pos}/{len} deaths, {elapsed}")?);
    let campaign = Campaign {
        wanted: wishes.deaths,
        broken: wishes.broken,
        usual,
        random: Mutex::new(fastrand::Rng::with_seed(wishes.seed)),
        tally: Mutex::default(),
        bar,
        failed: AtomicBool::new(false),
    };
    let at_a_time = wishes.at_a_time.unwrap_or(thread::available_parallelism()?.get() * 2);
    thread::scope(|scope| {
        for _ in 0..at_a_time {
            scope.spawn(|| campaign.work());
        }
    });
    campaign.bar.finish_and_clear();
    reap();
    Ok(match wishes.broken {
        None => campaign.report(),
        Some(broken) => campaign.report_of(broken),
    })
}

/// Tasks outlive their manager as dead children of somebody: of us, who reap
/// them.
fn adopt_orphans() -> Result<(), Failure> {
    let own = rustix::process::getpid();
    Ok(rustix::process::set_child_subreaper(Some(own))?)
}

fn reap() {
    let options = rustix::process::WaitOptions::NOHANG;
    while let Ok(Some(_)) = rustix::process::wait(options) {}
}

impl Campaign {
    fn work(&self) {
        while let Some(deaths) = self.next() {
            match history::run(&deaths, self.broken) {
                Ok((died, _)) => self.count(&died),
                Err(error) => {
                    // What was seen of it is all there is to see.
                    self.failed.store(true, Ordering::Relaxed);
                    self.tally.lock().failures.push(error);
                }
            }
        }
    }

    /// The deaths of the next history: points at which too few died, and any.
    fn next(&self) -> Option<Vec<Death>> {
        let mut tally = self.tally.lock();
        let points = self.broken.map_or(&Point::ALL[..], Break::points);
        let lacks =
            |(point, _): &&(Point, u64)| points.contains(point) && self.lacks(&tally, *point);
        let lacking: Vec<_> = self.usual.iter().filter(lacks).collect();
        let limit = HISTORIES * self.wanted * self.usual.len() as u64;
        if lacking.is_empty() || tally.histories >= limit || self.failed.load(Ordering::Relaxed) {
            return None;
        }
        tally.histories += 1;
        let mut random = self.random.lock();
        let deaths = (0..random.usize(1..=DEATHS)).map(|_| {
            let (point, visits) = *lacking[random.usize(..lacking.len())];
            // Later lives have less to do than the usual one.
            let visit = 1 + random.u64(..=visits / 2);
            Death { point, visit }
        });
        Some(deaths.collect())
    }

    fn lacks(&self, tally: &Tally, point: Point) -> bool {
        tally.deaths.get(&point).copied().unwrap_or(0) < self.wanted
    }

    fn count(&self, died: &[Death]) {
        let mut tally = self.tally.lock();
        for death in died {
            let deaths = tally.deaths.entry(death.point).or_default();
            *deaths += 1;
            if *deaths <= self.wanted {
                self.bar.inc(1);
            }
        }
    }

    /// What is broken has to be seen for what it is.
    fn report_of(&self, broken: Break) -> ExitCode {
        let tally = self.tally.lock();
        let seen = |failure: &&Failure| failure.to_string().contains(broken.complaint());
        let Some(failure) = tally.failures.iter().find(seen) else {
            eprintln!("FAILED: {broken:?} was not seen in {} histories", tally.histories);
            tally.failures.iter().for_each(|failure| eprintln!("but: {failure}"));
            return ExitCode::FAILURE;
        };
        println!("seen, as it must be: {failure}");
        ExitCode::SUCCESS
    }

    fn report(&self) -> ExitCode {
        let tally = self.tally.lock();
        println!("{:<16} {:>8} {:>14}", "point", "deaths", "usual visits");
        for (point, visits) in &self.usual {
            let deaths = tally.deaths.get(point).copied().unwrap_or(0);
            println!("{:<16} {deaths:>8} {visits:>14}", point.name());
        }
        let deaths: u64 = tally.deaths.values().sum();
        println!("{} histories, {deaths} deaths", tally.histories);
        tally.failures.iter().for_each(|failure| eprintln!("FAILED: {failure}"));
        let never: Vec<_> =
            Point::ALL.into_iter().filter(|point| self.lacks(&tally, *point)).collect();
        if !never.is_empty() && tally.failures.is_empty() {
            eprintln!("FAILED: fewer than {} deaths at: {never:?}", self.wanted);
        }
        if never.is_empty() && tally.failures.is_empty() {
            println!("no task was lost, none began twice, and no device was left on");
            return ExitCode::SUCCESS;
        }
        ExitCode::FAILURE
    }
}
