//! The soak of one subject: its holders hammer, its revoker revokes.

use std::iter::Sum;
use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use faregate_devices_sim::Dice;

use crate::holder::{Hammer, Held};
use crate::place::Place;
use crate::room::Room;
use crate::subject::{Outcome, Subject};

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
    /// Holders that were inside a command at that moment.
    pub(crate) caught: u64,
    pub(crate) admitted: u64,
    pub(crate) refused: u64,
    /// Commands that were stored without the driver.
    pub(crate) by_store: u64,
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
            by_store: self.by_store + other.by_store,
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

impl Sum for Tally {
    fn sum<I: Iterator<Item = Self>>(tallies: I) -> Self {
        tallies.fold(Self::default(), Self::and)
    }
}

impl Drive {
    /// Soaks one subject, and counts what is done into `done`. It is made in the
    /// revoker's place, so that threads of its own run there too.
    pub(crate) fn soak<S: Subject>(
        self,
        make: fn() -> Outcome<S>,
        done: &AtomicU64,
    ) -> Outcome<Tally> {
        thread::scope(|scope| {
            let revoker = scope.spawn(move || self.revoke(make, done));
            revoker.join().map_err(|_| "the revoker panicked")?
        })
    }

    fn revoke<S: Subject>(self, make: fn() -> Outcome<S>, done: &AtomicU64) -> Outcome<Tally> {
        self.place.set_up_revoker()?;
        let mut subject = make()?;
        let rooms = subject.rooms().to_vec();
        rooms.iter().for_each(|room| room.set_bell(thread::current()));
        let hands = hands(subject.hand_out(), self.place.holders());
        let orders = subject.orders();
        let (stop, ready) = (AtomicBool::new(false), Barrier::new(hands.len() + 1));
        thread::scope(|scope| {
            let (stop, ready) = (&stop, &ready);
            let mut holders = Vec::new();
            for (number, passes) in (1..).zip(hands) {
                let (dice, place) = (Dice::new(self.seed, number), self.place);
                let holder =
                    Hammer { place, orders, dice, held: Held::default(), refused_in_a_row: 0 };
                holders.push(scope.spawn(move || holder.hammer(&passes, ready, stop)));
            }
            ready.wait();
            let dice = Dice::new(self.seed, 0);
            let mut revoker = Revoker { drive: self, subject, dice, tally: Tally::default() };
            let revoked = (0..self.revocations).try_for_each(|_| {
                done.fetch_add(1, Ordering::Relaxed);
                revoker.round()
            });
            stop.store(true, Ordering::Relaxed);
            let mut held = Held::default();
            for holder in holders {
                held = held.and(holder.join().map_err(|_| "a holder panicked")??);
            }
            revoked.map_err(|why| held.explain(&why))?;
            let commands: u64 = rooms.iter().map(|room| room.commands()).sum();
            let late = rooms.iter().map(|room| room.late()).sum();
            let by_store = held.admitted.saturating_sub(commands);
            let Held { admitted, refused, .. } = held;
            Ok(Tally { admitted, refused, late, by_store, ..revoker.tally })
        })
    }
}

/// The passes, dealt to so many threads.
fn hands<P>(passes: Vec<P>, threads: usize) -> Vec<Vec<P>> {
    let mut hands: Vec<Vec<P>> = (0..threads).map(|_| vec![]).collect();
    for (number, pass) in passes.into_iter().enumerate() {
        hands[number % threads].push(pass);
    }
    hands
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
        self.each(aim, |revoker, _, room| revoker.wait_until_used(room))?;
        place.linger(&mut self.dice);
        self.each(aim, |revoker, _, room| {
            revoker.tally.caught += u64::from(room.is_occupied());
            Ok(())
        })?;
        self.subject.revoke()?;
        if !self.drive.skip_quiescence {
            self.subject.quiesce()?;
        }
        self.each(aim, |_, _, room| {
            room.close();
            Ok(())
        })?;
        place.watch(&mut self.dice);
        self.each(aim, |revoker, number, room| {
            room.open_for(revoker.subject.next(number, &mut revoker.dice));
            Ok(())
        })?;
        self.subject.admit()?;
        self.tally.revocations += 1;
        self.tally.hit += u64::from(aim.count_ones());
        Ok(())
    }

    /// Does something in each room that is aimed at.
    fn each(
        &mut self,
        aim: u32,
        mut f: impl FnMut(&mut Self, usize, &'static Room) -> Outcome<()>,
    ) -> Outcome<()> {
        for number in 0..self.subject.rooms().len() {
            let room = self.subject.rooms()[number];
            if aim & (1 << number) != 0 {
                f(self, number, room)?;
            }
        }
        Ok(())
    }

    /// A revocation counts only if its ticket was valid. That its holder has had
    /// a command admitted shows it; nobody else revokes.
    fn wait_until_used(&mut self, room: &Room) -> Outcome<()> {
        let (mut turn, mut since) = (0_u32, None);
        while !room.is_used() {
            self.drive.place.wait(turn, &mut self.dice);
            turn = turn.wrapping_add(1);
            if turn.is_multiple_of(1024)
                && since.get_or_insert_with(Instant::now).elapsed() > STARVED
            {
                return Err("a holder that was let in had no command admitted: Open Door".into());
            }
        }
        Ok(())
    }
}
