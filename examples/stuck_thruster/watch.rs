//! Recorder lanes that watch the guarantees from outside.

use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use faregate::tickets::clock::Instant;
use faregate::tickets::fault::GateFault;
use faregate::tickets::id::GateId;
use faregate::tickets::recorder::{Lane, Record, RecordedEvent};
use faregate_devices_sim::{Command, Outcome, ReceivedCommand, Spacecraft};

use crate::stage::Story;
use crate::tape::Hold;

/// What the lanes of one run write together.
pub(crate) struct Watch {
    craft: Spacecraft,
    story: Story,
    /// How often anything was revoked: whoever finds the same number before and
    /// after was not revoked in between.
    revocations: AtomicUsize,
    /// Devices that proved stuck or whose drivers hung: each costs a round.
    rounds: AtomicU32,
    door: Mutex<Door>,
    holds: Mutex<Holds>,
}

/// Who held what, and who still does since when.
#[derive(Default)]
struct Holds {
    over: Vec<Hold>,
    open: Vec<Hold>,
}

/// What the monitor may not do to the camera now.
#[derive(Default)]
struct Door {
    /// Since when the monitor has no right to the camera: the entries of the
    /// trace then, and those of its commands that were in progress.
    closed: Option<(usize, Vec<usize>)>,
    /// Commands that came through all the same.
    passed: u32,
}

impl Watch {
    pub(crate) fn new(craft: &Spacecraft, story: Story) -> Arc<Self> {
        Arc::new(Self {
            craft: craft.clone(),
            story,
            revocations: AtomicUsize::new(0),
            rounds: AtomicU32::new(1),
            door: Mutex::default(),
            holds: Mutex::default(),
        })
    }

    pub(crate) fn lane(self: &Arc<Self>, device: &'static str, by: &'static str) -> WatchLane {
        WatchLane { watch: Arc::clone(self), device, by }
    }

    pub(crate) fn revocations(&self) -> usize {
        self.revocations.load(Ordering::SeqCst)
    }

    pub(crate) fn rounds(&self) -> u32 {
        self.rounds.load(Ordering::SeqCst)
    }

    /// From now the monitor has no right to the camera.
    pub(crate) fn close_door(&self) {
        let trace = self.craft.trace();
        let in_progress = (0..trace.len()).filter(|entry| is_in_progress(&trace[*entry]));
        let closed = Some((trace.len(), in_progress.collect()));
        self.door.lock().expect("no watcher panics").closed = closed;
    }

    /// From now it has.
    pub(crate) fn open_door(&self) {
        let trace = self.craft.trace();
        let mut door = self.door.lock().expect("no watcher panics");
        let Some((since, in_progress)) = door.closed.take() else { return };
        let late = trace.iter().skip(since).filter(|entry| is_the_monitors(entry)).count();
        let passed = late + in_progress.len();
        door.passed += u32::try_from(passed).unwrap_or(u32::MAX);
    }

    /// The commands that came through while the door was closed.
    pub(crate) fn passed(&self) -> u32 {
        self.open_door();
        self.door.lock().expect("no watcher panics").passed
    }

    /// Who held what; whoever holds it at the end of the run held it so long.
    pub(crate) fn holds(&self, end: Instant) -> Vec<Hold> {
        let Holds { mut over, open } =
            std::mem::take(&mut *self.holds.lock().expect("no watcher panics"));
        over.extend(open.into_iter().map(|hold| Hold { until: end, ..hold }));
        over
    }
}

fn is_the_monitors(entry: &ReceivedCommand) -> bool {
    entry.by == "monitor" && matches!(entry.command, Command::Camera(_))
}

fn is_in_progress(entry: &ReceivedCommand) -> bool {
    is_the_monitors(entry) && entry.outcome == Outcome::InProgress
}

/// A lane that watches one gate, or the broker.
pub(crate) struct WatchLane {
    watch: Arc<Watch>,
    device: &'static str,
    by: &'static str,
}

impl Lane for WatchLane {
    fn record(&mut self, record: Record) {
        self.tell(&record);
        match record.event {
            RecordedEvent::Revoked(_) | RecordedEvent::Ended => {
                self.watch.revocations.fetch_add(1, Ordering::SeqCst);
            }
            RecordedEvent::Stuck { .. } | RecordedEvent::Faulted { fault: GateFault::Hung, .. } => {
                self.watch.rounds.fetch_add(1, Ordering::SeqCst);
            }
            RecordedEvent::Vacated { .. } => self.vacated(record.at),
            RecordedEvent::Admitted { .. } => self.admitted(record.at),
            _ => {}
        }
    }
}

/// A gate's device, in the order of registration.
fn name(gate: GateId) -> &'static str {
    ["camera", "cutoff valve", "heaters"].get(usize::from(gate.0)).copied().unwrap_or("device")
}

impl WatchLane {
    /// What a person wants to read of what is recorded.
    fn tell(&self, record: &Record) {
        let Record { at, ticket, event } = *record;
        let what = match event {
            RecordedEvent::Granted => format!("ticket {ticket} becomes valid"),
            RecordedEvent::Revoked(why) => format!("ticket {ticket} is revoked: {why}"),
            RecordedEvent::Ended => format!("ticket {ticket} has ended"),
            RecordedEvent::SeenOff { gate } => {
                format!("sees the {} off: its charge is credited", name(gate))
            }
            RecordedEvent::Stuck { gate } => {
                format!("the {} cannot be made safe: its charge stays", name(gate))
            }
            RecordedEvent::Safed { attempt } => {
                format!("issues the safing command of the {} (attempt {attempt})", self.device)
            }
            RecordedEvent::Faulted { gate, fault } => {
                format!("the gate of the {} is faulted: {fault}", name(gate))
            }
            _ => return,
        };
        self.watch.story.tell(at, "agent", || what);
    }

    fn vacated(&self, at: Instant) {
        if self.device == "camera" {
            self.watch.close_door();
        }
        let mut holds = self.watch.holds.lock().expect("no watcher panics");
        if let Some(open) = holds.open.iter().position(|hold| hold.device == self.device) {
            let hold = holds.open.remove(open);
            holds.over.push(Hold { until: at, ..hold });
        }
    }

    fn admitted(&self, at: Instant) {
        if self.device == "camera" {
            self.watch.open_door();
        }
        let hold = Hold { device: self.device, by: self.by, from: at, until: at };
        self.watch.holds.lock().expect("no watcher panics").open.push(hold);
    }
}
