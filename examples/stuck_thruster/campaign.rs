//! The campaign: every design flies the same seeds, interleaved in virtual
//! time.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use faregate::tickets::clock::Duration;
use faregate_devices_sim::Law;
use faregate_devices_sim::interleave::SimLocked;
use indicatif::ProgressBar;
use serde::Serialize;

use crate::design::{Ablation, Design, Kind, Rival};
use crate::flight::Flight;
use crate::scene::{Scene, WINDOWS_MS};
use crate::stage::Stage;
use crate::tape::Tape;
use crate::tickets::Variant;

/// How many runs it takes until a rival that never loses is a surprise.
pub(crate) const TELLING_RUNS: u64 = 200;

/// What came of all runs of a design.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) kind: Kind,
    pub(crate) runs: u64,
    pub(crate) lost: u64,
    /// How many were lost by which law.
    pub(crate) lost_by: BTreeMap<&'static str, u64>,
    /// The first seed that was lost.
    pub(crate) first_lost_seed: Option<u64>,
    pub(crate) commands_after_quiescence: u64,
    pub(crate) valid_refused: u64,
    pub(crate) cutoffs_actuated: u64,
    pub(crate) restored: u64,
    pub(crate) restorable: u64,
    /// The longest time from the request to the cutoff command.
    pub(crate) worst_cutoff_ms: Option<f64>,
    /// The computed bound of that run.
    pub(crate) bound_of_worst_ms: Option<f64>,
    /// Cutoffs that came later than the bound of their run.
    pub(crate) cutoffs_over_bound: u64,
}

/// What came of the whole campaign.
#[derive(Debug, Serialize)]
pub(crate) struct Campaign {
    pub(crate) first_seed: u64,
    pub(crate) designs: Vec<Row>,
    /// The rivals' losses when nobody keeps the camera on.
    pub(crate) rivals_lost_without_monitor: u64,
    /// Of the design with allocations by convention: the width of the window
    /// between check and command, the runs with it, the losses.
    pub(crate) convention_by_window_ms: Vec<(u64, u64, u64)>,
}

fn millis(duration: Duration) -> f64 {
    core::time::Duration::from(duration).as_secs_f64() * 1e3
}

/// The law that was broken, in two words.
pub(crate) fn law_name(law: &Law) -> &'static str {
    match law {
        Law::BusTripped { .. } => "bus trip",
        Law::PropulsionTripped { .. } => "propulsion trip",
        Law::SpunUp { .. } => "spin-up",
    }
}

impl Row {
    fn new(design: Design) -> Self {
        Self {
            name: design.name(),
            kind: design.kind(),
            runs: 0,
            lost: 0,
            lost_by: BTreeMap::new(),
            first_lost_seed: None,
            commands_after_quiescence: 0,
            valid_refused: 0,
            cutoffs_actuated: 0,
            restored: 0,
            restorable: 0,
            worst_cutoff_ms: None,
            bound_of_worst_ms: None,
            cutoffs_over_bound: 0,
        }
    }

    fn add(&mut self, seed: u64, flight: &Flight) {
        self.runs += 1;
        if let Some((_, law)) = &flight.lost {
            self.lost += 1;
            *self.lost_by.entry(law_name(law)).or_default() += 1;
            self.first_lost_seed = Some(self.first_lost_seed.map_or(seed, |first| first.min(seed)));
        }
        self.commands_after_quiescence += u64::from(flight.after_quiescence);
        self.valid_refused += u64::from(flight.valid_refused);
        self.cutoffs_actuated += u64::from(flight.cutoff_after.is_some());
        self.restorable += u64::from(flight.restored.is_some());
        self.restored += u64::from(flight.restored == Some(true));
        let Some(took) = flight.cutoff_after else { return };
        self.cutoffs_over_bound += u64::from(flight.bound.is_some_and(|bound| took > bound));
        if self.worst_cutoff_ms.is_none_or(|worst| millis(took) > worst) {
            self.worst_cutoff_ms = Some(millis(took));
            self.bound_of_worst_ms = flight.bound.map(millis);
        }
    }

