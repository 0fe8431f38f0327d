//! Plays the case, and looks on.

use std::collections::BTreeMap;
use std::fs;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::SeqCst};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use faregate_agents::Categories;
use faregate_scheduler::executive::{Commands, Correspondent, LoadedFile, Outside, Watched};
use faregate_scheduler::manager::{
    Attempt, Event, Manager, Note, Occurrence, Reply, TelecommandId,
};
use faregate_scheduler::mission::{AgentSpec, DeviceSpec};
use faregate_scheduler::task::Task;
use faregate_scheduler::tickets::{Commander, Named, Tickets};
use faregate_scheduler::time::Now;
use faregate_scheduler::{Mission, Onboard, TaskId, format};
use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::{Declaration, Effect, Estimate, Power, Profile};

/// The case as it is in the fixture; the program of the routine task is ours.
const CASE: &str = include_str!("../cases/smaarte_preempt.csv");

const DRAW: Milliwatts = Milliwatts::from_watts(5);

/// What the camera really is.
#[derive(Debug, Default)]
pub(crate) struct Truth {
    pub(crate) on: AtomicBool,
}

struct Camera(Arc<Truth>);

impl Device for Camera {
    type Command = bool;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        let mut profile = Profile::new().drawing(DRAW);
        profile.estimate_lag = Duration::from_secs(5);
        // An ordinary host stops threads for as long.
        profile.longest_command = Duration::from_secs(1);
        profile
    }
    fn declare(on: &bool) -> Declaration {
        let wcet = Duration::from_secs(1);
        let effect = if *on { Effect::on(DRAW) } else { Effect::Off };
        Declaration { code: (*on).into(), wcet, effect }
    }
    fn issue(&mut self, on: bool) -> Result<(), ()> {
        self.0.on.store(on, SeqCst);
        Ok(())
    }
    fn safe(&mut self) -> Result<(), ()> {
        self.issue(false)
    }
}

/// Clock ticks that each process has used, by its number.
pub(crate) type Ticks = BTreeMap<i32, u64>;

/// What was seen.
pub(crate) struct Seen {
    /// What was told, and when, in seconds after the beginning, as for commands.
    pub(crate) notes: Vec<(f64, Note)>,
    /// What became of each command, and when it was asked.
    pub(crate) commands: Vec<(f64, Result<(), String>)>,
    /// The tree's use of processors before the pause, when it was paused, when
    /// it went on, and some time after.
    pub(crate) before: Ticks,
    pub(crate) at_pause: Ticks,
    pub(crate) at_resumption: Ticks,
    pub(crate) after: Ticks,
    pub(crate) truth: Arc<Truth>,
}

/// Everything outside, which sees the tree at each change.
struct Watch {
    began: Instant,
    main: Arc<AtomicU32>,
    notes: Vec<(f64, Note)>,
    ticks: Arc<Mutex<BTreeMap<&'static str, Ticks>>>,
}

impl Watch {
    fn look(&self, name: &'static str) {
        self.ticks.lock().unwrap().insert(name, ticks(self.main.load(SeqCst)));
    }
}

impl Outside for Watch {
    fn note(&mut self, _: Now, note: &Note) {
        match note {
            Note::Paused(_) => self.look("at pause"),
            // The taker is over, and nobody has let the tree go on yet.
            Note::Over { attempt, .. } if attempt.occurrence.task.get() == 32 => {
                self.look("at resumption");
            }
            _ => {}
        }
        self.notes.push((self.began.elapsed().as_secs_f64(), note.clone()));
    }

    fn answer(&mut self, _: Now, _: TelecommandId, _: Reply) {}

    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        None
    }
}

impl Watched for Watch {}

impl Correspondent for Watch {
    fn poll(&mut self, _: Now, _: &Manager, _: &mut Vec<Event>) {}
}

fn mission() -> Mission {
    let camera = DeviceSpec {
        name: "camera".into(),
        kind: "test".into(),
        agent: "tasks".into(),
        draw: None,
        categories: Categories::NONE,
        parameters: BTreeMap::new(),
    };
    Mission {
        agents: vec![AgentSpec { name: "tasks".into(), supply: Some(DRAW) }],
        devices: vec![camera],
        ..Mission::default()
    }
}

/// The tasks of the file; the routine one works, and commands the camera.
fn tasks() -> Vec<Task> {
    let itself = std::env::current_exe().unwrap();
    let works = format!(
        "env {}=20 {} --exact works --ignored --test-threads=1",
        super::work::SECONDS,
        itself.display()
    );
    let text = CASE.replace("sleep 20", &works);
    let mut tasks = format::read("case.csv", text.as_bytes()).expect("a valid schedule").tasks;
    tasks[0].gates = vec!["camera".into()];
    tasks
}

