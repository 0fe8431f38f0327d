//! Runs a schedule on the virtual executive, and writes down what happens.

use std::collections::{HashMap, HashSet};

use crate::analyze::report::RunOutcome;
use crate::analyze::track::Track;
use crate::analyze::{Failed, Options, Surroundings};
use crate::executive::{Conduct, LoadedFile, Outside, Stuck, VirtualBodies, VirtualExecutive};
use crate::manager::{
    Addition, Attempt, Event, HeldBy, Note, Reading, Reply, State, Telecommand, TelecommandId,
    WaitsFor,
};
use crate::mission::Mission;
use crate::task::{Task, TaskId};
use crate::time::{Duration, Instant, Now, UnixTime};

/// Where routine tasks are, and nobody says how long to look.
const A_DAY: Duration = Duration::from_secs(86_400);

/// How many decisions come between two words on how far it is.
const TELL_EVERY: u32 = 4_096;

/// What happened.
#[derive(Debug)]
pub(super) struct Trace {
    pub(super) tracks: Vec<Track>,
    pub(super) waits: Vec<Wait>,
    pub(super) horizon: Duration,
    /// Whether more may happen after the horizon.
    pub(super) cut: bool,
    /// It was given up: there were too many runs.
    pub(super) is_full: bool,
    index: HashMap<TaskId, usize>,
    /// At this instant time did not go on.
    pub(super) stuck: Option<String>,
}

/// A task waited for another one, or for draw.
#[derive(Clone, Debug)]
pub(super) struct Wait {
    pub(super) task: TaskId,
    pub(super) at: Duration,
    pub(super) waits_for: WaitsFor,
}

/// Writes down what the manager tells.
struct Recorder<'a> {
    tracks: Vec<Track>,
    index: HashMap<TaskId, usize>,
    /// Tasks that were given to the manager, until it accepts them.
    given: HashMap<TaskId, Task>,
    /// Who cleans up after one of them.
    cleaning: HashSet<TaskId>,
    waits: Vec<Wait>,
    /// How many attempts started, and whether that was enough.
    started: usize,
    events: u32,
    is_full: bool,
    refused: Option<String>,
    surroundings: &'a mut dyn Surroundings,
}

/// Runs the tasks until the horizon, or until nothing happens any more.
pub(super) fn trace(
    tasks: &[Task],
    mission: &Mission,
    options: &Options,
    script: impl FnMut(Attempt, &Task) -> Conduct + Send + 'static,
    surroundings: &mut dyn Surroundings,
) -> Result<Trace, Failed> {
    let recorder = Recorder::new(tasks, surroundings);
    let bodies = VirtualBodies::new(script);
    let mut executive = VirtualExecutive::new(mission.clone(), options.at, bodies, recorder);
    if mission.battery.is_some() {
        executive.tell(Event::Reading(Reading::Battery(Some(100))));
    }
    let additions = tasks.iter().map(|task| Addition { task: task.clone() }).collect();
    let telecommand = Telecommand::Add(additions);
    executive.tell(Event::Telecommand { id: TelecommandId(0), telecommand });
    let limit = options.horizon.or_else(|| tasks.iter().any(is_routine).then_some(A_DAY));
    let ran = run(&mut executive, limit);
    let reached = executive.now().elapsed.since(Instant::START);
    tell_the_rest(&mut executive);
    executive.into_outside().finish(limit, reached, ran)
}

/// What the manager tells only when it is asked: misses that go on, and what is
/// waited for at the horizon.
fn tell_the_rest(executive: &mut VirtualExecutive<Recorder<'_>>) {
    let now = executive.now();
    let misses = executive.manager().untold();
    let waiting = executive.manager().status().filter_map(|status| match status.state {
        State::Waiting(waits_for) => Some(Note::Waits { occurrence: status.occurrence, waits_for }),
        _ => None,
    });
    let notes: Vec<_> = misses.chain(waiting).collect();
    for note in notes {
        executive.outside().note(now, &note);
    }
}

fn is_routine(task: &Task) -> bool {
    task.interval.is_some()
}

fn run(
    executive: &mut VirtualExecutive<Recorder<'_>>,
    limit: Option<Duration>,
) -> Result<(), Stuck> {
    executive.advance_to(Instant::START)?;
    let until = limit.map_or(Instant::FAR_FUTURE, |limit| Instant::START.after(limit));
    while let Some(due) = executive.next_due().filter(|due| *due <= until) {
        executive.advance_to(due)?;
        if !executive.outside().goes_on(due.since(Instant::START), limit) {
            break;
        }
    }
    Ok(())
}

impl<'a> Recorder<'a> {
    fn new(tasks: &[Task], surroundings: &'a mut dyn Surroundings) -> Self {
        let mut recorder = Self {
            tracks: Vec::with_capacity(tasks.len()),
            index: HashMap::with_capacity(tasks.len()),
            given: HashMap::with_capacity(tasks.len()),
            cleaning: HashSet::new(),
            waits: Vec::new(),
            started: 0,
            events: 0,
            is_full: false,
            refused: None,
            surroundings,
        };
        recorder.gives(tasks);
        recorder
    }

    fn gives(&mut self, tasks: &[Task]) {
        self.given.extend(tasks.iter().map(|task| (task.id, task.clone())));
        self.cleaning.extend(tasks.iter().filter_map(|task| task.cleanup));
    }

