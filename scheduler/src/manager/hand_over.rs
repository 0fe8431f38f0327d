//! What follows from a walk: requests, victims, starts.

use crate::manager::entry::{Asked, Entry, Place, Stage};
use crate::manager::ledger::{Ledger, Part};
use crate::manager::limits::SLOTS;
use crate::manager::rank::Rank;
use crate::manager::step::Step;
use crate::manager::{Action, Note, Occurrence, Record, WaitsFor};
use crate::task::{Body, BuiltIn};

impl Step<'_> {
    /// Who was not chosen gives back what it need not hold.
    pub(crate) fn stand_back(&mut self) {
        for index in self.manager.live.clone() {
            let Some(entry) = self.entry(index) else { continue };
            let blocked = matches!(entry.run.asked, Asked::Blocked(_));
            let objection = self.objection(entry);
            let why = match (&entry.run.chosen, objection) {
                (_, Some(objection)) => objection,
                (Err(why), None) if !blocked => why.clone(),
                _ => continue,
            };
            let forbidden = self.objection(entry).is_some();
            let idle = entry.run.stage == Stage::Idle;
            let granted = entry.run.asked == Asked::Granted;
            if idle {
                self.back_to_class(index);
                self.tell_waits(index, why);
            } else if entry.run.stage == Stage::Paused {
                if granted || forbidden {
                    self.give_back(index);
                }
                self.tell_waits(index, why);
            } else if self.comes_back(index) && (granted || forbidden) {
                self.give_back(index);
            }
        }
    }

    /// Who has another priority by now asks again, as soon as it has nothing to
    /// lose by that.
    pub(crate) fn renew_stale(&mut self) {
        for index in self.manager.live.clone() {
            let Some(run) = self.entry_mut(index).map(|entry| &mut entry.run) else { continue };
            if run.stale && !run.is_using() {
                run.stale = false;
                self.give_back(index);
            }
        }
    }

    /// A request that need not wait at the agents any more waits here.
    fn back_to_class(&mut self, index: u32) {
        self.unseat(index);
        let Some(entry) = self.entry_mut(index) else { return };
        let short = entry.run.short;
        entry.run = crate::manager::entry::Run::new();
        entry.run.short = short;
        if entry.is_ready() {
            self.enter(index);
        }
    }

    /// Asks for the tickets of who was chosen, most important first. Answers
    /// whether anybody has nobody to wait for, and will start at once.
    pub(crate) fn ask(&mut self) -> bool {
        let wanted = self.chosen(|entry| {
            entry.run.asked == Asked::No && matches!(entry.run.stage, Stage::Idle | Stage::Paused)
        });
        if wanted.is_empty() {
            return false;
        }
        let mut there = self.present_ledger();
        let mut about_to_start = false;
        for (rank, index) in wanted {
            if self.make_room(rank) {
                about_to_start |= self.request(index, &mut there);
            }
        }
        about_to_start
    }

    /// Answers whether what it needs is free.
    fn request(&mut self, index: u32, there: &mut Ledger) -> bool {
        let Some(entry) = self.entry(index) else { return false };
        let occurrence = entry.occurrence();
        let demand = self.manager.classes.demand(entry.class);
        let part = if entry.keeps_memory() { Part::Running } else { Part::All };
        let is_free = there.short(&demand, part, &self.manager.installed).is_none();
        there.take(&demand, part);
        let victims = if is_free { Vec::new() } else { self.victims(index, occurrence) };
        if !victims.is_empty() {
            self.tell_waits(index, WaitsFor::HandOver);
        }
        if let Some(entry) = self.entry_mut(index) {
            entry.run.asked = Asked::Waiting;
        }
        self.act(Action::Request { occurrence, victims });
        is_free
    }

    /// Those that were not chosen, still use something, and share it with the
    /// taker. Who runs hears of it from the agents.
    fn victims(&mut self, taker: u32, occurrence: Occurrence) -> Vec<Occurrence> {
        let Some(entry) = self.entry(taker) else { return Vec::new() };
        let wanted = self.manager.classes.demand(entry.class);
        let mut victims = Vec::new();
        for index in self.manager.live.clone() {
            let Some(entry) = self.entry(index) else { continue };
            let gives_way =
                entry.run.is_using() && (entry.run.chosen.is_err() || entry.run.is_ending());
            let demand = self.manager.classes.demand(entry.class);
            if index == taker || !gives_way || !demand.shares_with(&wanted) {
                continue;
            }
            victims.push(entry.occurrence());
            if let Some(entry) = self.entry_mut(index) {
                entry.run.taker = Some(occurrence);
            }
        }
        victims
    }

    /// Whether another request can be made. If need be a less important one,
    /// of a body that stands still, is taken back: it will be made again.
    fn make_room(&mut self, rank: Rank) -> bool {
        let asked = |entry: &Entry| entry.run.asked != Asked::No;
        let waits = |entry: &Entry| asked(entry) && entry.run.asked != Asked::Granted;
        let most = self.manager.mission.waiting_requests;
        loop {
            let slots = self.count(asked);
            let waiting = self.count(|entry| waits(entry) && !entry.run.is_using());
            if slots < SLOTS && waiting < most {
                return true;
            }
            let live = self.manager.live.iter();
            let entries = live.filter_map(|index| Some((*index, self.entry(*index)?)));
            let still = entries
                .filter(|(_, entry)| entry.run.stage == Stage::Paused && waits(entry))
                .filter(|(_, entry)| entry.run.chosen.is_err() && entry.rank() > rank)
                .max_by_key(|(_, entry)| entry.rank());
            let Some((index, _)) = still else { return false };
            self.give_back(index);
        }
    }

    fn count(&self, counts: impl Fn(&Entry) -> bool) -> usize {
        let live = self.manager.live.iter();
        live.filter(|index| self.entry(**index).is_some_and(&counts)).count()
    }

    /// Who runs, was not chosen, and is nobody's victim loses its tickets by
    /// the manager's own hand.
    pub(crate) fn pre_empt_the_rest(&mut self) {
        for index in self.manager.live.clone() {
            let Some(entry) = self.entry_mut(index) else { continue };
            if entry.run.stage != Stage::Running {
                continue;
            }
            let Err(why) = entry.run.chosen.clone() else {
                entry.run.taker = None;
                continue;
            };
            let taker = entry.run.taker;
            if !taker.is_some_and(|taker| self.is_still_asking(taker)) {
                self.withdraw(index, why.stops());
            }
        }
    }

    fn is_still_asking(&self, taker: Occurrence) -> bool {
        let entry = self.manager.named(taker).and_then(|index| self.entry(index));
        entry.is_some_and(|entry| {
            entry.place == Place::Live
                && entry.run.asked == Asked::Waiting
                && entry.run.chosen.is_ok()
        })
    }

    /// Starts who was chosen and granted, once nobody uses any more what it
    /// needs. Answers whether the manager did something by itself.
    pub(crate) fn start_granted(&mut self) -> bool {
        let granted = self.chosen(|entry| {
            entry.run.asked == Asked::Granted
                && matches!(entry.run.stage, Stage::Idle | Stage::Paused)
        });
        if granted.is_empty() {
            return false;
        }
        let mut there = self.present_ledger();
        let mut free = Vec::new();
        for (_, index) in granted {
            let Some(entry) = self.entry(index) else { continue };
            let demand = self.manager.classes.demand(entry.class);
            let part = if entry.run.stage == Stage::Idle { Part::All } else { Part::Running };
            if there.short(&demand, part, &self.manager.installed).is_none() {
                let is_built_in = entry.is_built_in();
                there.take(&demand, part);
                free.push(index);
                // What it does may change who starts next.
                if is_built_in {
                    break;
                }
            }
        }
        self.write_starts(&free);
        let mut did = false;
        for index in free {
            did |= self.set_going(index);
        }
        did
    }

    /// All that start are in the journal before the first of them does.
    fn write_starts(&mut self, free: &[u32]) {
        let mut sync = false;
        for index in free {
            let idle = |entry: &&mut Entry| entry.run.stage == Stage::Idle;
            let Some(entry) = self.entry_mut(*index).filter(idle) else { continue };
            entry.attempts = entry.attempts.saturating_add(1);
            entry.saved = false;
            let attempt = entry.attempt();
            if attempt.number == 1 {
                self.spend_dependencies(*index);
            }
            self.tell_missed(*index);
            sync |= !self.disarm(*index);
            self.write(Record::Starting { attempt });
        }
        if sync {
            self.act(Action::Sync);
        }
    }

    /// Starts a body, or lets it go on. Answers whether the manager was it.
    fn set_going(&mut self, index: u32) -> bool {
        let Some(entry) = self.entry(index) else { return false };
        if entry.run.stage == Stage::Paused {
            self.go_on(index);
            return false;
        }
        self.start(index)
    }

    fn start(&mut self, index: u32) -> bool {
        let Some(entry) = self.entry(index) else { return false };
        let attempt = entry.attempt();
        let body = entry.task.body.clone();
        self.manager.charge(index);
        self.set_running(index);
        match body {
            Body::BuiltIn(BuiltIn::Load(path)) => self.act(Action::Load { attempt, path }),
            Body::BuiltIn(built_in) => {
                self.note(Note::Started(attempt));
                self.build_in(attempt, built_in);
                return true;
            }
            _ => self.act(Action::Start { attempt }),
        }
        self.note(Note::Started(attempt));
        false
    }

    /// What bodies use at present, whether they are to or not.
    fn present_ledger(&self) -> Ledger {
        let mut ledger = self.manager.ledger();
        for gap in &self.manager.gaps {
            ledger.categories |= gap.categories;
        }
        for index in &self.manager.live {
            let Some(entry) = self.entry(*index) else { continue };
            let demand = self.manager.classes.demand(entry.class);
            if entry.run.is_using() {
                ledger.take(&demand, Part::All);
            } else if entry.run.stage == Stage::Paused {
                ledger.reserve(&demand);
            }
        }
        ledger
    }

    /// The live ones that were chosen and of which this is true, most important
    /// first.
    fn chosen(&self, is: impl Fn(&Entry) -> bool) -> Vec<(Rank, u32)> {
        let live = self.manager.live.iter();
        let entries = live.filter_map(|index| Some((*index, self.entry(*index)?)));
        let mut chosen: Vec<_> = entries
            .filter(|(_, entry)| entry.run.chosen.is_ok() && is(entry))
            .map(|(index, entry)| (entry.rank(), index))
            .collect();
        chosen.sort_unstable();
        chosen
    }
}
