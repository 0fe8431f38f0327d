//! The busy sol of the examples on the manager's virtual executive.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use faregate_planner::file;
use faregate_planner::plan::ActivityId;
use faregate_planner::tasks::{Director, Epoch, Library, Setting};
use faregate_planner::timed::{Projection, TimedPlan};
use faregate_planner::units::{Span, Time};
use faregate_planner::{Parameters, Plan, State, project};
use faregate_scheduler::executive::{
    Conduct, LoadedFile, Outside, VirtualBodies, VirtualExecutive, expected,
};
use faregate_scheduler::format::{self, Against};
use faregate_scheduler::manager::State as TaskState;
use faregate_scheduler::manager::{
    Addition, Attempt, Event, Exit, Note, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::task::{Task, TaskId};
use faregate_scheduler::time::{Duration, Instant, Now, UnixTime};
use faregate_scheduler::{Manager, Mission};
use faregate_tickets::amount::Microjoules;

const ROVER: &str = include_str!("../../../examples/sols/rover.toml");
const PLAN: &str = include_str!("../../../examples/sols/busy/plan.xml");
const STATE: &str = include_str!("../../../examples/sols/busy/state.xml");
const PARAMETERS: &str = include_str!("../../../examples/sols/parameters.xml");

/// The rover of the example sols.
pub(crate) fn mission() -> Mission {
    let options = format::Options { against: Against::Own, ..format::Options::default() };
    format::read_with(options, "rover.toml", ROVER.as_bytes()).unwrap().mission.unwrap()
}

pub(crate) fn library() -> Library {
    Library::read("rover.toml", ROVER.as_bytes()).unwrap()
}

pub(crate) fn parameters() -> Parameters {
    file::parameters("parameters.xml", PARAMETERS.as_bytes()).unwrap().value
}

pub(crate) fn setting() -> Setting {
    let parameters = parameters();
    let plan = file::plan("plan.xml", PLAN.as_bytes(), Some(&parameters)).unwrap().value;
    Setting {
        plan: Arc::new(plan),
        parameters: Arc::new(parameters),
        library: Arc::new(library()),
        mission: Arc::new(mission()),
        epoch: Epoch::new(UnixTime::from_secs(1_900_000_000)),
    }
}

pub(crate) fn state() -> State {
    file::state("state.xml", STATE.as_bytes(), Some(&parameters())).unwrap().value
}

pub(crate) fn id(number: u32) -> ActivityId {
    ActivityId::new(number).unwrap()
}

pub(crate) fn task_id(number: u32) -> TaskId {
    TaskId::new(number).unwrap()
}

/// An instant of the day, in hours and minutes.
pub(crate) const fn clock(hours: i64, minutes: i64) -> Time {
    Time::ZERO.after(Span::from_mins(hours * 60 + minutes))
}

/// Keeps what is told.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ears {
    pub(crate) told: Arc<Mutex<Vec<(Now, Note)>>>,
    pub(crate) refused: Arc<Mutex<Vec<String>>>,
}

impl Outside for Ears {
    fn note(&mut self, now: Now, note: &Note) {
        self.told.lock().unwrap().push((now, note.clone()));
    }
    fn answer(&mut self, _: Now, _: TelecommandId, reply: Reply) {
        if let Reply::Refused(why) = reply {
            self.refused.lock().unwrap().push(why);
        }
    }
    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        None
    }
}

/// What a task really does, where that is not what is expected.
pub(crate) type Fates = BTreeMap<u32, Conduct>;

pub(crate) fn ends_after(minutes: u64, exit: Exit) -> Conduct {
    Conduct { takes: Duration::from_secs(60 * minutes), exit }
}

/// A sol that is executed.
pub(crate) struct Stage {
    setting: Setting,
    pub(crate) director: Director,
    executive: VirtualExecutive<Ears>,
    ears: Ears,
    commands: u64,
    /// What the sensors say of the charge, where it is not as planned.
    pub(crate) measured: Option<Microjoules>,
    /// The projection of the plan that is executed: the battery does as planned.
    planned: Projection,
    /// Everything that happened, in the plan's time.
    pub(crate) story: Vec<(Time, Note)>,
    /// What tasks are called.
    names: BTreeMap<TaskId, String>,
    /// Every plan, and when it was made.
    pub(crate) plans: Vec<(Time, TimedPlan)>,
}

impl Stage {
    pub(crate) fn new(fates: Fates) -> Self {
        Self::of(setting(), state(), fates)
    }

    pub(crate) fn of(setting: Setting, state: State, fates: Fates) -> Self {
        let bodies = VirtualBodies::new(move |_, task: &Task| {
            let usual = Conduct::succeeds_after(expected(task));
            fates.get(&task.id.get()).cloned().unwrap_or(usual)
        });
        let ears = Ears::default();
        let begin = setting.epoch.wall(state.now);
        let mission = (*setting.mission).clone();
        let executive = VirtualExecutive::new(mission, begin, bodies, ears.clone());
        let director = Director::new(setting.clone(), state);
        let (planned, story, plans) = (Projection::default(), Vec::new(), Vec::new());
        let (names, commands, measured) = (BTreeMap::new(), 0, None);
        Self {
            setting,
            director,
            executive,
            ears,
            commands,
            measured,
            planned,
            story,
            names,
            plans,
        }
    }

    /// Executes until then.
    pub(crate) fn until(&mut self, end: Time) -> &mut Self {
        loop {
            self.settle();
            let next = self.next().filter(|next| self.time_of(*next) <= end);
            let Some(next) = next else { break };
            self.executive.advance_to(next).unwrap();
        }
        let at = self.instant_of(end);
        self.executive.advance_to(at).unwrap();
        self.settle();
        self
    }

