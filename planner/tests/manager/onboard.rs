//! A plan on the manager of a host, in real time: a real broker, simulated
//! lamps, and spans of tenths of a second. Only orders are judged: a host may be
//! as slow as it likes.

use std::sync::atomic::Ordering::SeqCst;
use std::sync::{Arc, Mutex};

use faregate_agents::Supervisor;
use faregate_planner::parameters::Day;
use faregate_planner::plan::{Activity, Dependency, Outcome, StartRange, Status};
use faregate_planner::state::Mode;
use faregate_planner::tasks::{Director, Epoch, Library, Setting};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
use faregate_planner::{Parameters, Plan, State};
use faregate_runtime::Broker;
use faregate_scheduler::Onboard;
use faregate_scheduler::executive::{Correspondent, LoadedFile, Outside, Watched};
use faregate_scheduler::manager::{
    Attempt, Event, Manager, Note, Reply, Telecommand, TelecommandId,
};
use faregate_scheduler::task::Step;
use faregate_scheduler::tickets::{Commander, Named};
use faregate_scheduler::time::{Duration, Now};
use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::Clock;
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::id::Priority;

use crate::lamps::{LAMP, LAMPS, Lamp, Truth, mission};
use crate::stage::{id, task_id};

/// Sensors are read, and notes are heard, at least this often.
const ROUND: Duration = Duration::from_millis(5);
/// A host that is this slow is broken.
const GIVE_UP: Duration = Duration::from_secs(60);

fn step(at: u64, gate: &str, command: &str) -> Step {
    Step {
        offset: Duration::from_millis(at),
        gate: gate.into(),
        command: command.into(),
        arguments: Vec::new(),
        continues: false,
    }
}

fn library() -> Library {
    let mut library = Library::new();
    for lamp in LAMPS {
        library.add(lamp, vec![step(0, lamp, "on"), step(100, lamp, "off")]);
    }
    library
}

/// Lights a lamp for two tenths of a second, from 400 ms on and not later than
/// this.
fn light(number: u32, lamp: &str, to: i64) -> Activity {
    let starts =
        vec![StartRange { from: Time::new(400), to: Time::new(to), cutoff: Time::new(80_000) }];
    Activity {
        sequence: Some(lamp.into()),
        priority: 200 - number,
        peak: LAMP,
        engines: 1,
        starts,
        ..Activity::new(id(number), Span::new(200))
    }
}

/// The second one can start until then.
fn plan(to: i64) -> Plan {
    let after = vec![Dependency { prior: id(1), statuses: vec![Status::Succeeded] }];
    Plan {
        end: Time::new(90_000),
        max_delta_data: Bytes::new(1),
        activities: vec![
            light(1, "floodlight", 70_000),
            light(2, "beacon", to),
            Activity { after, ..light(3, "beacon", 70_000) },
        ],
        ..Plan::default()
    }
}

fn parameters() -> Parameters {
    Parameters {
        mandatory_from: 100,
        max_soc: Ppm::new(1_000_000),
        peak_limit: Milliwatts::from_watts(42),
        engines: 2,
        day: Day::SOL,
        commit: Span::new(50),
        handover_tolerance: Span::new(20),
        soft_samples: 1,
        // Longer than the plan: the computer is up all the time.
        min_awake: Span::from_mins(5),
        ..Parameters::default()
    }
}

#[derive(Clone, Default)]
struct Ears(Arc<Mutex<Vec<(Now, Note)>>>);

impl Outside for Ears {
    fn note(&mut self, now: Now, note: &Note) {
        self.0.lock().unwrap().push((now, note.clone()));
    }
    fn answer(&mut self, _: Now, _: TelecommandId, _: Reply) {}
    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        None
    }
}

impl Watched for Ears {}

impl Correspondent for Ears {
    fn poll(&mut self, _: Now, _: &Manager, _: &mut Vec<Event>) {}
}

struct Bench {
    onboard: Onboard<Ears>,
    director: Director,
    epoch: Epoch,
    ears: Ears,
    broker: Broker,
    commander: Commander,
    supervisor: Supervisor,
    lamps: [Arc<Truth>; 2],
    story: Vec<String>,
}

impl Bench {
    fn new(to: i64) -> Self {
        let lamps: [Arc<Truth>; 2] = Default::default();
        let mut builder = Onboard::builder(mission()).unwrap();
        for (name, truth) in LAMPS.iter().zip(&lamps) {
            let lamp = Named::new(Lamp(Arc::clone(truth))).command("on", true, "light it").command(
                "off",
                false,
                "darken it",
            );
            builder = builder.device(name, Box::new(lamp)).unwrap();
        }
        let supervisor = builder.installation().supervisor();
        let ears = Ears::default();
        let mut reached = None;
        let onboard = builder.start_with(|_, tickets, _| {
            reached = Some((tickets.broker().clone(), tickets.commander()));
            Ok(ears.clone())
        });
        let onboard = onboard.unwrap();
        let (broker, commander) = reached.unwrap();
        let epoch = Epoch::new(onboard.now().wall);
        let setting = Setting {
            plan: Arc::new(plan(to)),
            parameters: Arc::new(parameters()),
            library: Arc::new(library()),
            mission: Arc::new(mission()),
            epoch,
        };
        let full = Microjoules::from_joules(1_000_000);
        let state = State { mode: Mode::Awake, charge: full, capacity: full, ..State::default() };
        let director = Director::new(setting, state);
        let story = Vec::new();
        Self { onboard, director, epoch, ears, broker, commander, supervisor, lamps, story }
    }

