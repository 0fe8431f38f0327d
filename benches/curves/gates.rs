//! Row 8, in the gates: what one decision costs with 1 to 64 of them, and how
//! long revoking everything takes until nothing is in progress, and until all
//! devices are made safe.

use std::hint::black_box;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use faregate_agents::{Actions, Books, Event, Policy};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::id::Priority;

use crate::count::{Case, Counts};
use crate::stage::{Stage, Ticket};
use crate::support::{Bench, Curve, Failure, Series};

const SIZES: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Those of which the instructions are counted.
const COUNTED: [usize; 4] = [1, 4, 16, 64];
const ROUNDS: u32 = 200;
/// Room for two tickets a gate, and what is kept for fault responses.
const SEATS: usize = 256;

/// Policies that a decision has to look at, the shortest and the longest.
fn policies() -> [(&'static str, Policy); 2] {
    let margin = Policy::power_margin(Milliwatts::from_watts(64));
    [("power margin", margin), ("power margin and conflict categories", margin.with_categories())]
}

/// Books in which every gate has a tenant and one more in line.
fn books(gates: usize, policy: Policy) -> Box<Books<64, SEATS, 2>> {
    let (stage, _tickets) = Stage::<SEATS>::crowded(gates, policy, 2 * gates);
    Box::new(stage.agents.books().expect("nobody is inside"))
}

#[inline(never)]
fn decide(books: &mut Books<64, SEATS, 2>, event: Event, actions: &mut Actions<64>) {
    books.step(black_box(event), actions);
    black_box(&*actions);
}

/// What decides, and nothing happens: time stands still.
fn decision(gates: usize, policy: Policy) -> impl FnMut() {
    let mut books = books(gates, policy);
    let event = Event::Tick(faregate_tickets::clock::Instant::START);
    let mut actions = Actions::new();
    move || decide(&mut books, event, &mut actions)
}

fn label(policy: &str, gates: usize) -> String {
    format!("decision, {policy}, {gates} gates")
}

pub(crate) fn cases() -> impl Iterator<Item = Case> {
    policies().into_iter().flat_map(|(name, policy)| {
        COUNTED
            .into_iter()
            .map(move |gates| Case::new(label(name, gates), decision(gates, policy)).once())
    })
}

pub(crate) fn measure(bench: &mut Bench, counts: Option<&Counts>) -> Result<(), Failure> {
    time_decisions(bench);
    if let Some(counts) = counts {
        count_decisions(bench, counts)?;
    }
    time_revoking(bench)
}

fn points<const N: usize>(
    sizes: [usize; N],
    values: impl IntoIterator<Item = f64>,
) -> Vec<(f64, f64)> {
    sizes.into_iter().map(|size| size as f64).zip(values).collect()
}

fn time_decisions(bench: &mut Bench) {
    let mut contest = bench.contest("decision").rounds(ROUNDS.min(bench.rounds()));
    let entrants = policies().map(|(name, policy)| {
        SIZES.map(|gates| {
            let mut decide = decision(gates, policy);
            contest.enter(label(name, gates), move |n| (0..n).for_each(|_| decide()))
        })
    });
    let times = contest.run();
    let curve = Curve::new("decision-gates", "One decision", "gates", "ns").log_x().log_y();
    let curve = policies().into_iter().zip(entrants).fold(curve, |curve, ((name, _), entrants)| {
        curve.with(Series::new(name, points(SIZES, entrants.map(|entrant| times.of(entrant).p5))))
    });
    bench.curve(curve);
    bench.peers(&times);
}

fn count_decisions(bench: &mut Bench, counts: &Counts) -> Result<(), Failure> {
    let curve = Curve::new("decision-instructions", "One decision", "gates", "instructions")
        .log_x()
        .log_y();
    let mut curve = curve;
    for (name, _) in policies() {
        let counted = COUNTED.map(|gates| counts.of(&label(name, gates)));
        let counted: Option<Vec<u64>> = counted.into_iter().collect();
        let counted = counted.ok_or("a decision was not counted")?;
        curve =
            curve.with(Series::new(name, points(COUNTED, counted.into_iter().map(|n| n as f64))));
    }
    bench.curve(curve);
    Ok(())
}

/// Every gate held, and its lamp on.
struct Lit {
    stage: Stage<SEATS>,
    tickets: Vec<Ticket<SEATS>>,
}

impl Lit {
    fn new(gates: usize) -> Result<Self, Failure> {
        let (_, policy) = policies()[0];
        let (stage, tickets) = Stage::crowded(gates, policy, gates);
        let lit = Self { stage, tickets };
        lit.light()?;
        Ok(lit)
    }

    fn light(&self) -> Result<(), Failure> {
        for ticket in &self.tickets {
            ticket.invoke(true).map_err(|error| format!("a lamp does not go on: {error:?}"))?;
        }
        Ok(())
    }

    fn lamps_on(&self) -> usize {
        let on = |register: &&crate::stage::Register| register.on.load(Ordering::Relaxed) != 0;
        self.stage.registers.iter().copied().filter(on).count()
    }

    /// Revokes everything, until no command is in progress, so many times.
    fn quiesce(&self, n: u64) -> Result<Duration, Failure> {
        let Stage { agents, supervisor, .. } = &self.stage;
        let start = Instant::now();
        for _ in 0..n {
            agents.enter_safe_mode(supervisor, Priority::EMERGENCY)?.quiesce()?;
        }
        Ok(start.elapsed())
    }

    /// Revokes everything, until every lamp has been made safe; then lets all
    /// come back.
    fn make_safe(&self) -> Result<Duration, Failure> {
        let Stage { agents, supervisor, .. } = &self.stage;
        let all = self.lamps_on();
        let start = Instant::now();
        agents.enter_safe_mode(supervisor, Priority::EMERGENCY)?.without_waiting();
        agents.service();
        let took = start.elapsed();
        let lamps = (all, self.lamps_on());
        if lamps != (self.tickets.len(), 0) {
            return Err(format!("lamps on before and after: {lamps:?}").into());
        }
        self.restore()?;
        Ok(took)
    }

    fn restore(&self) -> Result<(), Failure> {
        let Stage { agents, supervisor, .. } = &self.stage;
        agents.leave_safe_mode(supervisor)?;
        self.stage.see_off();
        self.light()
    }
}

fn time_revoking(bench: &mut Bench) -> Result<(), Failure> {
    let mut lit = Vec::new();
    for gates in SIZES {
        lit.push((Lit::new(gates)?, Lit::new(gates)?));
    }
    let failed = crate::Failed::default();
    let mut contest = bench.contest("revoke all until").rounds(ROUNDS.min(bench.rounds()));
    let failed = &failed;
    let entrants: Vec<_> = lit
        .iter()
        .zip(SIZES)
        .map(|((passed, safed), gates)| {
            let quiescent = contest.enter_timed(format!("quiescent, {gates} gates"), move |n| {
                failed.unless(|| passed.quiesce(n))
            });
            let safe = contest.enter_timed(format!("all safe, {gates} gates"), move |n| {
                (0..n).map(|_| failed.unless(|| safed.make_safe())).sum()
            });
            [quiescent, safe]
        })
        .collect();
    let times = contest.run();
    failed.check()?;
    let title = "From revoking everything until";
    let curve = Curve::new("revoke-gates", title, "gates", "ns").log_x().log_y();
    let ends = ["nothing is in progress", "all devices are made safe"];
    let curve = ends.into_iter().enumerate().fold(curve, |curve, (end, name)| {
        let ns = entrants.iter().map(|entrants| times.of(entrants[end]).p5);
        curve.with(Series::new(name, points(SIZES, ns)))
    });
    bench.curve(curve);
    bench.peers(&times);
    Ok(())
}
