//! Row 8: one ticket among 60 000, and one almost alone. Barring, requesting
//! and relinquishing cost what one ticket costs, in a broker with room for
//! [`SEATS`] as in one with room for [`FEW_SEATS`]: a look at every seat would
//! show, whether anybody sits there or not.

use std::cell::{Cell, RefCell};
use std::hint::black_box;
use std::rc::Rc;
use std::time::{Duration, Instant};

use faregate_agents::{Policy, Supervisor};
use faregate_tickets::id::{Priority, TicketId};
use faregate_tickets::standing::Standing;

use crate::count::{Case, Counts};
use crate::stage::{Agents, SEATS, Stage, TICKETS, Ticket};
use crate::support::{Bench, Contest, Entrant, Failure, Target};

/// Co-prime to every number of tickets here: steps of it come by all of them,
/// and never by a neighbour in memory.
const STRIDE: usize = 7_919;
/// Seats of the small broker.
const FEW_SEATS: usize = 64;
const CROWDS: [usize; 2] = [1, TICKETS];
/// Of a request, with its own ticket: behind two that are more important, one
/// of them valid, and one of the same level; and among as many more. Alone it
/// would be granted, which is not the same work.
const COMPANIES: [usize; 2] = [4, TICKETS];

/// What caches may add.
const WITHIN: Target = Target::AtMost(1.5);

/// A broker with so many tickets, its first one valid.
struct Many<const T: usize> {
    stage: Stage<T>,
    tickets: RefCell<Vec<Ticket<T>>>,
    ids: Vec<TicketId>,
    next: Cell<usize>,
}

impl<const T: usize> Many<T> {
    fn new(tickets: usize) -> Self {
        let (stage, tickets) = Stage::crowded(1, Policy::unlimited(), tickets);
        let ids = tickets.iter().map(Ticket::id).collect();
        Self { stage, tickets: RefCell::new(tickets), ids, next: Cell::new(0) }
    }

    /// Room for one ticket more than there are.
    fn with_room(company: usize) -> Self {
        Self::new(company - 1)
    }

    fn bar(&self, ticket: usize) {
        bar(self.stage.agents, &self.stage.supervisor, self.ids[ticket]);
    }

    fn enter_safe_mode(&self) {
        safe_mode(self.stage.agents, &self.stage.supervisor);
    }

    /// Another ticket each time.
    fn next(&self) -> usize {
        self.next.set((self.next.get() + STRIDE) % self.ids.len());
        self.next.get()
    }

    fn request(&self) -> Ticket<T> {
        request(self.stage.agents, &self.stage)
    }

    /// Gives one ticket back, and asks for another in its place.
    fn replace(&self, ticket: usize) {
        let mut tickets = self.tickets.borrow_mut();
        let last = tickets.len() - 1;
        tickets.swap(ticket, last);
        tickets.pop();
        tickets.push(self.request());
    }

    /// So many times, without the service that comes after.
    fn timed(&self, n: u64, operation: impl Fn()) -> Duration {
        let start = Instant::now();
        for _ in 0..n {
            operation();
        }
        let took = start.elapsed();
        self.stage.serve();
        took
    }
}

/// As many standings without a broker, and who is in them: what the caches ask
/// for barring another ticket each time, and nothing else.
struct Bare {
    ids: Vec<TicketId>,
    standings: Vec<Standing>,
    next: usize,
}

impl Bare {
    fn new(ids: &[TicketId]) -> Self {
        let ids = ids.to_vec();
        let standings: Vec<_> = ids.iter().map(|_| Standing::new()).collect();
        for id in &ids {
            standings[usize::from(id.seat)].seat(id.serial, 1);
        }
        Self { ids, standings, next: 0 }
    }

    #[inline(never)]
    fn bar(&mut self) {
        self.next = (self.next + STRIDE) % self.ids.len();
        let TicketId { seat, serial } = self.ids[self.next];
        let standing = &self.standings[usize::from(seat)];
        if standing.is_occupied_by(serial) {
            standing.bar(serial);
        }
    }
}

#[inline(never)]
fn bar<const T: usize>(agents: &Agents<T>, supervisor: &Supervisor, ticket: TicketId) {
    let barred = agents.bar(supervisor, black_box(ticket));
    barred.expect("the ticket lives").without_waiting();
}

#[inline(never)]
fn safe_mode<const T: usize>(agents: &Agents<T>, supervisor: &Supervisor) {
    let revoked = agents.enter_safe_mode(supervisor, black_box(Priority::EMERGENCY));
    revoked.expect("the supervisor is this broker's").without_waiting();
}

#[inline(never)]
fn request<const T: usize>(agents: &'static Agents<T>, stage: &Stage<T>) -> Ticket<T> {
    agents.request(black_box(Priority::SCIENCE), &stage.lamps[0]).expect("there is a seat")
}

#[inline(never)]
fn relinquish<const T: usize>(ticket: Option<Ticket<T>>) {
    drop(black_box(ticket));
}

fn label<const T: usize>(what: &str, tickets: usize) -> String {
    format!("{what}, among {tickets}, room for {T}")
}

/// What is done to one ticket, and how it is named.
const BAR: &str = "bar one";
const SAFE_MODE: &str = "safe mode";
const REQUEST: &str = "request";
const RELINQUISH: &str = "relinquish";