    /// The first plan, of the instant 0 however late it is.
    fn begin(&mut self) {
        self.turn(Time::ZERO);
    }

    /// Executes until this was told.
    fn until(&mut self, told: &str) {
        let end = self.onboard.now().elapsed.after(GIVE_UP);
        while !self.story.iter().any(|line| line == told) {
            let now = self.onboard.now();
            assert!(now.elapsed < end, "{told:?} was not told: {:?}", self.story);
            self.measure();
            let heard = Arc::clone(&self.ears.0);
            let round = now.elapsed.after(ROUND);
            self.onboard.run_until(round, |_, _| !heard.lock().unwrap().is_empty()).unwrap();
            self.direct();
        }
    }

    fn direct(&mut self) {
        let told = std::mem::take(&mut *self.ears.0.lock().unwrap());
        for (at, note) in told {
            self.director.heard(self.epoch.time(at.wall), &note);
            self.story.extend(words(&note));
        }
        self.turn(self.epoch.time(self.onboard.now().wall));
    }

    fn turn(&mut self, now: Time) {
        let orders = self.director.turn(now).unwrap();
        let removes = |order: &Telecommand| matches!(order, Telecommand::Remove(_));
        let removing: Vec<_> = orders.iter().map(removes).collect();
        for (reply, removes) in self.onboard.commands(orders).unwrap().iter().zip(removing) {
            // What is over by now need not be removed.
            assert!(*reply == Reply::Done || removes, "{reply:?}");
        }
    }

    fn measure(&self) {
        for (name, truth) in LAMPS.iter().zip(&self.lamps) {
            let measured_at = self.broker.clock().now();
            let state = if truth.on.load(SeqCst) { Power::On } else { Power::Off };
            let gate = self.commander.gates().id(name).unwrap();
            self.broker.observe(gate, Estimate { state, measured_at });
        }
    }

    fn outcome(&self, number: u32) -> Option<Outcome> {
        let ended = self.director.state().ended.iter().find(|ended| ended.id == id(number));
        ended.map(|ended| ended.outcome)
    }

    fn commands(&self) -> usize {
        self.lamps.iter().map(|lamp| lamp.commands.load(SeqCst)).sum()
    }
}

/// What became of activities; other tasks are the planner's own.
fn words(note: &Note) -> Option<String> {
    let (task, what) = match note {
        Note::Started(attempt) => (attempt.occurrence.task, "starts".to_owned()),
        Note::Ended { occurrence, outcome } => (occurrence.task, format!("{outcome:?}")),
        Note::Missed { task, .. } => (*task, "is missed".to_owned()),
        _ => return None,
    };
    (task <= task_id(3)).then(|| format!("{} {what}", task.get()))
}

#[test]
fn nothing_is_dispatched_without_its_tickets_but_pushed_or_not_started() {
    let mut bench = Bench::new(700);
    // A fault response has all gates before anything is due.
    let agents = bench.broker.agents();
    agents.enter_safe_mode(&bench.supervisor, Priority::FAULT_RESPONSE).unwrap().without_waiting();
    bench.begin();
    bench.until("2 is missed");
    assert_eq!(bench.story, ["2 is missed"], "the first one is as due, and waits");
    assert_eq!(bench.commands(), 0);
    assert_eq!(bench.outcome(2), Some(Outcome::NotStarted));
    agents.leave_safe_mode(&bench.supervisor).unwrap();
    bench.until("3 Succeeded");
    let expected = ["2 is missed", "1 starts", "1 Succeeded", "3 starts", "3 Succeeded"];
    assert_eq!(bench.story, expected);
    assert_eq!((bench.outcome(1), bench.commands()), (Some(Outcome::Succeeded), 4));
    assert!(bench.lamps.iter().all(|lamp| !lamp.on.load(SeqCst)));
}

/// The control: with nobody in the way both start, each with an engine of its
/// own, and the third follows.
#[test]
fn with_nobody_in_the_way_everything_is_dispatched() {
    let mut bench = Bench::new(70_000);
    bench.begin();
    bench.until("3 Succeeded");
    let mut begun: Vec<_> =
        bench.story.iter().filter(|line| line.ends_with("starts")).cloned().collect();
    begun[..2].sort();
    assert_eq!(begun, ["1 starts", "2 starts", "3 starts"]);
    assert_eq!((bench.outcome(2), bench.commands()), (Some(Outcome::Succeeded), 6));
}