    /// Why this row breaks what is claimed of its design, if it does.
    pub(crate) fn complaint(&self) -> Option<String> {
        let name = self.name;
        let saves = self.lost == 0
            && self.commands_after_quiescence == 0
            && self.valid_refused == 0
            && self.cutoffs_actuated == self.runs
            && self.cutoffs_over_bound == 0
            && self.restored == self.restorable;
        match self.kind {
            Kind::Tickets if !saves => {
                let seed = self.first_lost_seed.map_or(String::new(), |seed| {
                    format!("; see --replay \"{name}\" --seed {seed}")
                });
                Some(format!("{name}: a guarantee was broken (see its row){seed}"))
            }
            Kind::Rival | Kind::Ablation if self.lost == 0 && self.runs >= TELLING_RUNS => {
                Some(format!("{name}: lost no spacecraft, which is too good to be true"))
            }
            _ => None,
        }
    }
}

impl Campaign {
    /// Flies every design through the seeds.
    pub(crate) fn fly(seeds: &Range<u64>, progress: &ProgressBar) -> Self {
        let designs = Design::ALL.iter().map(|design| {
            progress.set_message(design.name());
            let row = Mutex::new(Row::new(*design));
            in_parallel(seeds, progress, |seed| {
                let flight = fly(*design, &Scene::new(seed));
                row.lock().expect("no flight panics").add(seed, &flight);
            });
            row.into_inner().expect("no flight panics")
        });
        Self {
            first_seed: seeds.start,
            designs: designs.collect(),
            rivals_lost_without_monitor: rivals_without_monitor(seeds, progress),
            convention_by_window_ms: convention_by_window(seeds, progress),
        }
    }

    /// How many flights a campaign has.
    pub(crate) fn flights(runs: u64) -> u64 {
        runs * (Design::ALL.len() as u64 + 4)
    }

    /// Everything that breaks a claim.
    pub(crate) fn complaints(&self) -> Vec<String> {
        let mut complaints: Vec<_> = self.designs.iter().filter_map(Row::complaint).collect();
        if self.rivals_lost_without_monitor > 0 {
            complaints.push("a rival lost a spacecraft with nobody in its way".into());
        }
        let flag = Design::Tickets(Variant::Without(Ablation::Quiescence)).name();
        let telling = |row: &&Row| row.name == flag && row.runs >= TELLING_RUNS;
        if self.designs.iter().find(telling).is_some_and(|row| row.commands_after_quiescence == 0) {
            complaints.push(
                "the bare flag let no command through after revocation: this harness sees nothing"
                    .into(),
            );
        }
        complaints
    }
}

/// Flies one scene in virtual time.
pub(crate) fn fly(design: Design, scene: &Scene) -> Flight {
    let stage = Stage::virtual_time(scene.ends_at);
    design.fly::<SimLocked>(scene, &stage, &Tape::off())
}

const RIVALS: [Rival; 3] = [Rival::BareCommands, Rival::SuspendedMonitor, Rival::Convention];

fn rivals_without_monitor(seeds: &Range<u64>, progress: &ProgressBar) -> u64 {
    progress.set_message("rivals without the monitor");
    let lost = AtomicU64::new(0);
    for rival in RIVALS {
        in_parallel(seeds, progress, |seed| {
            let flight = fly(Design::Rival(rival), &Scene::new(seed).without_monitor());
            lost.fetch_add(u64::from(flight.lost.is_some()), Ordering::Relaxed);
        });
    }
    lost.into_inner()
}

fn convention_by_window(seeds: &Range<u64>, progress: &ProgressBar) -> Vec<(u64, u64, u64)> {
    progress.set_message("the convention's window");
    let rows = Mutex::new(WINDOWS_MS.map(|width| (width, 0, 0)));
    in_parallel(seeds, progress, |seed| {
        let scene = Scene::new(seed);
        let flight = fly(Design::Rival(Rival::Convention), &scene);
        let mut rows = rows.lock().expect("no flight panics");
        let window = scene.monitor.map(|monitor| monitor.window.as_micros() / 1_000);
        if let Some(row) = rows.iter_mut().find(|row| Some(row.0) == window) {
            row.1 += 1;
            row.2 += u64::from(flight.lost.is_some());
        }
    });
    rows.into_inner().expect("no flight panics").to_vec()
}

/// Calls `work` for each seed, on all processors. What it gathers must not
/// depend on the order.
fn in_parallel(seeds: &Range<u64>, progress: &ProgressBar, work: impl Fn(u64) + Sync) {
    let next = AtomicU64::new(seeds.start);
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..processors {
            scope.spawn(|| {
                loop {
                    // Relaxed: only that no seed is taken twice.
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= seeds.end {
                        return;
                    }
                    work(seed);
                    progress.inc(1);
                }
            });
        }
    });
}