pub(crate) fn cases() -> impl Iterator<Item = Case> {
    let few = revoking_cases::<FEW_SEATS>(CROWDS[0]).into_iter();
    let few = few.chain(asking_cases::<FEW_SEATS>(COMPANIES[0]));
    let many = CROWDS.into_iter().flat_map(revoking_cases::<SEATS>);
    few.chain(many).chain(COMPANIES.into_iter().flat_map(asking_cases::<SEATS>))
}

fn revoking_cases<const T: usize>(size: usize) -> [Case; 2] {
    let [barring, safing] = [(); 2].map(|()| Many::<T>::new(size));
    [
        Case::new(label::<T>(BAR, size), move || barring.bar(0)),
        Case::new(label::<T>(SAFE_MODE, size), move || safing.enter_safe_mode()),
    ]
}

fn asking_cases<const T: usize>(size: usize) -> [Case; 2] {
    let crowd = Rc::new(Many::<T>::with_room(size));
    let held = Rc::new(RefCell::new(None));
    let [ask, hold, give, serve] = [(); 4].map(|()| (Rc::clone(&crowd), Rc::clone(&held)));
    [
        Case::new(label::<T>(REQUEST, size), move || *ask.1.borrow_mut() = Some(ask.0.request()))
            .once()
            .after(move || {
                hold.1.borrow_mut().take();
                hold.0.stage.serve();
            }),
        Case::new(label::<T>(RELINQUISH, size), move || relinquish(give.1.borrow_mut().take()))
            .once()
            .after(move || {
                serve.1.borrow_mut().take();
                serve.0.stage.serve();
                *serve.1.borrow_mut() = Some(serve.0.request());
            }),
    ]
}

pub(crate) fn measure(bench: &mut Bench, counts: Option<&Counts>) -> Result<(), Failure> {
    time_barring(bench);
    time_asking(bench);
    let few = [(BAR, CROWDS), (SAFE_MODE, CROWDS), (REQUEST, COMPANIES), (RELINQUISH, COMPANIES)];
    for (what, [few, many]) in few {
        let names = (label::<SEATS>(what, many), label::<SEATS>(what, few));
        let figure = format!("{what}, among 60 000 / among {few}");
        crate::instructions(bench, 8, &figure, counts, &names)?;
        // Other code, in which the compiler may have found other instructions.
        crate::count_of(bench, 8, &label::<FEW_SEATS>(what, few), counts)?;
    }
    Ok(())
}

/// Entrants that bar the same ticket, another each time, and another of the
/// same words without a broker.
fn enter_barring<'a, const T: usize>(
    contest: &mut Contest<'a>,
    crowd: &'a Many<T>,
) -> [Entrant; 3] {
    let size = crowd.ids.len();
    let mut bare = Bare::new(&crowd.ids);
    [
        contest.enter(label::<T>(BAR, size), move |n| {
            (0..n).for_each(|_| crowd.bar(0));
        }),
        contest.enter(label::<T>("bar another each time", size), move |n| {
            (0..n).for_each(|_| crowd.bar(crowd.next()));
        }),
        contest.enter(label::<T>("bare words of another each time", size), move |n| {
            (0..n).for_each(|_| bare.bar());
        }),
    ]
}

fn time_barring(bench: &mut Bench) {
    // Nothing serves these: what follows a bar has its own curve.
    let (one, many) = (Many::<FEW_SEATS>::new(CROWDS[0]), Many::<SEATS>::new(CROWDS[1]));
    let mut contest = bench.contest("bar");
    let one = enter_barring(&mut contest, &one);
    let many = enter_barring(&mut contest, &many);
    let times = contest.run();
    let figures = [
        ("bar the same one, among 60 000 / 1", WITHIN),
        ("bar another each time, among 60 000 / 1", WITHIN),
        ("the same of bare words, without a broker, 60 000 / 1", Target::None),
    ];
    for (pair, (name, target)) in many.into_iter().zip(one).zip(figures) {
        bench.ratio(8, name, &times, pair, target);
    }
    bench.peers(&times);
}

/// Entrants that ask and give back, and that take another's place each time.
fn enter_asking<'a, const T: usize>(contest: &mut Contest<'a>, crowd: &'a Many<T>) -> [Entrant; 2] {
    let size = crowd.ids.len() + 1;
    [
        contest.enter_timed(label::<T>("request and relinquish", size), |n| {
            crowd.timed(n, || relinquish(Some(crowd.request())))
        }),
        contest.enter_timed(label::<T>("relinquish another each time and request", size), |n| {
            crowd.timed(n, || crowd.replace(crowd.next()))
        }),
    ]
}

fn time_asking(bench: &mut Bench) {
    let few = Many::<FEW_SEATS>::with_room(COMPANIES[0]);
    let many = Many::<SEATS>::with_room(COMPANIES[1]);
    let mut contest = bench.contest("request");
    let few = enter_asking(&mut contest, &few);
    let many = enter_asking(&mut contest, &many);
    let times = contest.run();
    let names = ["request and relinquish", "relinquish another each time and request"];
    for (pair, name) in many.into_iter().zip(few).zip(names) {
        bench.ratio(8, &format!("{name}, among 60 000 / 4"), &times, pair, WITHIN);
    }
    bench.peers(&times);
}
