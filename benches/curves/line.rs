//! The roster that the agents stand on, against what the standard library has:
//! a `BTreeSet`, and a `Vec` that is kept sorted.

use std::collections::BTreeSet;

use faregate_agents::measure::Lines;
use faregate_tickets::id::Priority;

use crate::count::Case;
use crate::stage::{SEATS, TICKETS};
use crate::support::{Bench, Curve, Series};

const SIZES: [usize; 7] = [16, 64, 256, 1_024, 4_096, 16_384, TICKETS];
const ROUNDS: u32 = 200;
/// The same seats in each run.
const SEED: u64 = 1;

/// A line that one leaves and joins again.
trait Line {
    fn join(&mut self, level: u8, seat: u16);
    fn leave(&mut self, level: u8, seat: u16);
    fn first(&self) -> Option<usize>;
}

struct Ours(Box<Lines<1, SEATS>>);

impl Line for Ours {
    fn join(&mut self, level: u8, seat: u16) {
        self.0.join(0, Priority::new(level), seat);
    }

    fn leave(&mut self, level: u8, seat: u16) {
        self.0.leave(0, Priority::new(level), seat);
    }

    fn first(&self) -> Option<usize> {
        self.0.first(0)
    }
}

/// The most important first, then the order of arrival: what a key of the
/// others has to say.
type Place = (u8, u64, u16);

/// Who came when: the others cannot find a seat without it.
#[derive(Default)]
struct Arrivals {
    next: u64,
    of: Vec<u64>,
}

impl Arrivals {
    fn new() -> Self {
        Self { next: 0, of: vec![0; SEATS] }
    }

    fn arrive(&mut self, level: u8, seat: u16) -> Place {
        self.next += 1;
        self.of[usize::from(seat)] = self.next;
        self.place(level, seat)
    }

    fn place(&self, level: u8, seat: u16) -> Place {
        (u8::MAX - level, self.of[usize::from(seat)], seat)
    }
}

struct Tree(BTreeSet<Place>, Arrivals);

impl Line for Tree {
    fn join(&mut self, level: u8, seat: u16) {
        self.0.insert(self.1.arrive(level, seat));
    }

    fn leave(&mut self, level: u8, seat: u16) {
        self.0.remove(&self.1.place(level, seat));
    }

    fn first(&self) -> Option<usize> {
        self.0.first().map(|place| place.2.into())
    }
}

struct Sorted(Vec<Place>, Arrivals);

impl Line for Sorted {
    fn join(&mut self, level: u8, seat: u16) {
        let place = self.1.arrive(level, seat);
        let at = self.0.partition_point(|other| *other < place);
        self.0.insert(at, place);
    }

    fn leave(&mut self, level: u8, seat: u16) {
        if let Ok(at) = self.0.binary_search(&self.1.place(level, seat)) {
            self.0.remove(at);
        }
    }

    fn first(&self) -> Option<usize> {
        self.0.first().map(|place| place.2.into())
    }
}

/// A line with so many seats in it, and a way to draw one of them.
struct Queue<L> {
    line: L,
    levels: Vec<u8>,
    random: fastrand::Rng,
}

impl<L: Line> Queue<L> {
    /// At all levels from 0 to this one.
    fn new(line: L, size: usize, highest: u8) -> Self {
        let mut random = fastrand::Rng::with_seed(SEED);
        let levels = std::iter::repeat_with(|| random.u8(..=highest)).take(size).collect();
        let mut queue = Self { line, levels, random };
        for seat in 0..size {
            queue.line.join(queue.levels[seat], seat_number(seat));
        }
        queue
    }

    /// One leaves, joins again, and somebody looks who is first.
    #[inline(never)]
    fn turn(&mut self) -> Option<usize> {
        let seat = self.random.usize(..self.levels.len());
        let (level, seat) = (self.levels[seat], seat_number(seat));
        self.line.leave(level, seat);
        self.line.join(level, seat);
        self.line.first()
    }
}

fn seat_number(seat: usize) -> u16 {
    u16::try_from(seat).expect("seats have 16 bits")
}

fn ours(size: usize, highest: u8) -> Queue<Ours> {
    Queue::new(Ours(Box::new(Lines::new())), size, highest)
}

fn label(size: usize) -> String {
    format!("roster of {size}")
}

/// All at one level: whoever leaves has a neighbour, in the small line too.
pub(crate) fn cases() -> impl Iterator<Item = Case> {
    [SIZES[0], TICKETS].into_iter().map(|size| {
        let mut queue = ours(size, 0);
        Case::new(label(size), move || {
            std::hint::black_box(queue.turn());
        })
    })
}

pub(crate) fn names() -> (String, String) {
    (label(TICKETS), label(SIZES[0]))
}

/// The curve over what stands in line.
pub(crate) fn measure(bench: &mut Bench) {
    let mut contest = bench.contest("roster").rounds(ROUNDS.min(bench.rounds()));
    let entrants = SIZES.map(|size| {
        let mut roster = ours(size, u8::MAX);
        let mut tree = Queue::new(Tree(BTreeSet::new(), Arrivals::new()), size, u8::MAX);
        let mut sorted = Queue::new(Sorted(Vec::new(), Arrivals::new()), size, u8::MAX);
        [
            contest.enter(label(size), move |n| turns(&mut roster, n)),
            contest.enter(format!("BTreeSet of {size}"), move |n| turns(&mut tree, n)),
            contest.enter(format!("sorted Vec of {size}"), move |n| turns(&mut sorted, n)),
        ]
    });
    let times = contest.run();
    let curve =
        Curve::new("roster", "One leaves the line and joins it again", "tickets in line", "ns");
    let names = ["roster (Faregate)", "BTreeSet", "sorted Vec"];
    let curve = names.into_iter().enumerate().fold(curve.log_x().log_y(), |curve, (way, name)| {
        let ns = entrants.map(|entrants| times.of(entrants[way]).p5);
        let points = SIZES.into_iter().zip(ns).map(|(size, ns)| (size as f64, ns));
        curve.with(Series::new(name, points.collect()))
    });
    bench.curve(curve);
    bench.peers(&times);
}

fn turns(queue: &mut Queue<impl Line>, n: u64) {
    for _ in 0..n {
        std::hint::black_box(queue.turn());
    }
}
