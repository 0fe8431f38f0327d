//! The whole emergency on threads: request, pre-empt, quiesce, safe, see off,
//! admit, command.
//!
//! `cargo bench --bench emergency`. Row 10 of the targets in
//! `docs/performance.md`. The devices take no time, so what is measured is what
//! the tickets cost, beside the floor of the same run: the same commands bare,
//! and the two wake-ups that nothing can spare.

mod agency;
mod bound;
mod floor;
mod plant;
mod rescue;
mod roles;
mod sensors;
#[path = "../support/mod.rs"]
mod support;

use std::cell::RefCell;
use std::process::ExitCode;
use std::time::Duration;

use support::{Bench, Contest, Curve, Entrant, Failure, Series, Target, Times};

use agency::Service;
use floor::Floor;
use plant::patient;
use rescue::Rescue;
use roles::Role;
use sensors::Sensing;

/// Emergencies for each round of an ordinary contest: their 99.9th percentile
/// is looked at.
const EMERGENCIES: u32 = 3;
/// Tickets at the broker with room for 60 000.
const TICKETS: [usize; 4] = [1, 100, 10_000, 60_000];

/// Sensors without lag; what follows is left to the service thread.
const SERVED: Sensing = Sensing::Woken { serves: false };
/// Sensors without lag, whose thread does what follows itself.
const SERVING: Sensing = Sensing::Woken { serves: true };

fn main() -> ExitCode {
    support::run("emergency", |bench| {
        let report = Role::Rescuer.take();
        if !report.is_complete() {
            eprintln!("{report}");
        }
        time_emergencies(bench)?;
        bound::measure(bench)
    })
}

/// Emergencies in one contest, and the first that failed.
struct Emergencies<'a> {
    contest: Contest<'a>,
    failure: &'a RefCell<Option<Failure>>,
}

impl<'a> Emergencies<'a> {
    /// One emergency is one sample, whatever number is asked for: an average of
    /// several would have no 99.9th percentile worth the name.
    fn enter(
        &mut self,
        name: impl Into<String>,
        mut round: impl FnMut() -> Result<Duration, Failure> + 'a,
    ) -> Entrant {
        let failure = self.failure;
        self.contest.enter_timed(name, move |n| {
            let took =
                if failure.borrow().is_some() { Ok(Duration::from_secs(1)) } else { round() };
            let took = took.unwrap_or_else(|why| {
                *failure.borrow_mut() = Some(why);
                Duration::from_secs(1)
            });
            took.saturating_mul(u32::try_from(n).unwrap_or(u32::MAX))
        })
    }
}

/// The emergencies that are held against the floor.
struct Held {
    name: &'static str,
    entrant: Entrant,
    target: Target,
}

fn time_emergencies(bench: &mut Bench) -> Result<(), Failure> {
    let failure = RefCell::new(None);
    let contest = bench.contest("emergency").rounds(bench.rounds() * EMERGENCIES);
    let mut emergencies = Emergencies { contest, failure: &failure };
    let mut floor = Floor::new()?;
    let floor = emergencies.enter("floor: two wake-ups, bare commands", move || floor.round());
    let held = enter_held(&mut emergencies)?;
    let crowds = enter_crowds(&mut emergencies)?;
    let times = emergencies.contest.run();
    if let Some(failure) = failure.take() {
        return Err(failure);
    }
    against_the_floor(bench, &times, floor, &held);
    over_tickets(bench, &times, crowds, floor);
    bench.peers(&times);
    Ok(())
}