    /// Tells how far it is, and whether there is room for more.
    fn goes_on(&mut self, at: Duration, limit: Option<Duration>) -> bool {
        self.events = self.events.wrapping_add(1);
        if self.events.is_multiple_of(TELL_EVERY) {
            // Waits fill the memory, too, also those of tasks that never start.
            let kept = self.started.max(self.waits.len());
            self.is_full = !self.surroundings.reached(at, limit, kept);
        }
        !self.is_full
    }

    fn track(&mut self, task: TaskId) -> Option<&mut Track> {
        self.index.get(&task).and_then(|index| self.tracks.get_mut(*index))
    }

    /// A task that comes again under its number goes on in the same track.
    fn accepted(&mut self, id: TaskId, now: Duration, wall: UnixTime) {
        let Some(task) = self.given.remove(&id) else { return };
        let track = Track::new(task, self.cleaning.contains(&id), now, wall);
        if let Some(known) = self.track(id) {
            return known.goes_on_as(track);
        }
        self.index.insert(id, self.tracks.len());
        self.tracks.push(track);
    }

    fn waits(&mut self, task: TaskId, waits_for: &WaitsFor, at: Duration) {
        if let Some(track) = self.track(task) {
            track.waits(waits_for, at);
        }
        let notable = matches!(
            waits_for,
            WaitsFor::Dependency(_)
                | WaitsFor::Draw { .. }
                | WaitsFor::Categories { by: HeldBy::Task(_), .. }
                | WaitsFor::Gate { by: HeldBy::Task(_), .. }
        );
        if notable {
            self.waits.push(Wait { task, at, waits_for: waits_for.clone() });
        }
    }

    fn attempt(&mut self, attempt: Attempt, note: impl FnOnce(&mut Track)) {
        if let Some(track) = self.track(attempt.occurrence.task) {
            note(track);
        }
    }

    fn finish(
        mut self,
        limit: Option<Duration>,
        reached: Duration,
        ran: Result<(), Stuck>,
    ) -> Result<Trace, Failed> {
        if let Some(why) = self.refused.take() {
            return Err(Failed(why));
        }
        let limit = if self.is_full { Some(reached) } else { limit };
        let Self { tracks, waits, index, is_full, .. } = self;
        let stuck = ran.err().map(|stuck| stuck.to_string());
        let cut = limit.is_some();
        let mut trace = Trace { tracks, waits, horizon: reached, cut, is_full, index, stuck };
        if trace.stuck.is_none() {
            trace.horizon = limit.or(trace.makespan()).unwrap_or(reached);
        }
        for track in &mut trace.tracks {
            track.stop_at(trace.horizon, cut);
        }
        Ok(trace)
    }
}

impl Trace {
    pub(super) fn track(&self, task: TaskId) -> Option<&Track> {
        self.index.get(&task).and_then(|index| self.tracks.get(*index))
    }

    /// The end of the last run that is not a routine task's. One that will be
    /// run again is not at its end.
    pub(super) fn makespan(&self) -> Option<Duration> {
        let once = self.tracks.iter().filter(|track| !is_routine(&track.task));
        let runs = once.flat_map(|track| &track.runs);
        runs.filter(|run| run.outcome != RunOutcome::Preempted).filter_map(|run| run.end).max()
    }
}

impl Outside for Recorder<'_> {
    fn note(&mut self, now: Now, note: &Note) {
        let at = now.elapsed.since(Instant::START);
        match note {
            Note::Accepted(task) => self.accepted(*task, at, now.wall),
            Note::Waits { occurrence, waits_for } => self.waits(occurrence.task, waits_for, at),
            Note::Started(attempt) => {
                self.started = self.started.saturating_add(1);
                self.attempt(*attempt, |track| track.started(*attempt, at));
            }
            Note::Paused(attempt) => self.attempt(*attempt, |track| track.paused(at)),
            Note::Resumed(attempt) => self.attempt(*attempt, |track| track.resumed(at)),
            Note::Preempted(attempt) => self.attempt(*attempt, |track| track.over(None, at)),
            Note::Over { attempt, outcome, .. } => {
                self.attempt(*attempt, |track| track.over(Some(*outcome), at));
            }
            Note::Ended { occurrence, .. } => {
                if let Some(track) = self.track(occurrence.task) {
                    track.ended();
                }
            }
            Note::Missed { task, first, last, why, .. } => {
                if let Some(track) = self.track(*task) {
                    track.missed(*first, *last, why, at);
                }
            }
            Note::NeverRuns { task, why } => {
                if let Some(track) = self.track(*task) {
                    track.never.get_or_insert((at, why.clone()));
                }
            }
            Note::Overran { attempt, .. } => self.attempt(*attempt, |track| track.overran(at)),
            Note::Removed(_) | Note::Stopping { .. } | Note::Runaway(_) | Note::Mode { .. } => {}
        }
    }

    fn answer(&mut self, _: Now, _: TelecommandId, reply: Reply) {
        if let Reply::Refused(why) = reply {
            self.refused = Some(why);
        }
    }

    fn load(&mut self, _: Attempt, path: &str) -> Option<LoadedFile> {
        let file = self.surroundings.load(path);
        if let Ok(tasks) = &file {
            self.gives(tasks);
        }
        Some(file)
    }
}