pub(crate) fn play() -> Seen {
    let truth = Arc::new(Truth::default());
    let driver = Named::new(Camera(Arc::clone(&truth))).command("on", true, "light it");
    let (main, ticks) = (Arc::new(AtomicU32::new(0)), Arc::default());
    let began = Instant::now();
    let watch =
        Watch { began, main: Arc::clone(&main), notes: Vec::new(), ticks: Arc::clone(&ticks) };
    let builder = Onboard::builder(mission()).unwrap().device("camera", Box::new(driver)).unwrap();
    let mut onboard = builder.start_with(|_, _, _| Ok(watch)).unwrap();
    let tickets: &Tickets = onboard.tickets();
    let (commander, over) = (tickets.commander(), Arc::new(AtomicBool::new(false)));
    let hammer = hammer(commander, began, Arc::clone(&over));
    onboard.load(tasks()).unwrap();
    let has = |onboard: &mut Onboard<Watch>, is: fn(&Note) -> bool| {
        onboard.outside().notes.iter().any(|(_, note)| is(note))
    };
    let mut attempt = None;
    let watched = Arc::clone(&ticks);
    loop {
        while onboard.turn().unwrap() {}
        attempt = attempt.or_else(|| first(onboard.outside()));
        let pid = attempt.and_then(|attempt| onboard.bodies().pid(attempt));
        if let Some(pid) = pid {
            main.store(u32::try_from(pid).unwrap(), SeqCst);
        }
        let ended = |note: &Note| matches!(note, Note::Ended { occurrence, .. } if occurrence.task.get() == 31);
        if has(&mut onboard, ended) {
            break;
        }
        sense(onboard.tickets(), &truth);
        let soon = onboard.now().elapsed.after(Duration::from_millis(100));
        onboard.run_until(soon, |_, _| false).unwrap();
        let name = if has(&mut onboard, |note| matches!(note, Note::Resumed(_))) {
            "after"
        } else if has(&mut onboard, |note| matches!(note, Note::Stopping { .. })) {
            continue;
        } else {
            "before"
        };
        let now = self::ticks(main.load(SeqCst));
        if now.len() == 2 {
            watched.lock().unwrap().insert(name, now);
        }
    }
    over.store(true, SeqCst);
    let commands = hammer.join().unwrap();
    let notes = std::mem::take(&mut onboard.outside().notes);
    let patience = Instant::now();
    while truth.on.load(SeqCst) && patience.elapsed().as_secs() < 20 {
        let soon = onboard.now().elapsed.after(Duration::from_millis(20));
        onboard.run_until(soon, |_, _| false).unwrap();
    }
    onboard.close().unwrap();
    let mut seen = ticks.lock().unwrap().clone();
    let mut take = |name| seen.remove(name).unwrap_or_default();
    Seen {
        notes,
        commands,
        before: take("before"),
        at_pause: take("at pause"),
        at_resumption: take("at resumption"),
        after: take("after"),
        truth,
    }
}

/// The sensors' word on the camera.
fn sense(tickets: &Tickets, truth: &Truth) {
    let measured_at = tickets.broker().clock().now();
    let state = if truth.on.load(SeqCst) { Power::On } else { Power::Off };
    let gate = tickets.commander().gates().id("camera").unwrap();
    tickets.broker().observe(gate, Estimate { state, measured_at });
}

fn first(watch: &Watch) -> Option<Attempt> {
    watch.notes.iter().find_map(|(_, note)| match note {
        Note::Started(attempt) if attempt.occurrence.task.get() == 31 => Some(*attempt),
        _ => None,
    })
}

/// Commands the camera for the routine task all the time, as a thread that
/// knows nothing of the other task does.
fn hammer(
    commander: Commander,
    began: Instant,
    over: Arc<AtomicBool>,
) -> std::thread::JoinHandle<Vec<(f64, Result<(), String>)>> {
    let task = TaskId::new(31).unwrap();
    let attempt = Attempt { occurrence: Occurrence { task, load: 0, number: 0 }, number: 1 };
    std::thread::spawn(move || {
        let mut answers = Vec::new();
        while !over.load(SeqCst) {
            let asked = began.elapsed().as_secs_f64();
            let answer = commander.command(attempt, "camera", "on", &[]);
            answers.push((asked, answer.map(drop).map_err(|refused| refused.to_string())));
            std::thread::park_timeout(std::time::Duration::from_millis(5));
        }
        answers
    })
}

/// What the process and its descendants have used, in clock ticks.
fn ticks(main: u32) -> Ticks {
    let Ok(main) = i32::try_from(main) else { return Ticks::new() };
    let Some((_, used)) = stat(main) else { return Ticks::new() };
    let mut tree = Ticks::from([(main, used)]);
    // A child is its parent's, whichever thread begot it.
    let all = fs::read_dir("/proc")
        .unwrap()
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse::<i32>().ok());
    for pid in all {
        if let Some((parent, used)) = stat(pid)
            && parent == main
        {
            tree.insert(pid, used);
        }
    }
    tree
}

/// Parent and clock ticks, of user and of system.
fn stat(pid: i32) -> Option<(i32, u64)> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let fields: Vec<_> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let number = |field: usize| fields.get(field)?.parse::<u64>().ok();
    Some((fields.get(1)?.parse().ok()?, number(11)? + number(12)?))
}
