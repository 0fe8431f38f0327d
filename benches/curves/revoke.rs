//! Row 7, **Constant Revoke**: revoking all tickets is one increment, however
//! many there are. Beside it what it would cost one by one, and as the children
//! of a `CancellationToken`.
//!
//! A broker has at most 65 534 seats. What revokes is not the broker but the
//! scope, the standings and the gates beneath it, and of those there can be
//! 100 000: each ticket here is the tenant of its own gate and valid, and after
//! the one increment none is.

use std::hint::black_box;
use std::time::{Duration, Instant};

use faregate_tickets::clock::Duration as Timeout;
use faregate_tickets::gate::Admission;
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::recorder::Unrecorded;
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::{Stamp, Standing, Why};
use faregate_tickets::ticket::{Holder, Issuer, Seat, Ticket};
use faregate_tickets::validity::Validity;
use tokio_util::sync::CancellationToken;

use crate::count::{Case, Counts};
use crate::stage::{Hand, Lamp, Ports, gate, leak};
use crate::support::{Bench, Curve, Failure, Series, Target};

const SIZES: [usize; 6] = [1, 10, 100, 1_000, 10_000, 100_000];
const MOST: usize = SIZES[SIZES.len() - 1];
/// Rounds of the contest in which something is revoked one by one.
const SLOW_ROUNDS: u32 = 40;

/// Who takes these tickets back: nobody, they live as long as the bench.
struct Nobody;

impl Issuer for Nobody {
    fn relinquish(&self, _: &Seat<'_>, _: Unrecorded, _: Holder) {}
}

/// As many valid tickets as this, all of one agent.
struct Crowd {
    agent: &'static Scope,
    standings: &'static [Standing],
    tickets: Vec<Ticket<'static, Lamp, Ports, Nobody>>,
}

impl Crowd {
    fn new(size: usize) -> Self {
        let hand: &'static Hand = leak(Hand::default());
        let (agent, broker): (&'static Scope, &'static Scope) =
            (leak(Scope::new()), leak(Scope::new()));
        let standings: &'static [Standing] =
            (0..size).map(|_| Standing::new()).collect::<Vec<_>>().leak();
        let gates = (0..size).map(|_| gate(hand).0).collect::<Vec<_>>().leak();
        let tickets = gates.iter_mut().zip(standings).zip(1..).map(|((gate, standing), serial)| {
            standing.seat(serial, 1);
            let (key, handle) = gate.key().split();
            let stamp = Stamp { own: standing.epoch_seen(), broker: broker.read().epoch };
            let admission = Admission {
                serial,
                tenure: 0,
                agent: agent.read().epoch,
                validity: Validity::always(),
                stamp: Some((standing, stamp)),
            };
            key.admit(admission, Timeout::ZERO).expect("nobody is inside a new gate");
            // Who says which seat it is, in a broker; here nobody asks.
            let id = TicketId { seat: 0, serial };
            let seat = Seat { id, gate: GateId(0), standing, agent, broker };
            leak(key).ticket(handle, seat, &Nobody).expect("the handle is this key's")
        });
        Self { agent, standings, tickets: tickets.collect() }
    }

    fn revoke_all(&self) {
        revoke_all(black_box(self.agent));
    }

    fn valid(&self) -> usize {
        self.tickets.iter().filter(|ticket| ticket.check().is_ok()).count()
    }
}

#[inline(never)]
fn revoke_all(agent: &Scope) {
    agent.revoke_all();
}

#[inline(never)]
fn revoke_each(standings: &[Standing]) {
    for standing in standings {
        standing.revoke(Why::RevokedAll);
    }
}

/// Makes a token with so many children, and times what cancelling it takes.
fn cancel(size: usize) -> Duration {
    let parent = CancellationToken::new();
    let children: Vec<_> = (0..size).map(|_| parent.child_token()).collect();
    let start = Instant::now();
    black_box(&parent).cancel();
    let took = start.elapsed();
    assert!(children.iter().all(CancellationToken::is_cancelled));
    took
}

fn label(size: usize) -> String {
    format!("revoke all, {size} tickets")
}

pub(crate) fn cases() -> impl Iterator<Item = Case> {
    [1, MOST].into_iter().map(|size| {
        let crowd = Crowd::new(size);
        Case::new(label(size), move || crowd.revoke_all())
    })
}

pub(crate) fn measure(bench: &mut Bench, counts: Option<&Counts>) -> Result<(), Failure> {
    let crowds = SIZES.map(Crowd::new);
    for (crowd, size) in crowds.iter().zip(SIZES) {
        let valid = (crowd.valid(), {
            crowd.revoke_all();
            crowd.valid()
        });
        if valid != (size, 0) {
            return Err(format!("{size} tickets, valid before and after: {valid:?}").into());
        }
    }
    against_itself(bench, &crowds);
    against_others(bench, &crowds);
    let names = (label(MOST), label(1));
    crate::instructions(bench, 7, "revoke all, 100 000 tickets / 1", counts, &names)
}

/// The figure: 100 000 against 1.
fn against_itself(bench: &mut Bench, crowds: &[Crowd; SIZES.len()]) {
    let mut contest = bench.contest("revoke all");
    let entrants = crowds.each_ref().map(|crowd| {
        contest.enter(label(crowd.standings.len()), |n| {
            for _ in 0..n {
                crowd.revoke_all();
            }
        })
    });
    let times = contest.run();
    let [one, .., most] = entrants;
    bench.ratio(7, "revoke all, 100 000 tickets / 1", &times, (most, one), Target::AtMost(1.05));
    bench.peers(&times);
}

/// The curve: in the tickets, beside those who go from one to the next.
fn against_others(bench: &mut Bench, crowds: &[Crowd; SIZES.len()]) {
    let mut contest = bench.contest("revoke").rounds(SLOW_ROUNDS.min(bench.rounds()));
    let entrants = crowds.each_ref().map(|crowd| {
        let size = crowd.standings.len();
        [
            contest.enter(format!("one increment for {size}"), |n| {
                for _ in 0..n {
                    crowd.revoke_all();
                }
            }),
            contest.enter(format!("each of {size}"), |n| {
                for _ in 0..n {
                    revoke_each(black_box(crowd.standings));
                }
            }),
            contest.enter_timed(format!("CancellationToken with {size} children"), move |n| {
                (0..n).map(|_| cancel(size)).sum()
            }),
        ]
    });
    let times = contest.run();
    let names = ["one increment (Faregate)", "one by one", "CancellationToken and its children"];
    let curve = Curve::new("revoke-tickets", "Revoking all tickets", "tickets", "ns");
    let curve = names.into_iter().enumerate().fold(curve.log_x().log_y(), |curve, (way, name)| {
        let ns = entrants.map(|entrants| times.of(entrants[way]).p5);
        let points = SIZES.into_iter().zip(ns).map(|(size, ns)| (size as f64, ns));
        curve.with(Series::new(name, points.collect()))
    });
    bench.curve(curve);
    bench.peers(&times);
}