fn enter_held(emergencies: &mut Emergencies<'_>) -> Result<Vec<Held>, Failure> {
    let mut held = Vec::new();
    let mut enter = |name, target, round: Box<dyn Fn() -> Result<Duration, Failure>>| {
        held.push(Held { name, entrant: emergencies.enter(name, round), target });
    };
    let target = Target::AtMost(2.0);
    let rescue = Rescue::new(agency::runtime(1, patient())?, SERVED, 0)?;
    enter("1 victim present", target, Box::new(move || rescue.round(0)));
    let rescue = Rescue::new(agency::runtime(31, patient())?, SERVED, 0)?;
    enter("31 victims present", target, Box::new(move || rescue.round(0)));
    let rescue = Rescue::new(agency::large(63, patient(), Service::Thread)?, SERVED, 0)?;
    enter("63 victims present", target, Box::new(move || rescue.round(0)));
    // Where the time goes: without the third thread, and without its fight for
    // the books.
    let rescue = Rescue::new(agency::runtime(1, patient())?, SERVING, 0)?;
    let name = "1 victim present, the sensors serve too";
    enter(name, Target::None, Box::new(move || rescue.round(0)));
    let rescue = Rescue::new(agency::large(1, patient(), Service::Nobody)?, SERVING, 0)?;
    let name = "1 victim present, no service thread";
    enter(name, Target::None, Box::new(move || rescue.round(0)));
    let rescue = Rescue::new(agency::large(63, patient(), Service::Nobody)?, SERVING, 0)?;
    let name = "63 victims present, no service thread";
    enter(name, Target::None, Box::new(move || rescue.round(0)));
    Ok(held)
}

fn enter_crowds(emergencies: &mut Emergencies<'_>) -> Result<[Entrant; 4], Failure> {
    let mut crowds = Vec::new();
    for tickets in TICKETS {
        let crowd = Rescue::new(agency::large(1, patient(), Service::Thread)?, SERVED, tickets)?;
        crowds.push(emergencies.enter(format!("{tickets} tickets"), move || crowd.round(0)));
    }
    crowds.try_into().map_err(|_| "a crowd is missing".into())
}

fn against_the_floor(bench: &mut Bench, times: &Times, floor: Entrant, held: &[Held]) {
    let floor = times.of(floor);
    for Held { name, entrant, target } in held {
        let times = times.of(*entrant);
        let (p999, median) = (times.p999 / floor.p999, times.median / floor.median);
        bench.figure(10, &format!("emergency, {name}: p99.9 / floor's"), p999, "x", *target);
        bench.figure(
            10,
            &format!("emergency, {name}: median / floor's"),
            median,
            "x",
            Target::None,
        );
        bench.figure(
            10,
            &format!("emergency, {name}: p99.9"),
            times.p999 / 1e3,
            "us",
            Target::None,
        );
    }
    bench.figure(10, "emergency, the floor: p99.9", floor.p999 / 1e3, "us", Target::None);
}

/// Flat in the tickets.
fn over_tickets(bench: &mut Bench, times: &Times, crowds: [Entrant; 4], floor: Entrant) {
    let [few, .., many] = crowds.map(|crowd| times.of(crowd));
    let ratio = many.median / few.median;
    bench.figure(10, "emergency, 60 000 tickets / 1, medians", ratio, "x", Target::AtMost(1.05));
    let ratio = many.p999 / few.p999;
    bench.figure(10, "emergency, 60 000 tickets / 1, p99.9", ratio, "x", Target::None);
    let title = "From the request until the cutoff is commanded";
    let curve = Curve::new("emergency-tickets", title, "tickets", "us").log_x();
    let over = |value: fn(support::Quantiles) -> f64, entrants: [Entrant; 4]| {
        let us = entrants.map(|entrant| value(times.of(entrant)) / 1e3);
        TICKETS.into_iter().map(|tickets| tickets as f64).zip(us).collect()
    };
    bench.curve(
        curve
            .with(Series::new("median", over(|times| times.median, crowds)))
            .with(Series::new("99.9th percentile", over(|times| times.p999, crowds)))
            .with(Series::new("floor, median", over(|times| times.median, [floor; 4])))
            .with(Series::new("floor, 99.9th percentile", over(|times| times.p999, [floor; 4]))),
    );
}
