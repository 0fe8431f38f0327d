//! A schedule that stays as it is while events go on, for the manager and for
//! its peer.
//!
//! One task runs on the category that everybody wants. A tenth of the others
//! are due and wait for it. The rest become due in time, a hundredth of the
//! schedule at each second. What was due for ten seconds is put off by a
//! hundred, so that as many wait as before. No event follows upon a copy of the
//! schedule: a copy has fresh memory and no room to grow, and both would be
//! measured with it.

use std::collections::VecDeque;
use std::hint::black_box;

use fastrand::Rng;

/// More important than any other.
pub(crate) const HOLDER: u8 = 200;
/// How many parts of the schedule become due one after the other.
const GROUPS: usize = 100;
/// How many of them wait.
const WAITING: u64 = 10;

/// What can happen, in the order of a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A hundredth of the schedule becomes due.
    Due,
    /// The tickets of the running task are taken.
    Revoke,
    /// A task comes into the schedule.
    Add,
    /// A task is taken out.
    Remove,
    /// The running task ends, and the next one is asked for.
    End,
    /// The next one is granted its tickets, and starts.
    Start,
}

/// All of them.
pub(crate) const KINDS: [Kind; 6] =
    [Kind::Due, Kind::Revoke, Kind::Add, Kind::Remove, Kind::End, Kind::Start];

impl Kind {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Due => "due",
            Self::Revoke => "revoke",
            Self::Add => "add",
            Self::Remove => "remove",
            Self::End => "end",
            Self::Start => "start",
        }
    }
}

/// A task, as both sides are told of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) id: u32,
    /// In seconds.
    pub(crate) due: u64,
    pub(crate) priority: u8,
}

/// What happens, ready to be given to a schedule.
#[derive(Clone, Debug)]
pub(crate) enum Happening {
    Due,
    Revoke,
    Add(Row),
    Remove(u32),
    End,
    Start,
}

/// One side of the comparison.
pub(crate) trait Schedule {
    /// An event that has been made, and has not happened.
    type Event;

    /// With these tasks, the first of which runs.
    fn of(rows: &[Row]) -> Self;

    /// Makes an event of what happens at this second.
    fn make(&mut self, now: u64, happening: Happening) -> Self::Event;

    /// Takes the decision that is measured.
    fn happen(&mut self, event: Self::Event);

    /// Does what comes of it, and is nobody's measure.
    fn follow(&mut self, kind: Kind);

    /// Which task runs.
    fn runs(&self) -> u32;

    /// The running task ends, and others are taken out, while new ones come,
    /// the most important of all among them.
    fn replace(&mut self, out: &[u32], rows: &[Row]);
}

/// Event after event, in one schedule.
#[derive(Debug)]
pub(crate) struct Stream<S> {
    pub(crate) schedule: S,
    random: Rng,
    /// The present second.
    now: u64,
    /// Who becomes due at one second; first those that have waited for longest.
    groups: VecDeque<Vec<u32>>,
    holder: u32,
    /// The id that is free for the next one that comes.
    spare: u32,
    /// Whose place the next one takes that comes: which group's, and where.
    place: (usize, usize),
    next: usize,
}

impl<S: Schedule> Stream<S> {
    /// Of so many tasks, beside the one that runs.
    pub(crate) fn new(size: u32) -> Self {
        let mut random = Rng::with_seed(u64::from(size));
        let mut ids: Vec<u32> = (1..=size).collect();
        // Neighbours in time are no neighbours in memory.
        random.shuffle(&mut ids);
        let groups: VecDeque<_> =
            ids.chunks(ids.len().div_ceil(GROUPS)).map(<[u32]>::to_vec).collect();
        let (holder, spare) = (size + 1, size + 2);
        let mut rows = vec![Row { id: holder, due: 0, priority: HOLDER }];
        for (group, ids) in groups.iter().enumerate() {
            let due = due_of(group, 1);
            rows.extend(ids.iter().map(|&id| Row { id, due, priority: any(&mut random) }));
        }
        let schedule = S::of(&rows);
        Self { schedule, random, now: 0, groups, holder, spare, place: (0, 0), next: 0 }
    }

    /// How many wait between two rounds: a tenth of the schedule.
    pub(crate) fn waiting(&self) -> usize {
        let waits = |group: &usize| due_of(*group, self.now + 1) <= self.now;
        let groups = (0..self.groups.len()).take_while(waits);
        groups.map(|group| self.groups[group].len()).sum()
    }

    /// What happens next.
    pub(crate) fn next(&self) -> Kind {
        KINDS[self.next % KINDS.len()]
    }

    /// Makes the next event; [`Stream::follow`] comes after it.
    pub(crate) fn make(&mut self) -> S::Event {
        let happening = match self.next() {
            Kind::Due => {
                self.now += 1;
                Happening::Due
            }
            Kind::Revoke => Happening::Revoke,
            Kind::Add => Happening::Add(self.comes()),
            Kind::Remove => Happening::Remove(self.goes()),
            Kind::End => Happening::End,
            Kind::Start => Happening::Start,
        };
        self.schedule.make(self.now, happening)
    }

    /// What comes of the latest event, until the next one can happen.
    pub(crate) fn follow(&mut self) {
        let kind = self.next();
        self.schedule.follow(kind);
        self.next += 1;
        if kind == Kind::Start {
            self.put_off();
        }
    }

    /// Lets the next event happen, unmeasured.
    pub(crate) fn pass(&mut self) {
        let event = self.make();
        self.schedule.happen(event);
        self.follow();
    }

    /// A new task, instead of one that goes.
    fn comes(&mut self) -> Row {
        let group = self.random.usize(0..self.groups.len());
        self.place = (group, self.random.usize(0..self.groups[group].len()));
        Row { id: self.spare, due: due_of(group, self.now), priority: any(&mut self.random) }
    }

    fn goes(&mut self) -> u32 {
        let (group, place) = self.place;
        core::mem::swap(&mut self.groups[group][place], &mut self.spare);
        self.spare
    }

    /// Who has waited for longest is put off. Who ran instead of the holder
    /// waits again, behind a new one.
    fn put_off(&mut self) {
        self.groups.rotate_left(1);
        let last = self.groups.len() - 1;
        let (runs, ids, now) = (self.schedule.runs(), &self.groups[last], self.now);
        let out: Vec<u32> = ids.iter().copied().filter(|&id| id != runs).collect();
        let mut row = |id, due| Row { id, due, priority: any(&mut self.random) };
        let mut rows: Vec<_> = ids.iter().map(|&id| row(id, due_of(last, now + 1))).collect();
        if !ids.contains(&runs) {
            rows.push(row(runs, now));
        }
        rows.push(Row { id: self.holder, due: now, priority: HOLDER });
        self.schedule.replace(&out, &rows);
        assert_eq!(self.schedule.runs(), self.holder, "the most important one runs again");
        tidy_the_heap();
    }
}

/// Lets the C library do now what it would do for whoever next asks for a large
/// block: it goes through all small ones that were freed. Those that were put
/// off left thousands, and are nobody's measure.
fn tidy_the_heap() {
    const LARGE: usize = 64 << 10;
    drop(black_box(Vec::<u8>::with_capacity(LARGE)));
}

/// The second at which a group is due.
fn due_of(group: usize, now: u64) -> u64 {
    (now + group as u64).saturating_sub(WAITING)
}

fn any(random: &mut Rng) -> u8 {
    random.u8(0..HOLDER)
}
