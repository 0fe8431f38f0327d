//! Where the threads run: on all processors, or revoker and holders on one.

use std::hint::spin_loop;
use std::thread;
use std::time::Duration;

use faregate_devices_sim::Dice;

use crate::subject::Outcome;

/// Where the threads run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Wherever the host puts them; the revoker spins for its holders.
    AllCores,
    /// On this processor. The revoker is the more important thread, and sleeps:
    /// a command wakes it from inside, or a timer at any point of a holder.
    OneCpu(usize),
}

/// The scheduler's priorities on one processor.
const REVOKER: u8 = 20;
const HOLDER: u8 = 10;
const FAR: Duration = Duration::from_millis(50);
const THINK: u64 = 64;

impl Place {
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::AllCores => "all cores",
            Self::OneCpu(_) => "one CPU",
        }
    }

    /// How many subjects are soaked at once: each has a revoker that spins and
    /// a holder that hammers.
    pub(crate) fn subjects(self) -> usize {
        match self {
            Self::AllCores => thread::available_parallelism().map_or(1, |n| (n.get() / 2).max(1)),
            Self::OneCpu(_) => 1,
        }
    }

    /// How many threads hold passes. On one processor several, which hand it to
    /// each other when they are refused.
    pub(crate) fn holders(self) -> usize {
        match self {
            Self::AllCores => 1,
            Self::OneCpu(_) => 2,
        }
    }

    pub(crate) fn set_up_revoker(self) -> Outcome<()> {
        self.set_up(REVOKER)
    }

    pub(crate) fn set_up_holder(self) -> Outcome<()> {
        self.set_up(HOLDER)
    }

    fn set_up(self, priority: u8) -> Outcome<()> {
        match self {
            Self::AllCores => Ok(()),
            Self::OneCpu(cpu) => pin(cpu, priority),
        }
    }

    /// Waits a little for a command: the revoker, whose holders have not used
    /// what they were given.
    pub(crate) fn wait(self, turn: u32, dice: &mut Dice) {
        match self {
            Self::AllCores if turn % 4096 == 4095 => thread::yield_now(),
            Self::AllCores => spin_loop(),
            // A timer that is far away costs little; a near one comes anywhere.
            Self::OneCpu(_) if dice.below(2) > 0 => thread::park_timeout(FAR),
            Self::OneCpu(_) => thread::park_timeout(Duration::from_micros(2 + dice.below(16))),
        }
    }

    /// What a holder does between two commands.
    pub(crate) fn think(self, dice: &mut Dice) {
        if self == Self::AllCores && dice.below(4) > 0 {
            (0..dice.below(THINK)).for_each(|_| spin_loop());
        }
    }

    /// Some time more before the revocation, so that it falls anywhere.
    pub(crate) fn linger(self, dice: &mut Dice) {
        if self == Self::AllCores {
            (0..dice.below(64)).for_each(|_| spin_loop());
        }
    }

    /// Some time with the door shut, in which holders try it.
    pub(crate) fn watch(self, dice: &mut Dice) {
        match self {
            Self::AllCores => (0..dice.below(16)).for_each(|_| spin_loop()),
            Self::OneCpu(_) if dice.below(8) == 0 => {
                thread::park_timeout(Duration::from_micros(2 + dice.below(10)));
            }
            Self::OneCpu(_) => {}
        }
    }

    /// What a holder does after a refusal, before it tries again.
    pub(crate) fn after_refusal(self, dice: &mut Dice) {
        match self {
            Self::AllCores => (0..dice.below(16)).for_each(|_| spin_loop()),
            Self::OneCpu(_) => thread::yield_now(),
        }
    }

    /// Whether a command wakes the revoker.
    pub(crate) fn rings(self, dice: &mut Dice) -> bool {
        self != Self::AllCores && dice.below(8) == 0
    }
}

/// The processor for the one-processor placement, where the host permits it.
pub(crate) fn one_cpu() -> Outcome<Place> {
    thread::scope(|scope| {
        let probe = scope.spawn(|| -> Outcome<Place> {
            let place = Place::OneCpu(last_cpu()?);
            place.set_up_revoker()?;
            Ok(place)
        });
        probe.join().map_err(|_| "the probe panicked")?
    })
}

#[cfg(target_os = "linux")]
fn last_cpu() -> Outcome<usize> {
    use rustix::thread::{CpuSet, sched_getaffinity};
    let permitted = sched_getaffinity(None)?;
    let last = (0..CpuSet::MAX_CPU).rfind(|cpu| permitted.is_set(*cpu));
    Ok(last.ok_or("the host permits no CPU")?)
}

#[cfg(target_os = "linux")]
fn pin(cpu: usize, priority: u8) -> Outcome<()> {
    let report = faregate::runtime::realtime::RealTime::request().cpu(cpu).fifo(priority).apply();
    if report.is_complete() { Ok(()) } else { Err(report.to_string().into()) }
}

#[cfg(not(target_os = "linux"))]
fn last_cpu() -> Outcome<usize> {
    Err("this host has no real-time scheduling that we know of".into())
}

#[cfg(not(target_os = "linux"))]
fn pin(_: usize, _: u8) -> Outcome<()> {
    last_cpu().map(|_| ())
}
