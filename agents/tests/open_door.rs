//! **Open Door**: no refused holder, however many and however insistent, makes
//! a valid command fail. And **Closed Door**: none of theirs gets through.

mod bench;
#[path = "open_door/slow.rs"]
mod slow;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};

use bench::{Bench, Switch, drawing, margin};
use faregate_agents::Supervisor;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::Profile;
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;

const COMMANDS: usize = 5_000;

/// A lamp of whose commands nobody loses patience when this machine is busy.
fn patient() -> (Bench, Supervisor) {
    let profile = Profile { longest_command: Duration::from_secs(60), ..drawing(8) };
    Bench::with(margin(10), &[profile])
}

/// Says that it is over, also when an assertion fails.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, SeqCst);
    }
}

#[test]
fn refused_holders_that_hammer_cost_the_valid_one_no_command() {
    let (bench, supervisor) = patient();
    let refused: Vec<_> = (0..3).map(|_| bench.ticket(1, 0)).collect();
    let barred = refused[0].id();
    let valid = bench.ticket(9, 0);
    let (over, passes) = (AtomicBool::new(false), AtomicUsize::new(0));
    let (commands, hammers) = std::thread::scope(|threads| {
        let hammers: Vec<_> = refused
            .into_iter()
            .map(|ticket| {
                let over = &over;
                threads.spawn(move || {
                    let mut through = 0_usize;
                    while !over.load(SeqCst) {
                        through += usize::from(ticket.invoke(Switch::Blink).is_ok());
                        through += usize::from(ticket.try_invoke(Switch::Blink).is_ok());
                    }
                    (ticket, through)
                })
            })
            .collect();
        // A supervisor is in and out of the gate as well.
        threads.spawn(|| {
            while !over.load(SeqCst) {
                bench.broker.bar(&supervisor, barred).unwrap().quiesce().unwrap();
                passes.fetch_add(1, SeqCst);
            }
        });
        let ends = Over(&over);
        let (mut invoked, mut issued) = (0, 0);
        while invoked < COMMANDS || passes.load(SeqCst) < COMMANDS {
            invoked += 1;
            issued += usize::from(valid.invoke(Switch::Blink).is_ok());
        }
        drop(ends);
        // They are kept, so that the barred one is not stale before all is over.
        let hammers: Vec<_> = hammers.into_iter().map(|hammer| hammer.join().unwrap()).collect();
        ((invoked, issued), hammers)
    });
    let got_through: usize = hammers.iter().map(|(_, through)| through).sum();
    let (invoked, issued) = commands;
    assert_eq!((issued, got_through), (invoked, 0));
    assert_eq!(bench.commands(0), invoked);
}

#[test]
fn no_command_reaches_the_device_after_quiescence() {
    let (bench, supervisor) = patient();
    for _ in 0..200 {
        let ticket = bench.ticket(1, 0);
        let id = ticket.id();
        let over = AtomicBool::new(false);
        std::thread::scope(|threads| {
            let over = &over;
            let holder = threads.spawn(move || {
                while !over.load(SeqCst) {
                    let _ = ticket.invoke(Switch::Blink);
                }
                ticket
            });
            let ends = Over(over);
            let before = bench.commands(0);
            while bench.commands(0) == before {
                std::thread::yield_now();
            }
            bench.broker.bar(&supervisor, id).unwrap().quiesce().unwrap();
            let at_rest = bench.commands(0);
            for _ in 0..10 {
                std::thread::yield_now();
            }
            assert_eq!(bench.commands(0), at_rest);
            drop(ends);
            let ticket = holder.join().unwrap();
            assert_eq!(ticket.check(), Err(Refusal::NotValid(Why::Barred)));
        });
    }
    let last = bench.broker.request(Priority::SCIENCE, &bench.lamps[0]).unwrap();
    bench.broker.service();
    assert_eq!(last.check(), Ok(()));
}

#[test]
fn a_command_that_finds_somebody_inside_waits_for_it_and_is_issued() {
    let (broker, lamp, supervisor) = slow::broker();
    let valid = broker.request(Priority::SCIENCE, &lamp).unwrap();
    let other = broker.request(Priority::LEAST, &lamp).unwrap();
    broker.service();
    let waiting = other.id();
    slow::HOLD.store(true, SeqCst);
    std::thread::scope(|threads| {
        threads.spawn(|| broker.bar(&supervisor, waiting).unwrap().quiesce().unwrap());
        slow::wait_for(&slow::INSIDE);
        let tried = valid.try_invoke(Switch::Blink).unwrap_err().refusal();
        threads.spawn(|| {
            slow::wait_for(&slow::WAITING);
            slow::HOLD.store(false, SeqCst);
        });
        let invoked = valid.invoke(Switch::Blink);
        slow::WAITING.store(true, SeqCst);
        assert_eq!((tried, invoked), (Some(Refusal::Busy), Ok(())));
    });
}
