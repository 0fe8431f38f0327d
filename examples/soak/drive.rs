//! The soak of one subject: its holders hammer, its revoker revokes.

use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use faregate::prelude::Refusal;
use faregate_devices_sim::Dice;

use crate::place::Place;
use crate::room::{Order, Room};
use crate::subject::{Outcome, Pass, Subject};

/// A holder that is not admitted for so long is not merely slow.
const STARVED: Duration = Duration::from_secs(20);

/// How a soak is driven.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drive {
    pub(crate) place: Place,
    pub(crate) revocations: u64,
    pub(crate) seed: u64,
    /// Broken on purpose: the mark is set without waiting for quiescence.
    pub(crate) skip_quiescence: bool,
}

/// What a soak found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) revocations: u64,
    /// Tickets that were valid, and were revoked.
    pub(crate) hit: u64,
    /// Revocations that found a holder inside a command.
    pub(crate) caught: u64,
    pub(crate) admitted: u64,
    pub(crate) refused: u64,
    /// Commands that began or were in progress after quiescence.
    pub(crate) late: u64,
}

impl Tally {
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            revocations: self.revocations + other.revocations,
            hit: self.hit + other.hit,
            caught: self.caught + other.caught,
            admitted: self.admitted + other.admitted,
            refused: self.refused + other.refused,
            late: self.late + other.late,
        }
    }

    /// The share of invocations that were admitted, in percent.
    pub(crate) fn admitted_percent(&self) -> f64 {
        let all = (self.admitted + self.refused).max(1);
        #[expect(clippy::cast_precision_loss, reason = "a percentage for people")]
        let percent = self.admitted as f64 * 100.0 / all as f64;
        percent
    }
}

impl Drive {
    /// Soaks one subject, and counts what is done into `done`.
    pub(crate) fn soak<S: Subject>(self, mut subject: S, done: &AtomicU64) -> Outcome<Tally> {
        let mut hands: Vec<Vec<S::Pass>> = (0..self.place.holders()).map(|_| vec![]).collect();
        let threads = hands.len();
        for (number, pass) in subject.hand_out().into_iter().enumerate() {
            hands[number % threads].push(pass);
        }
        let rooms = subject.rooms().to_vec();
        let (stop, ready) = (AtomicBool::new(false), Barrier::new(threads + 1));
        thread::scope(|scope| {
            let (stop, ready) = (&stop, &ready);
            let holders: Vec<_> = (1..)
                .zip(hands)
                .map(|(number, passes)| {
                    let dice = Dice::new(self.seed, number);
                    scope.spawn(move || hammer(self.place, &passes, dice, ready, stop))
                })
                .collect();
            let revoker = scope.spawn(move || {
                let revoked = self.revoke(subject, ready, done);
                stop.store(true, Ordering::Relaxed);
                revoked
            });
            let mut tally = revoker.join().map_err(|_| "the revoker panicked")?;
            for holder in holders {
                let held = holder.join().map_err(|_| "a holder panicked")??;
                tally = tally.map_err(|why| held.explain(why));
                tally = tally.map(|tally| tally.and(held.tally));
            }
            tally.map(|tally| Tally { late: rooms.iter().map(|room| room.late()).sum(), ..tally })
        })
    }

    fn revoke(self, subject: impl Subject, ready: &Barrier, done: &AtomicU64) -> Outcome<Tally> {
        let set_up = self.place.set_up_revoker();
        for room in subject.rooms() {
            room.set_bell(thread::current());
        }
        ready.wait();
        set_up?;
        let (dice, tally) = (Dice::new(self.seed, 0), Tally::default());
        let mut revoker = Revoker { drive: self, subject, dice, tally };
        for _ in 0..self.revocations {
            revoker.round()?;
            done.fetch_add(1, Ordering::Relaxed);
        }
        Ok(revoker.tally)
    }
}

struct Revoker<S> {
    drive: Drive,
    subject: S,
    dice: Dice,
    tally: Tally,
}

impl<S: Subject> Revoker<S> {
    /// One revocation, from a valid ticket that is in use to the next one.
    fn round(&mut self) -> Outcome<()> {
        let place = self.drive.place;
        let aim = self.subject.aim(&mut self.dice)?;
        let hit: Vec<(usize, &'static Room)> = self.rooms(aim);
        for (_, room) in &hit {
            self.wait_until_used(room)?;
        }
        place.linger(&mut self.dice);
        self.tally.caught += u64::from(hit.iter().any(|(_, room)| room.is_occupied()));
        self.subject.revoke()?;
        if !self.drive.skip_quiescence {
            self.subject.quiesce()?;
        }
        hit.iter().for_each(|(_, room)| room.close());
        place.watch(&mut self.dice);
        for (number, room) in &hit {
            room.open_for(self.subject.next(*number, &mut self.dice));
        }
        self.subject.admit()?;
        self.tally.revocations += 1;
        self.tally.hit += u64::from(aim.count_ones());
        Ok(())
    }

    fn rooms(&self, aim: u32) -> Vec<(usize, &'static Room)> {
        let rooms = self.subject.rooms().iter().copied().enumerate();
        rooms.filter(|(number, _)| aim & (1 << number) != 0).collect()
    }

    /// A revocation counts only if its ticket was valid. That its holder has had
    /// a command admitted shows it; nobody else revokes.
    fn wait_until_used(&mut self, room: &Room) -> Outcome<()> {
        let (mut turn, mut since) = (0_u32, None);
        while !room.is_used() {
            self.drive.place.wait(turn, &mut self.dice);
            turn = turn.wrapping_add(1);
            if turn.is_multiple_of(1024) && since.get_or_insert_with(Instant::now).elapsed() > STARVED
            {
                return Err("a holder that was let in had no command admitted: Open Door".into());
            }
        }
        Ok(())
    }
}

/// What a holder's thread saw.
struct Held {
    tally: Tally,
    last: Option<Refusal>,
}

impl Held {
    fn explain(&self, why: crate::subject::Failure) -> crate::subject::Failure {
        match self.last {
            Some(last) => format!("{why}; the latest refusal of a holder: {last}").into(),
            None => why,
        }
    }
}

fn hammer<P: Pass>(
    place: Place,
    passes: &[P],
    mut dice: Dice,
    ready: &Barrier,
    stop: &AtomicBool,
) -> Outcome<Held> {
    let set_up = place.set_up_holder();
    ready.wait();
    set_up?;
    let mut held = Held { tally: Tally::default(), last: None };
    // Relaxed: it says nothing about other memory.
    while !stop.load(Ordering::Relaxed) {
        for pass in passes {
            let steps = u16::try_from(dice.below(16)).unwrap_or(0);
            let order = Order { holder: pass.holder(), steps, ring: place.rings(&mut dice) };
            match pass.invoke(order) {
                Ok(()) => {
                    held.tally.admitted += 1;
                    place.think(&mut dice);
                }
                Err(refused) => {
                    held.tally.refused += 1;
                    held.last = refused.why;
                    place.after_refusal(&mut dice);
                }
            }
        }
    }
    Ok(held)
}
