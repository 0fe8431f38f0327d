//! Row 8: one ticket among 60 000, and one almost alone. Barring, requesting
//! and relinquishing cost what one ticket costs.

use std::cell::{Cell, RefCell};
use std::hint::black_box;
use std::rc::Rc;
use std::time::{Duration, Instant};

use faregate_agents::{Policy, Supervisor};
use faregate_tickets::id::{Priority, TicketId};
use faregate_tickets::standing::Standing;

use crate::count::{Case, Counts};
use crate::stage::{Agents, SEATS, Stage, TICKETS, Ticket};
use crate::support::{Bench, Failure, Target};

/// Co-prime to every number of tickets here: steps of it come by all of them,
/// and never by a neighbour in memory.
const STRIDE: usize = 7_919;
const CROWDS: [usize; 2] = [1, TICKETS];
/// Of a request, with its own ticket: behind two that are more important, one
/// of them valid, and one of the same level; and among as many more. Alone it
/// would be granted, which is not the same work.
const COMPANIES: [usize; 2] = [4, TICKETS];

/// What caches may add.
const WITHIN: Target = Target::AtMost(1.5);

/// A broker with so many tickets, its first one valid.
struct Many {
    stage: Stage<SEATS>,
    tickets: RefCell<Vec<Ticket<SEATS>>>,
    ids: Vec<TicketId>,
    next: Cell<usize>,
}

impl Many {
    fn new(tickets: usize) -> Self {
        let (stage, tickets) = Stage::crowded(1, Policy::unlimited(), tickets);
        let ids = tickets.iter().map(Ticket::id).collect();
        Self { stage, tickets: RefCell::new(tickets), ids, next: Cell::new(0) }
    }

    /// Room for one ticket more than there are.
    fn with_room(company: usize) -> Self {
        Self::new(company - 1)
    }

    /// Another ticket each time.
    fn next(&self) -> usize {
        self.next.set((self.next.get() + STRIDE) % self.ids.len());
        self.next.get()
    }