    /// The manager is told something; one decision follows.
    pub(crate) fn command(&mut self, telecommands: Vec<Telecommand>) {
        for telecommand in telecommands {
            let id = TelecommandId(self.commands);
            self.commands += 1;
            self.executive.tell(Event::Telecommand { id, telecommand });
        }
        let now = self.executive.now().elapsed;
        self.executive.advance_to(now).unwrap();
    }

    pub(crate) fn manager(&self) -> &Manager {
        self.executive.manager()
    }

    /// The number of the task of this name that runs.
    pub(crate) fn number_of(&self, name: &str) -> u32 {
        let runs = |state: &TaskState| matches!(state, TaskState::Running(_));
        let mut running = self.manager().status().filter(|status| runs(&status.state));
        let called = |id| self.names.get(&id).is_some_and(|one| one == name);
        let found = running.find(|status| called(status.occurrence.task));
        found.expect("it runs").occurrence.task.get()
    }

    /// The present attempt of a task, or its first one.
    pub(crate) fn attempt_of(&self, id: TaskId) -> Attempt {
        let mut known = self.manager().status().map(|status| status.occurrence);
        let occurrence = known.find(|one| one.task == id).expect("it is in the schedule");
        Attempt { occurrence, number: 1 }
    }

    pub(crate) fn plan(&self) -> &Plan {
        &self.setting.plan
    }

    /// What the manager refused: nothing, or the director is wrong.
    pub(crate) fn refused(&self) -> Vec<String> {
        self.ears.refused.lock().unwrap().clone()
    }

    /// When an activity started.
    pub(crate) fn start_of(&self, number: u32) -> Option<Time> {
        let started = |note: &Note| matches!(note, Note::Started(attempt) if attempt.occurrence.task.get() == number);
        self.story.iter().find(|(_, note)| started(note)).map(|(at, _)| *at)
    }

    /// When heating of a zone began, each time that it did.
    pub(crate) fn starts_of_heating(&self, zone: &str) -> Vec<Time> {
        self.starts_of_task(&format!("heat {zone}"))
    }

    /// Starts of everything that is called so.
    pub(crate) fn starts_of_task(&self, name: &str) -> Vec<Time> {
        let called = |id| self.names.get(&id).is_some_and(|one| *one == name);
        let begins =
            |note: &Note| matches!(note, Note::Started(attempt) if called(attempt.occurrence.task));
        self.story.iter().filter(|(_, note)| begins(note)).map(|(at, _)| *at).collect()
    }

    /// Until nothing more happens at this instant.
    fn settle(&mut self) {
        loop {
            let now = self.now();
            let told = std::mem::take(&mut *self.ears.told.lock().unwrap());
            for (at, note) in told {
                let at = self.setting.epoch.time(at.wall);
                if let Note::Accepted(id) = note {
                    let name = self.manager().task(id).and_then(|task| task.name.clone());
                    self.names.extend(name.map(|name| (id, name)));
                }
                self.director.heard(at, &note);
                self.story.push((at, note));
            }
            self.director.charge(self.measured.unwrap_or_else(|| self.charge_at(now)));
            let made_from = self.director.timed().clone();
            let orders = self.director.turn(now).unwrap();
            if *self.director.timed() != made_from {
                self.plans.push((now, self.director.timed().clone()));
                self.project();
            }
            if orders.is_empty() {
                return;
            }
            self.command(orders);
        }
    }

    fn project(&mut self) {
        let Setting { plan, parameters, .. } = &self.setting;
        let (state, timed) = (self.director.state(), self.director.timed());
        self.planned = project(plan, parameters, state, timed).unwrap();
    }

    /// The charge as it was planned, between points in a straight line.
    fn charge_at(&self, now: Time) -> Microjoules {
        let Some(line) = self.planned.lines.first() else { return self.director.state().charge };
        let later = line.points.partition_point(|(at, _)| *at <= now);
        let (before, after) = (line.points.get(later.wrapping_sub(1)), line.points.get(later));
        let charge = match (before, after) {
            (Some((t0, y0)), Some((t1, y1))) => {
                let (part, whole) = (now.since(*t0).get(), t1.since(*t0).get().max(1));
                y0 + i64::try_from(i128::from(y1 - y0) * i128::from(part) / i128::from(whole))
                    .unwrap()
            }
            (Some((_, y)), None) | (None, Some((_, y))) => *y,
            (None, None) => return self.director.state().charge,
        };
        Microjoules::new(u64::try_from(charge).unwrap_or(0))
    }

    fn now(&self) -> Time {
        self.setting.epoch.time(self.executive.now().wall)
    }

    fn next(&self) -> Option<Instant> {
        let due = self.instant_of(self.director.due());
        let now = self.executive.now().elapsed;
        self.executive.next_due().into_iter().chain([due]).filter(|at| *at > now).min()
    }

    fn time_of(&self, at: Instant) -> Time {
        let ahead = at.since(self.executive.now().elapsed).as_micros() / 1_000;
        self.now().after(Span::new(i64::try_from(ahead).unwrap()))
    }

    fn instant_of(&self, at: Time) -> Instant {
        let ahead = u64::try_from(at.since(self.now()).get()).unwrap_or(0);
        self.executive.now().elapsed.after(Duration::from_millis(ahead))
    }
}

/// A task that is to come in.
pub(crate) fn adding(task: Task) -> Telecommand {
    Telecommand::Add(vec![Addition { task }])
}
