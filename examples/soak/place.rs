//! Where the threads run: on all processors, or revoker and holders on one.

use std::hint::spin_loop;
use std::thread;
use std::time::Duration;

#[cfg(target_os = "linux")]
use faregate::runtime::realtime::{RealTime, Report};
use faregate_devices_sim::Dice;

use crate::subject::Outcome;

/// Where the threads run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Wherever the host puts them; the revoker spins for its holders. Unless
    /// they are to be ordinary threads, no other program comes between them.
    AllCores { ordinary: bool },
    /// On this processor. The revoker is the more important thread, and sleeps:
    /// a command wakes it from inside, or a timer at any point of a holder.
    OneCpu(usize),
}

/// The scheduler's priorities on one processor.
const REVOKER: u8 = 20;
const HOLDER: u8 = 10;

const FAR: Duration = Duration::from_millis(50);

/// In turns of a spin, at most.
const THINK: u64 = 64;
const LINGER: u64 = 128;

impl Place {
    /// How many subjects are soaked at once: each has a revoker that spins and
    /// a holder that hammers.
    pub(crate) fn subjects(self) -> usize {
        match self {
            Self::AllCores { .. } => {
                thread::available_parallelism().map_or(1, |n| (n.get() / 2).max(1))
            }
            Self::OneCpu(_) => 1,
        }
    }

    /// How many threads hold passes. On one processor several, which hand it to
    /// each other when they are refused.
    pub(crate) fn holders(self) -> usize {
        match self {
            Self::AllCores { .. } => 1,
            Self::OneCpu(_) => 2,
        }
    }

    pub(crate) fn set_up_revoker(self) -> Outcome<()> {
        match self {
            Self::AllCores { ordinary: true } => Ok(()),
            // The same as the holders': where there is one processor for both,
            // they take turns.
            Self::AllCores { ordinary: false } => fifo(HOLDER),
            Self::OneCpu(cpu) => pin(cpu, REVOKER),
        }
    }

    pub(crate) fn set_up_holder(self) -> Outcome<()> {
        match self {
            Self::AllCores { ordinary: true } => Ok(()),
            Self::AllCores { ordinary: false } => fifo(HOLDER),
            Self::OneCpu(cpu) => pin(cpu, HOLDER),
        }
    }

    /// Waits a little for a command: the revoker, whose holders have not used
    /// what they were given.
    pub(crate) fn wait(self, turn: u32, dice: &mut Dice) {
        match self {
            Self::AllCores { .. } if turn % 4096 == 4095 => thread::yield_now(),
            Self::AllCores { .. } => spin_loop(),
            // A timer that is far away costs little; a near one comes anywhere.
            Self::OneCpu(_) if dice.below(2) > 0 => thread::park_timeout(FAR),
            Self::OneCpu(_) => thread::park_timeout(Duration::from_micros(2 + dice.below(16))),
        }
    }

    /// What a holder does between two commands.
    pub(crate) fn think(self, dice: &mut Dice) {
        match self {
            Self::AllCores { .. } if dice.below(4) > 0 => {
                (0..dice.below(THINK)).for_each(|_| spin_loop());
            }
            Self::AllCores { .. } => {}
            // On one processor another holder may wait for its turn.
            Self::OneCpu(_) if dice.below(8) == 0 => thread::yield_now(),
            Self::OneCpu(_) => {}
        }
    }

    /// Some time more before the revocation, so that it falls anywhere.
    pub(crate) fn linger(self, dice: &mut Dice) {
        if let Self::AllCores { .. } = self {
            (0..dice.below(LINGER)).for_each(|_| spin_loop());
        }
    }

    /// Some time with the door shut, in which holders try it.
    pub(crate) fn watch(self, dice: &mut Dice) {
        match self {
            Self::AllCores { .. } => (0..dice.below(16)).for_each(|_| spin_loop()),
            Self::OneCpu(_) if dice.below(8) == 0 => {
                thread::park_timeout(Duration::from_micros(2 + dice.below(10)));
            }
            Self::OneCpu(_) => {}
        }
    }

    /// What a holder does after a refusal, before it tries again.
    /// One that was refused often in a row tries less often.
    pub(crate) fn after_refusal(self, in_a_row: u32, dice: &mut Dice) {
        let doublings = match self {
            Self::AllCores { .. } => Some(in_a_row),
            // First it lets the other holder run.
            Self::OneCpu(_) => {
                thread::yield_now();
                in_a_row.checked_sub(4)
            }
        };
        let most = doublings.map_or(0, |doublings| 16_u64 << doublings.min(6));
        (0..dice.below(most)).for_each(|_| spin_loop());
    }

    /// Whether commands wake the revoker.
    pub(crate) fn has_bell(self) -> bool {
        matches!(self, Self::OneCpu(_))
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
    permitted(RealTime::request().cpu(cpu).fifo(priority).apply())
}

#[cfg(target_os = "linux")]
fn fifo(priority: u8) -> Outcome<()> {
    permitted(RealTime::request().fifo(priority).apply())
}

#[cfg(target_os = "linux")]
fn permitted(report: Report) -> Outcome<()> {
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

#[cfg(not(target_os = "linux"))]
fn fifo(_: u8) -> Outcome<()> {
    last_cpu().map(|_| ())
}