    fn request(&self) -> Ticket<SEATS> {
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
    fn new(crowd: &Many) -> Self {
        let ids = crowd.ids.clone();
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
fn bar(agents: &Agents<SEATS>, supervisor: &Supervisor, ticket: TicketId) {
    if let Ok(revoked) = agents.bar(supervisor, black_box(ticket)) {
        revoked.without_waiting();
    }
}

#[inline(never)]
fn safe_mode(agents: &Agents<SEATS>, supervisor: &Supervisor) {
    if let Ok(revoked) = agents.enter_safe_mode(supervisor, Priority::EMERGENCY) {
        revoked.without_waiting();
    }
}

#[inline(never)]
fn request(agents: &'static Agents<SEATS>, stage: &Stage<SEATS>) -> Ticket<SEATS> {
    agents.request(black_box(Priority::SCIENCE), &stage.lamps[0]).expect("there is a seat")
}

#[inline(never)]
fn relinquish(ticket: Option<Ticket<SEATS>>) {
    drop(black_box(ticket));
}

fn label(what: &str, tickets: usize) -> String {
    format!("{what}, among {tickets}")
}

/// What is done to one ticket, and how it is named.
const BAR: &str = "bar one";
const SAFE_MODE: &str = "safe mode";
const REQUEST: &str = "request";
const RELINQUISH: &str = "relinquish";

pub(crate) fn cases() -> impl Iterator<Item = Case> {
    revoking_cases().chain(asking_cases())
}

fn revoking_cases() -> impl Iterator<Item = Case> {
    CROWDS.into_iter().flat_map(|size| {
        let (barring, safing) = (Many::new(size), Many::new(size));
        let id = barring.ids[0];
        [
            Case::new(label(BAR, size), move || {
                bar(barring.stage.agents, &barring.stage.supervisor, id);
            }),
            Case::new(label(SAFE_MODE, size), move || {
                safe_mode(safing.stage.agents, &safing.stage.supervisor);
            }),
        ]
    })
}

fn asking_cases() -> impl Iterator<Item = Case> {
    COMPANIES.into_iter().flat_map(|size| {
        let crowd = Rc::new(Many::with_room(size));
        let held = Rc::new(RefCell::new(None));
        let [ask, hold, give, serve] = [(); 4].map(|()| (Rc::clone(&crowd), Rc::clone(&held)));
        [
            Case::new(label(REQUEST, size), move || *ask.1.borrow_mut() = Some(ask.0.request()))
                .once()
                .after(move || {
                    hold.1.borrow_mut().take();
                    hold.0.stage.serve();
                }),
            Case::new(label(RELINQUISH, size), move || relinquish(give.1.borrow_mut().take()))
                .once()
                .after(move || {
                    serve.1.borrow_mut().take();
                    serve.0.stage.serve();
                    *serve.1.borrow_mut() = Some(serve.0.request());
                }),
        ]
    })
}

pub(crate) fn measure(bench: &mut Bench, counts: Option<&Counts>) -> Result<(), Failure> {
    time_barring(bench);
    time_asking(bench);
    let few = [(BAR, CROWDS), (SAFE_MODE, CROWDS), (REQUEST, COMPANIES), (RELINQUISH, COMPANIES)];
    for (what, [few, many]) in few {
        let names = (label(what, many), label(what, few));
        let figure = format!("{what}, among 60 000 / among {few}");
        crate::instructions(bench, 8, &figure, counts, &names)?;
    }
    Ok(())
}

fn time_barring(bench: &mut Bench) {
    // Nothing serves these: what follows a bar has its own curve.
    let crowds = CROWDS.map(Many::new);
    let mut contest = bench.contest("bar");
    let entrants = crowds.each_ref().map(|crowd| {
        let (agents, supervisor) = (crowd.stage.agents, &crowd.stage.supervisor);
        let (size, first) = (crowd.ids.len(), crowd.ids[0]);
        let same = contest.enter(label(BAR, size), move |n| {
            for _ in 0..n {
                bar(agents, supervisor, first);
            }
        });
        let another = contest.enter(label("bar another each time", size), move |n| {
            for _ in 0..n {
                bar(agents, supervisor, crowd.ids[crowd.next()]);
            }
        });
        let mut bare = Bare::new(crowd);
        let bare = contest.enter(label("bare words of another each time", size), move |n| {
            (0..n).for_each(|_| bare.bar());
        });
        (same, another, bare)
    });
    let times = contest.run();
    let [one, many] = entrants;
    bench.ratio(8, "bar the same one, among 60 000 / 1", &times, (many.0, one.0), WITHIN);
    bench.ratio(8, "bar another each time, among 60 000 / 1", &times, (many.1, one.1), WITHIN);
    let name = "the same of bare words, without a broker, 60 000 / 1";
    bench.ratio(8, name, &times, (many.2, one.2), Target::None);
    bench.peers(&times);
}

fn time_asking(bench: &mut Bench) {
    let crowds = COMPANIES.map(Many::with_room);
    let mut contest = bench.contest("request");
    let entrants = crowds.each_ref().map(|crowd| {
        let size = crowd.ids.len() + 1;
        let same = contest.enter_timed(label("request and relinquish", size), |n| {
            crowd.timed(n, || relinquish(Some(crowd.request())))
        });
        let another = contest
            .enter_timed(label("relinquish another each time and request", size), |n| {
                crowd.timed(n, || crowd.replace(crowd.next()))
            });
        (same, another)
    });
    let times = contest.run();
    let [one, many] = entrants;
    let name = "request and relinquish, among 60 000 / 4";
    bench.ratio(8, name, &times, (many.0, one.0), WITHIN);
    let name = "relinquish another each time and request, among 60 000 / 4";
    bench.ratio(8, name, &times, (many.1, one.1), WITHIN);
    bench.peers(&times);
}
