//! Writes down what a manager on the host's clock tells.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use faregate_scheduler::executive::{Correspondent, LoadedFile, Outside, Watched};
use faregate_scheduler::manager::{Attempt, Event, Manager, Note, Reply, TelecommandId};
use faregate_scheduler::task::Task;
use faregate_scheduler::time::{Duration, Instant, Now};
use faregate_scheduler::{Mission, Onboard};

/// What was told, and when.
#[derive(Default)]
pub(crate) struct Diary(Vec<(Instant, Note)>);

impl Diary {
    /// With instants that count from the load, which is the first that is told.
    pub(crate) fn told(self) -> Vec<(Instant, Note)> {
        let Some((load, _)) = self.0.first().cloned() else { return Vec::new() };
        let since = |at: Instant| Instant::START.after(at.since(load));
        self.0.into_iter().map(|(at, note)| (since(at), note)).collect()
    }
}

impl Outside for Diary {
    fn note(&mut self, now: Now, note: &Note) {
        self.0.push((now.elapsed, note.clone()));
    }

    fn answer(&mut self, _: Now, _: TelecommandId, _: Reply) {}

    fn load(&mut self, _: Attempt, _: &str) -> Option<LoadedFile> {
        None
    }
}

impl Watched for Diary {}

impl Correspondent for Diary {
    fn poll(&mut self, _: Now, _: &Manager, _: &mut Vec<Event>) {}
}

/// Runs these tasks until so long after their load. Answers how late a thread
/// woke meanwhile that does nothing else.
pub(crate) fn run(tasks: Vec<Task>, until: Instant) -> (Vec<(Instant, Note)>, Duration) {
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let late = scope.spawn(|| worst_wake_up(&over));
        let told = play(tasks, until);
        over.store(true, SeqCst);
        (told, late.join().unwrap())
    })
}

fn worst_wake_up(over: &AtomicBool) -> Duration {
    const PERIOD: std::time::Duration = std::time::Duration::from_millis(2);
    let mut worst = std::time::Duration::ZERO;
    while !over.load(SeqCst) {
        let asleep = std::time::Instant::now();
        std::thread::park_timeout(PERIOD);
        worst = worst.max(asleep.elapsed().saturating_sub(PERIOD));
    }
    worst.into()
}

fn play(tasks: Vec<Task>, until: Instant) -> Vec<(Instant, Note)> {
    let builder = Onboard::builder(Mission::default()).unwrap();
    let mut onboard = builder.start_with(|_, _, _| Ok(Diary::default())).unwrap();
    onboard.load(tasks).unwrap();
    let loaded = onboard.now().elapsed;
    let end = loaded.after(until.since(Instant::START));
    onboard.run_until(end, |manager, _| manager.is_over()).unwrap();
    let (_, _, _, diary) = onboard.into_ports();
    diary.told()
}
